"""The design of controllers over HTTP: feedback, a table, loops, files by Accept, and errors by place."""

from __future__ import annotations

from io import BytesIO

import numpy as np
import pytest
from scipy.io import loadmat

from models.controller_request import design_as_asked
from models.design import parse_design
from models.presets import load_preset
from models.simulate import simulate
from tests.server.support import ask, assert_problem, preset, read_json

DESIGN = "/api/v1/controllers:design"
QUAD = "quad-bellows-glide"
DIVE = {"targets": {"glide_angle": -0.5, "speed": 0.2}, "depth": 30.0}
OPTIONS = {"trim": DIVE, "states": ["theta", "q", "w", "u"], "sample_time": 1.0}


def design(options: dict, **headers: str):
    return ask("POST", DESIGN, {"design": preset(QUAD), "options": options}, headers=headers)


def test_feedback_is_the_librarys_and_flies():
    answer = read_json(design(OPTIONS | {"step": {"state": "theta", "amount": 0.01, "duration": 60.0}}))
    assert answer["table"] is None and answer["cascade"] is None
    feedback = answer["feedback"]
    result = design_as_asked(load_preset(QUAD), OPTIONS)
    np.testing.assert_allclose(feedback["gains"], result.gains, rtol=1e-9)
    assert feedback["stable"] and feedback["margins"]["gain_high"] > 1.0
    assert feedback["response"]["flight"]["settling_time"] is not None
    document = preset(QUAD)
    document["mission"]["control"] = {"schedules": [], "controller": feedback["controller"]}
    document["mission"]["duration"] = 5.0
    assert simulate(parse_design(document)).status.name == "completed"


def test_a_table_and_loops():
    table = {"target": "glide_angle", "values": [-0.5, -0.45]}
    trim = {"targets": {"speed": 0.2}, "depth": 30.0}
    answer = read_json(design({"trim": trim, "states": ["theta", "q", "w", "u"], "table": table}))["table"]
    assert [point["value"] for point in answer["controller"]["points"]] == [-0.5, -0.45]
    loops = read_json(design({"kind": "cascade", "trim": DIVE}))["cascade"]
    assert loops["cascade"]["kind"] == "cascade" and loops["settling_time"] > 0.0


def test_files_by_accept():
    mat = design(OPTIONS, accept="application/x-matlab-data")
    assert mat.headers["content-type"] == "application/x-matlab-data"
    assert loadmat(BytesIO(mat.content))["K"].shape == (4, 4)
    script = design(OPTIONS, accept="text/x-python")
    compile(script.text, "design.py", "exec")
    assert_problem(design(OPTIONS, accept="text/html"), 406, says="application/x-matlab-data")
    refused = design({"kind": "cascade", "trim": DIVE}, accept="text/x-python")
    assert_problem(refused, 422, pointer="/options", says="only a state feedback about one trim")


@pytest.mark.parametrize(
    ("options", "pointer"),
    [
        ({"trim": {"targets": {"speed": 9.0}}}, "/options/trim/targets"),
        ({"trim": {"targets": {"sped": 0.2}}}, "/options/trim/targets/sped"),
        (OPTIONS | {"states": ["thetta"]}, "/options/states/0"),
        (OPTIONS | {"sample_time": 0.0}, "/options/sample_time"),
        (OPTIONS | {"method": "poles"}, "/options"),
        (OPTIONS | {"kind": "pid"}, "/options/kind"),
    ],
)
def test_wrong_options_are_pointed_at(options, pointer):
    assert_problem(design(options), 422, pointer=pointer)
