"""The preview: the same numbers as the library's, thinned, in three kinds, within its limits."""

from __future__ import annotations

import asyncio
import dataclasses
import math
import time
from contextlib import asynccontextmanager

import numpy as np
import pytest

from models.design import parse_design
from models.presets import load_preset, preset_ids
from models.run import Run
from models.simulate import Control, simulate
from server.answers import json_answer, series_answer
from server.app import create_app
from server.examples.build import THIRD_CELL, example_design
from server.preview import run_preview
from server.routes import simulations
from server.running import Runner
from server.settings import Settings
from tests.server.support import EDIT, PREVIEW, ask, assert_problem, local_app, preset, read_json
from tests.server.test_errors import pistons


def slow():
    """Return a design whose run takes seconds: two million steps of fixed size."""
    design = preset("canete-dual-bellows")
    design["mission"]["solver"] |= {"method": "rk4", "step": design["mission"]["duration"] / 2e6}
    return design


def finite(values):
    """What JSON holds: null for a number that is not finite."""
    return [None if math.isnan(value) else value for value in values.tolist()]


@pytest.mark.parametrize("preset_id", preset_ids())
def test_answers_are_the_librarys_own(preset_id):
    run = simulate(load_preset(preset_id))
    body = {"design": preset(preset_id), "options": {"max_points": len(run.times)}}
    answer = read_json(ask("POST", PREVIEW, body))
    assert answer["status"] == run.status.name and answer["message"] == run.status.value
    # JSON keeps every digit, hence equality
    assert answer["columns"]["t"] == run.data["time"].values.tolist()
    assert set(answer["columns"]) == {"t", *run.variables}
    for name in run.variables:
        assert answer["columns"][name] == finite(run.data[name].values)
    assert [cell["name"] for cell in answer["cells"]] == run.data["cell"].values.tolist()
    for cell in answer["cells"]:
        for name in run.cell_variables:
            assert cell[name] == run.data[name].sel(cell=cell["name"]).values.tolist()
    assert answer["final"] == {name: None if math.isnan(value) else value for name, value in run.final.items()}
    assert answer["energy"]["exchanged"] == run.energy_exchanged
    assert answer["energy"]["relative_residual"] == run.relative_residual
    assert answer["units"] == {"t": "s"} | {k: u for k, (u, _) in (run.variables | run.cell_variables).items()}
    assert answer["statistics"]["steps"] == run.statistics["steps"]


def test_arrays_are_written_as_lists_are():
    """To the letter, whatever the magnitude: shortest decimals that give the same numbers back, null for the others."""
    rng = np.random.default_rng(1)
    odd = [0.0, -0.0, 1.0, 1e15, 1e16, 1e22, 1e-5, 1e-7, 5e-324, 1.7976931348623157e308, np.nan, np.inf, -np.inf]
    values = np.array([*odd, *rng.normal(size=1000) * 10.0 ** rng.integers(-300, 300, 1000)])
    content = {"columns": {"t": values}, "cells": [{"name": "A", "volume": values[::2][:9].copy()}], "none": None}
    lists = {
        "columns": {"t": values.tolist()},
        "cells": [{"name": "A", "volume": values[::2][:9].tolist()}],
        "none": None,
    }
    assert series_answer(content).body == json_answer(lists).body


def test_thinned_curves_keep_ends_and_extremes():
    run = simulate(load_preset("three-cell-glider"))
    columns = ["x", "z", "theta", "u"]
    options = {"max_points": 40, "columns": [*columns, "z"]}
    answer = read_json(ask("POST", PREVIEW, {"design": preset(), "options": options}))
    assert set(answer["columns"]) == {"t", *columns} and set(answer["units"]) == {"t", *columns}
    assert [set(cell) for cell in answer["cells"]] == [{"name", "unit"}] * 4
    t = np.array(answer["columns"]["t"])
    assert t.size == 40 and (np.diff(t) > 0).all()
    for name in columns:
        whole = run.data[name].values
        assert min(answer["columns"][name]) == whole.min() and max(answer["columns"][name]) == whole.max()
        assert np.isin(answer["columns"][name], whole).all()


def test_events_are_told_in_words():
    design = preset()
    design["mission"]["environment"]["bed_depth"] = 1.5
    answer = read_json(ask("POST", PREVIEW, design))
    assert answer["status"] == "bed" and "bed" in answer["message"]
    event = answer["events"][-1]
    assert event["kind"] == "bed" and event["cell"] is None and "reached the bed at" in event["label"]
    assert event["time"] == answer["final"]["t"]


