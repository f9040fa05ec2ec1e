"""The design of controllers over HTTP: feedback, a table, loops, files by Accept, and errors by place."""

from __future__ import annotations

import json
from io import BytesIO

import numpy as np
import pytest
from scipy.io import loadmat

from models.controller_request import design_as_asked
from models.design import parse_design
from models.limits import DEFAULT_LIMITS
from models.presets import load_preset
from models.problems import DesignError
from models.simulate import Control, simulate
from server.controlling import design_for
from server.schemas_control import ControllerDesignOptions
from tests.server.support import ask, assert_problem, local_app, preset, read_json

DESIGN = "/api/v1/controllers:design"
QUAD = "quad-bellows-glide"
DIVE = {"targets": {"glide_angle": -0.5, "speed": 0.2}, "depth": 30.0}
OPTIONS = {"trim": DIVE, "states": ["theta", "q", "w", "u"], "sample_time": 1.0}

TABLE = {"target": "pitch", "values": [-0.5, -0.4]}
UNUSED = {
    "cells": ["Front port cell"], "states": ["theta"], "table": TABLE, "step": {"amount": 0.1}, "share": 0.3,
    "shares": {"Front port cell": 0.1}, "integrals": 1, "integral_time": 20.0, "deviations": {"theta": 0.1},
    "departures": {"theta": 0.1}, "recovery_duration": 20.0,
}  # fmt: skip
"""Options that first gains of loops have no use for."""


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
        (OPTIONS | {"departures": {"speed": 0.1}}, "/options/departures/speed"),
        (OPTIONS | {"departures": {"theta": 0.0}}, "/options/departures/theta"),
        (OPTIONS | {"departures": {"theta": 4.0}}, "/options/departures"),
        (OPTIONS | {"step": {"amount": 0.01, "duration": 1e5}, "sample_time": 1e-3}, "/options/step/duration"),
        (
            {"trim": DIVE, "table": {"target": "pitch", "values": [-1 + 0.01 * k for k in range(51)]}},
            "/options/table/values",
        ),
        (OPTIONS | {"table": TABLE, "step": {"amount": 0.01}}, "/options/step"),
        (OPTIONS | {"table": TABLE, "departures": {"theta": 0.01}}, "/options/departures"),
        *(({"kind": "cascade", "trim": DIVE} | {name: value}, f"/options/{name}") for name, value in UNUSED.items()),
    ],
)
def test_wrong_options_are_pointed_at(options, pointer):
    assert_problem(design(options), 422, pointer=pointer)


def test_defaults_may_be_sent_for_loops():
    sent = ControllerDesignOptions.model_validate({"kind": "cascade", "trim": DIVE}).model_dump(mode="json")
    assert read_json(design(sent))["cascade"]["settling_time"] > 0.0


def test_the_way_back_from_a_departure():
    asked = {"departures": {"theta": 0.01, "q": 0.001}, "recovery_duration": 60.0}
    feedback = read_json(design(OPTIONS | asked))["feedback"]
    assert feedback["response"] is None
    recovery = feedback["recovery"]
    assert recovery["state"] == "theta" and recovery["start"] - recovery["goal"] == pytest.approx(0.01)
    assert recovery["flown"][-1] == pytest.approx(recovery["goal"], abs=1e-3)


def test_flights_keep_within_the_limits_of_a_preview():
    app = local_app(preview_numbers=10_000)
    options = OPTIONS | {"step": {"amount": 0.01, "duration": 600.0}}
    sent = {"design": preset(QUAD), "options": options}
    assert_problem(ask("POST", DESIGN, sent, app=app), 422, pointer="/options/step/duration", says="watch for less")
    # the mission of the design itself is not flown, however long it is
    options["step"]["duration"] = 5.0
    assert read_json(ask("POST", DESIGN, sent, app=app))["feedback"]["response"]["status"] == "completed"


@pytest.mark.parametrize(
    "more", [{"step": {"amount": 0.01, "duration": 10.0}}, {"departures": {"theta": 0.01}}, {"table": TABLE}]
)
def test_work_stops_when_the_client_leaves(more):
    control = Control()
    control.cancel()
    options = ControllerDesignOptions.model_validate_json(json.dumps(OPTIONS | more))
    glider = load_preset(QUAD)
    if "table" in more:
        with pytest.raises(DesignError, match="stopped"):
            design_for(glider, options, DEFAULT_LIMITS, flown_within=DEFAULT_LIMITS, control=control)
        return
    result = design_for(glider, options, DEFAULT_LIMITS, flown_within=DEFAULT_LIMITS, control=control)
    assert (result.response or result.recovery).run.status.name == "cancelled"
