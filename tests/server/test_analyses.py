"""The analyses: the library's answers on the wire, and errors that point into what was sent."""

from __future__ import annotations

import math

import numpy as np
import pytest

from models.allocation import effectiveness
from models.linearize import linearize
from models.operating_point import point_of
from models.presets import load_preset
from models.trim import find_trims
from server.running import Runner
from tests.server.support import ask, assert_problem, local_app, preset, read_json

AT = "/api/v1/analyses:"
QUAD = "quad-bellows-spiral"
DIVE = {
    "Front port cell": 0.015, "Front starboard cell": 0.015, "Rear port cell": 0.028, "Rear starboard cell": 0.028,
}  # fmt: skip
STEEP = {"glide_angle": math.radians(-25.0), "speed": 0.3}


def analyze(name: str, design_id: str = QUAD, **options: object) -> dict:
    return read_json(ask("POST", AT + name, {"design": preset(design_id), "options": options}))


def test_all_trims_at_given_extensions_are_the_librarys():
    answer = analyze("trim", extensions=DIVE, depth=20.0)
    found = find_trims(load_preset(QUAD), extensions=DIVE, depth=20.0)
    assert answer["searched"] == found.searched and answer["failure"] is None
    assert [trim["pitch"] for trim in answer["trims"]] == [trim.pitch for trim in found.solutions]
    assert [trim["stable"] for trim in answer["trims"]] == [trim.stable for trim in found.solutions]
    for trim in answer["trims"]:
        assert trim["extensions"] == pytest.approx(DIVE)
        assert max(abs(value) for value in trim["residual"].values()) < 1e-8  # of 30 kg


def test_a_wanted_motion_is_met_or_the_reason_told():
    trim = analyze("trim", targets=STEEP)["trims"][0]
    assert trim["glide_angle"] == pytest.approx(STEEP["glide_angle"], abs=1e-9)
    assert trim["speed"] == pytest.approx(0.3, abs=1e-9)
    answer = analyze("trim", targets=STEEP | {"speed": 3.0})
    assert answer["trims"] == []
    failure = answer["failure"]
    assert failure["active"] and "stop" in failure["message"]
    assert {missed["target"] for missed in failure["missed"]} <= set(STEEP)
    assert failure["nearest"]["speed"] < 3.0


def test_the_document_itself_is_trimmed_as_it_starts():
    assert read_json(ask("POST", f"{AT}trim", preset(QUAD))) == analyze("trim")


def test_the_polar_has_its_best_points_on_its_curves():
    answer = analyze("polar", points=12, cycle_depth=60.0)
    glides = [trim for curve in answer["curves"] for trim in curve["trims"]]
    stable = [trim for trim in glides if trim["stable"]]
    assert answer["best_range"] in stable
    assert abs(answer["best_range"]["glide_angle"]) == min(abs(trim["glide_angle"]) for trim in stable)
    assert answer["best_energy"]["trim"] in stable
    energy = answer["best_energy"]
    assert energy["per_km"] == pytest.approx(energy["hotel"] + energy["pump"])
    assert answer["tightest_turn"]["kind"] == "spiral"
    assert answer["cycle_depth"] == 60.0


def test_the_linear_model_is_that_of_the_first_trim():
    ask_for = [{"input": "command of Front port cell", "output": "theta"}]
    answer = analyze("linearize", targets=STEEP, responses=ask_for, frequencies=[1e-3, 1.0])
    design = load_preset(QUAD)
    trim = find_trims(design, extensions=answer["trim"]["extensions"], depth=answer["trim"]["depth"]).solutions[0]
    model = linearize(design, point_of(trim))
    for name in "ABCD":
        np.testing.assert_allclose(answer["model"][name], getattr(model, name), rtol=1e-5, atol=1e-6)
    assert answer["modes"]["stable"] == answer["trim"]["stable"]
    assert answer["controllability"]["rank"] == len(answer["model"]["states"])
    response = answer["responses"][0]
    assert response["frequencies"] == [1e-3, 1.0]
    assert response["magnitude"][0] > response["magnitude"][1]


def test_an_instant_of_the_mission_and_a_root_locus():
    pointer = "/vehicle/damping/pitch"
    locus = {"pointer": pointer, "values": [0.0, 2.0, 8.0]}
    answer = analyze("linearize", "quad-bellows-glide", time=300.0)
    assert answer["trim"] is None and answer["model"]["point"]["time"] == 300.0
    answer = analyze("linearize", targets=STEEP, locus=locus)
    rows = answer["locus"]["eigenvalues"]
    assert len(rows) == 3 and answer["locus"]["failures"] == []
    # each value is trimmed to the motion that was asked for, not at the extensions of the first
    for point in answer["locus"]["points"]:
        assert math.hypot(*point["velocity"]) == pytest.approx(STEEP["speed"], abs=1e-8)
        assert point["extensions"] == pytest.approx(answer["trim"]["extensions"], abs=1e-6)
    damped = [sum(real for real, _ in row) for row in rows]
    assert damped[0] > damped[1] > damped[2]  # the sum of eigenvalues is the trace: damping only adds to it