@pytest.mark.parametrize("max_points", [None, 25])
def test_csv(max_points):
    sent = {"design": preset(), "options": {"max_points": max_points}}
    answer = ask("POST", PREVIEW, sent, headers={"accept": "text/csv"})
    assert answer.headers["content-type"].startswith("text/csv")
    header, *rows = answer.text.splitlines()
    assert header.startswith("t [s],x [m],z [m]") and "volume of Battery slide [m3]" in header
    run = simulate(load_preset("three-cell-glider"))
    assert len(rows) == (max_points or run.data.sizes["time"])
    last = [float(value) for value in rows[-1].split(",")]
    # CSV has twelve digits
    assert last[1:3] == pytest.approx([run.final["x"], run.final["z"]], rel=1e-11)


@pytest.mark.parametrize("max_points", [None, 25])
def test_netcdf(tmp_path, max_points):
    sent = {"design": preset(), "options": {"max_points": max_points}}
    answer = ask("POST", PREVIEW, sent, headers={"accept": "application/x-netcdf, text/csv;q=0.5"})
    assert answer.headers["content-type"] == "application/x-netcdf"
    path = tmp_path / "run.nc"
    path.write_bytes(answer.content)
    stored, run = Run.from_netcdf(path), simulate(load_preset("three-cell-glider"))
    assert stored.design == run.design and stored.status is run.status
    assert stored.data.sizes["time"] == (max_points or run.data.sizes["time"])
    assert stored.final == run.final


@pytest.mark.parametrize(
    ("accept", "kind"),
    [
        ("*/*", "application/json"),
        ("application/*", "application/json"),
        ("text/*;q=0.3, application/x-netcdf;q=0.2", "text/csv; charset=utf-8"),
        ("text/html, application/json;q=0.9, */*;q=0.8", "application/json"),
        ("application/json;q=0, */*", "text/csv; charset=utf-8"),
    ],
)
def test_accept_chooses(accept, kind):
    sent = {"design": preset("canete-dual-bellows"), "options": {"max_points": 3}}
    assert ask("POST", PREVIEW, sent, headers={"accept": accept}).headers["content-type"] == kind


@pytest.mark.parametrize("accept", ["image/png", "application/json;q=0", "application/json;q=x", "nonsense"])
def test_other_kinds_are_not_acceptable(accept):
    assert_problem(ask("POST", PREVIEW, preset(), headers={"accept": accept}), 406)


@pytest.mark.parametrize(
    ("options", "pointer"),
    [
        ({"max_points": 1}, "/options/max_points"),
        ({"max_points": 100_001}, "/options/max_points"),
        ({"max_points": "10"}, "/options/max_points"),
        ({"max_points": 10.5}, "/options/max_points"),
        ({"columns": "x"}, "/options/columns"),
        ({"columns": ["x", "depth"]}, "/options/columns/1"),
        ({"points": 5}, "/options/points"),
        ([], "/options"),
    ],
)
def test_wrong_options_are_pointed_at(options, pointer):
    assert_problem(ask("POST", PREVIEW, {"design": preset(), "options": options}), 422, pointer=pointer)


def test_a_third_cell_is_added_and_compared():
    """The worked example: add a cell that makes the glider heavier, and see both glides."""
    design = example_design().model_dump(mode="json")
    schedule = {"cell": THIRD_CELL["name"], "points": [{"time": 0.0, "extension": -0.005}]}
    patch = [
        {"op": "add", "path": "/vehicle/components/-", "value": THIRD_CELL},
        {"op": "add", "path": "/mission/control/schedules/-", "value": schedule},
    ]
    answer = read_json(ask("POST", EDIT, {"design": design, "patch": patch}))
    edited = answer["design"]
    assert answer["mass_properties"]["components"][-1]["name"] == THIRD_CELL["name"]
    before, after = (read_json(ask("POST", PREVIEW, document)) for document in (design, edited))
    assert [cell["name"] for cell in after["cells"]] == [*(c["name"] for c in before["cells"]), THIRD_CELL["name"]]
    # the cell weighs what it displaces; its piston of 1e-3 m2 withdrawn by 5 mm takes 5 cm3 away
    environment = design["mission"]["environment"]
    lost = environment["water"]["density"] * environment["gravity"] * 1e-3 * 0.005
    at_start = [preview["columns"]["net_buoyancy"][1] for preview in (before, after)]
    # the other cells follow their commands within 1e-8 of a stroke of 1 cm: 1e-8 N for their sections of 1e-3 m2
    assert at_start[1] - at_start[0] == pytest.approx(-lost, abs=1e-8)
    assert after["columns"]["z"][-1] > before["columns"]["z"][-1] + 0.1
    assert edited == parse_design(edited).model_dump(mode="json")