def test_starting_extensions_do_not_move_the_trim_of_a_locus():
    """The cells that meet the targets start elsewhere: damping in pitch does not change a straight glide."""
    locus = {"pointer": "/vehicle/damping/pitch", "values": [2.0, 8.0]}
    answer = analyze("linearize", targets=STEEP, extensions={"Front port cell": 0.04}, locus=locus)
    assert answer["trim"]["extensions"]["Front port cell"] != pytest.approx(0.04, abs=1e-3)
    for point in answer["locus"]["points"]:
        assert point["extensions"] == pytest.approx(answer["trim"]["extensions"], abs=1e-6)
        assert point["pitch"] == pytest.approx(answer["trim"]["pitch"], abs=1e-8)


def test_a_locus_over_an_extension_moves_the_other_cells():
    cell = "Front port cell"
    e = analyze("trim", targets=STEEP)["trims"][0]["extensions"][cell]
    answer = analyze("linearize", targets=STEEP, locus={"pointer": f"/extensions/{cell}", "values": [e, e + 1e-4]})
    assert answer["locus"]["failures"] == []
    assert [point["extensions"][cell] for point in answer["locus"]["points"]] == pytest.approx([e, e + 1e-4])
    wrong = {"targets": STEEP, "free": [cell], "locus": {"pointer": f"/extensions/{cell}", "values": [e]}}
    wrong["free"] += ["Front starboard cell", "Rear port cell", "Rear starboard cell"]
    sent = {"design": preset(QUAD), "options": wrong}
    assert_problem(ask("POST", f"{AT}linearize", sent), 422, pointer="/options/free/0", says="takes the values")


def test_a_run_that_is_cut_off_is_told():
    app = local_app(preview_seconds=1e-3)
    sent = {"design": preset("quad-bellows-yo-yo"), "options": {"samples": 5}}
    answer = read_json(ask("POST", f"{AT}stability", sent, app=app))
    assert answer["status"] == "cancelled" and "stopped after 0.001 s" in answer["message"]
    whole = analyze("stability", "three-cell-glider", samples=5)
    assert whole["status"] == "completed" and whole["message"]
    sent = {"design": preset("quad-bellows-yo-yo"), "options": {"time": 0.0}}
    cut_off = ask("POST", f"{AT}linearize", sent, app=app)
    assert_problem(cut_off, 422, pointer="/options/time", says="stopped after 0.001 s")


def heavy_with_parts(count: int) -> dict:
    """The quad-bellows glider with weightless parts besides, more than are accepted unless settings say so."""
    design = preset(QUAD)
    parts = design["vehicle"]["components"]
    rigid = next(part for part in parts if part["name"] == "Trim ballast")
    parts += [rigid | {"name": f"Part {k}", "mass": 0.0} for k in range(count - len(parts))]
    design["mission"]["duration"] = 20.0
    return design


def test_settings_say_how_many_parts_a_design_may_have():
    many = heavy_with_parts(266)
    trim = {"targets": STEEP}
    locus = {"pointer": "/vehicle/damping/pitch", "values": [2.0, 8.0]}
    feedback = {
        "trim": trim, "states": ["theta", "u", "w", "q"], "step": {"amount": 0.01, "duration": 5.0},
        "departures": {"theta": 0.01}, "recovery_duration": 5.0,
    }  # fmt: skip
    table = {"target": "glide_angle", "values": [-0.45, -0.44]}
    asked = [
        (f"{AT}trim", trim), (f"{AT}polar", {"points": 3}), (f"{AT}stability", {"samples": 3}),
        (f"{AT}linearize", trim | {"locus": locus}), (f"{AT}linearize", {"time": 10.0}), (f"{AT}allocation", {}),
        ("/api/v1/controllers:design", feedback), ("/api/v1/controllers:design", {"kind": "cascade", "trim": trim}),
        ("/api/v1/controllers:design", {"trim": {"targets": {"speed": 0.3}}, "states": ["theta", "q"], "table": table}),
    ]  # fmt: skip
    app = local_app(max_components=512)
    for path, options in asked:
        sent = {"design": many, "options": options}
        answer = read_json(ask("POST", path, sent, app=app))
        assert "errors" not in answer, (path, options, answer)
        assert not (answer.get("locus") or {}).get("failures"), answer["locus"]["failures"]
        assert_problem(ask("POST", path, sent), 422, pointer="/design/vehicle/components")


@pytest.mark.parametrize("name", ["trim", "polar", "linearize", "stability", "allocation"])
def test_analyses_wait_for_their_turn(name, monkeypatch):
    """As many at once as there are processors, not as many as there are threads."""
    ran = []
    run = Runner.run

    async def counted(self, request, work):
        ran.append(request.url.path)
        return await run(self, request, work)

    monkeypatch.setattr(Runner, "run", counted)
    options = {"points": 2} if name == "polar" else {}
    ask("POST", AT + name, {"design": preset(), "options": options})
    assert ran == [f"{AT}{name}"]