def test_sixty_four_cells_are_simulated():
    design = preset()
    design["vehicle"]["components"] += pistons(64 - len(design["vehicle"]["components"]))
    answer = read_json(ask("POST", PREVIEW, design))
    assert len(design["vehicle"]["components"]) == 64
    assert len(answer["cells"]) == 61 and answer["status"] in {"completed", "bed", "surface"}


def test_a_run_that_computes_too_long_is_stopped_and_kept():
    settings = Settings(host="127.0.0.1", preview_seconds=0.05)
    began = time.perf_counter()
    preview = run_preview(parse_design(slow()), settings, Control())
    # 0.05 s of computing and what comes before and after, on a busy machine
    assert time.perf_counter() - began < 2.0
    assert preview.run.status.name == "cancelled"
    assert "stopped after 0.05 s of computing" in preview.message
    assert preview.run.data.sizes["time"] >= 2


class Client:
    """A request whose client leaves after some seconds."""

    def __init__(self, patience):
        self.patience = patience

    async def receive(self):
        await asyncio.sleep(self.patience)
        return {"type": "http.disconnect"}


def work_until_cancelled(control):
    """Stand in for a long run; return whether it was cancelled."""
    deadline = time.perf_counter() + 5.0
    while not control.flags[0] and time.perf_counter() < deadline:
        time.sleep(0.005)
    return bool(control.flags[0])


def test_a_client_that_leaves_stops_its_run():
    async def scenario():
        return await Runner().run(Client(0.05), work_until_cancelled)

    assert asyncio.run(scenario())


def test_a_request_that_is_cancelled_stops_its_run():
    seen = []

    def work(control):
        seen.append(control)
        return work_until_cancelled(control)

    async def scenario():
        task = asyncio.create_task(Runner().run(Client(60.0), work))
        while not seen:
            await asyncio.sleep(0.005)
        task.cancel()
        with pytest.raises(asyncio.CancelledError):
            await task

    asyncio.run(scenario())
    assert seen[0].flags[0]


def test_a_server_that_stops_cancels_what_runs():
    app = local_app()

    async def scenario():
        async with app.router.lifespan_context(app):
            task = asyncio.create_task(app.state.runner.run(Client(60.0), work_until_cancelled))
            await asyncio.sleep(0.05)
        return await task

    assert asyncio.run(scenario())


def test_a_lifespan_given_from_outside_is_entered_and_left():
    seen = []

    @asynccontextmanager
    async def outer(app):
        seen.append("in")
        yield
        seen.append("out")

    app = create_app(Settings(host="127.0.0.1"), lifespan=outer)

    async def live():
        async with app.router.lifespan_context(app):
            assert seen == ["in"]

    asyncio.run(live())
    assert seen == ["in", "out"]


def test_numbers_that_are_not_finite_become_null(monkeypatch):
    def broken(design, settings, control):
        preview = run_preview(design, settings, control)
        values = {name: column.copy() for name, column in preview.run.values.items()}
        values["lift"][3:] = np.inf
        values["drag"][:] = np.nan
        return dataclasses.replace(preview, run=dataclasses.replace(preview.run, values=values))

    monkeypatch.setattr(simulations, "run_preview", broken)
    answer = read_json(ask("POST", PREVIEW, {"design": preset(), "options": {"max_points": 10}}))
    assert set(answer["columns"]["drag"]) == {None} and answer["columns"]["lift"][-1] is None
    assert answer["final"]["lift"] is None


def test_a_preview_waits_for_the_kernel(monkeypatch):
    compiled = []
    monkeypatch.setattr("server.preview.kernel_is_ready", lambda: False)
    monkeypatch.setattr("server.preview.warm_kernel", lambda: compiled.append(True))
    assert ask("POST", PREVIEW, preset("canete-dual-bellows")).status_code == 200
    assert compiled == [True]