def test_a_glider_that_floats_is_told_how_to_name_a_motion():
    sent = {"design": preset("three-cell-glider"), "options": {}}
    problem = assert_problem(ask("POST", f"{AT}linearize", sent), 422, pointer="/options/extensions")
    hint = problem["errors"][0]["hint"]
    assert all(words in hint for words in ("options.targets", "--target", "options.time", "--time"))
    assert analyze("linearize", "three-cell-glider", targets={"glide_angle": STEEP["glide_angle"]})["trim"]


def test_no_free_cells_named_are_all():
    every = analyze("trim", targets=STEEP)
    assert analyze("trim", targets=STEEP, free=None) == analyze("trim", targets=STEEP, free=[]) == every


def test_stability_is_followed_along_the_mission():
    answer = analyze("stability", "three-cell-glider", samples=20, max_points=50)
    assert answer["status"] == "completed"
    assert len(answer["times"]) == 50 and answer["times"][-1] == 130.0
    assert len(answer["growth"]) == 20
    worst = {extreme["name"]: extreme for extreme in answer["extremes"]}
    assert worst["hydrostatic_margin"]["value"] <= min(answer["hydrostatic_margin"])


def test_cells_and_what_is_wanted_of_them():
    answer = analyze("allocation", wanted={"heave": 2.0, "roll": 0.3})
    assert answer["holds"] == ["heave", "pitch", "roll"]
    cells = effectiveness(load_preset(QUAD))
    np.testing.assert_allclose(answer["matrix"], cells.matrix)
    reached = answer["allocation"]["reached"]
    assert (reached["heave"], reached["roll"]) == pytest.approx((2.0, 0.3), abs=1e-3)
    too_much = analyze("allocation", wanted={"heave": 20.0})["allocation"]
    assert too_much["short"] == ["heave"] and len(too_much["at_stop"]) == 4


@pytest.mark.parametrize(
    ("name", "options", "pointer"),
    [
        ("trim", {"extensions": {"Tail": 0.0}}, "/options/extensions/Tail"),
        ("trim", {"extensions": {"Front port cell": 1.0}}, "/options/extensions/Front port cell"),
        ("trim", {"targets": {"speed": 0.3}, "free": ["Tail"]}, "/options/free/0"),
        ("trim", {"targets": {"sped": 0.3}}, "/options/targets/sped"),
        ("trim", {"targets": {"speed": -1.0}}, "/options/targets/speed"),
        ("trim", {"depth": 500.0}, "/options/depth"),
        ("trim", {"search": {"banks": [2.0]}}, "/options/search/banks/0"),
        ("trim", {"search": {"angle_step": 2.0}}, "/options/search/angle_step"),
        ("polar", {"points": 1}, "/options/points"),
        ("polar", {"cells": ["Tail"]}, "/options/cells/0"),
        ("linearize", {"time": 1e6}, "/options/time"),
        ("linearize", {"targets": {"speed": 9.0}}, "/options/targets"),
        ("allocation", {"effort": {"Tail/1": 1.0}}, "/options/effort/Tail~11"),
        (
            "linearize", {"targets": STEEP, "locus": {"pointer": "/vehicle/damping/nose", "values": [1.0]}},
            "/options/locus/pointer",
        ),
        (
            "linearize", {"targets": STEEP, "locus": {"pointer": "/extensions/Tail", "values": [1.0]}},
            "/options/locus/pointer",
        ),
        (
            "linearize", {"targets": STEEP, "locus": {"pointer": "/mission/duration", "values": [-1.0]}},
            "/options/locus/pointer",
        ),
        (
            "linearize", {"targets": STEEP, "responses": [{"input": "wind", "output": "theta"}]},
            "/options/responses/0/input",
        ),
        ("linearize", {"targets": STEEP, "locus": {"pointer": "/name", "values": [1.0]}}, "/options/locus/pointer"),
        ("stability", {"samples": 1}, "/options/samples"),
        ("allocation", {"cells": ["Tail"]}, "/options/cells/0"),
        ("allocation", {"effort": {"Tail": 1.0}}, "/options/effort/Tail"),
    ],
)  # fmt: skip
def test_wrong_options_are_pointed_at(name, options, pointer):
    sent = {"design": preset(QUAD), "options": options}
    assert_problem(ask("POST", AT + name, sent), 422, pointer=pointer)


@pytest.mark.parametrize("name", ["trim", "polar", "linearize", "stability", "allocation"])
def test_a_wrong_design_is_pointed_at_where_it_was_sent(name):
    design = preset(QUAD)
    design["mission"]["duration"] = -1.0
    assert_problem(ask("POST", AT + name, design), 422, pointer="/mission/duration")
    assert_problem(ask("POST", AT + name, {"design": design}), 422, pointer="/design/mission/duration")
