"""The consequences of an edit against the library itself, the states in which they fail, and their way to the page."""

from __future__ import annotations

import json
import math
from contextlib import closing
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from models.assemble import assemble
from models.design import DeclaredMass, Design, parse_design
from models.energy import energy_bill
from models.mass_properties import trim_ballast
from models.presets import load_preset
from models.problems import Problem
from models.run import Run
from models.simulate import simulate
from models.stability import stability_over
from models.trim import find_trims
from server.answers import series_json
from studio.cell_reach import NEAR_STOP, spans_where
from studio.consequence_warnings import Warned, warnings_of
from studio.consequences import (
    Consequences,
    LiveConsequences,
    consequences_document,
    consequences_of,
)
from studio.held_glides import COMPILING
from studio.holds import MOST_HOLDS, holds_of, scheduled_holds, spans_of
from studio.run_marks import MOST_SPANS
from studio.session import Session
from tests.studio.conftest import Studio, wait_until
from tests.studio.spiral import spiral


def changed(design: Design, **paths: Any) -> Design:
    """Return a design with members set by paths, `__` between their names or indices."""
    document = design.model_dump(mode="json")
    for path, value in paths.items():
        *way, last = path.split("__")
        node: Any = document
        for name in way:
            node = node[int(name)] if isinstance(node, list) else node[name]
        node[int(last) if isinstance(node, list) else last] = value
    return parse_design(document)


def scheduled(design: Design, *points: dict[str, Any]) -> Design:
    return changed(design, mission__control__schedules=[{"cell": "Front bellows", "points": list(points)}])


def found_of(design: Design) -> tuple[Consequences, Run]:
    assembly, run = assemble(design), simulate(design)
    return consequences_of(assembly, run), run


def messages(found: Consequences, severity: str) -> str:
    return "\n".join(warned.problem.message for warned in found.warnings if warned.severity == severity)


@pytest.mark.usefixtures("kernel")
class TestTheTrims:
    def test_are_those_of_the_library_at_what_is_held(self, dual_bellows: Design) -> None:
        found, _ = found_of(dual_bellows)
        assert [glide.hold.spans for glide in found.glides] == [((0.0, 10.0),), ((10.0, 20.0),)]
        for glide in found.glides:
            search = find_trims(dual_bellows, extensions=glide.hold.extensions, depth=glide.depth)
            assert glide.trim is not None and glide.trim.stable
            told = {trim.growth: trim for trim in search.solutions}[glide.trim.growth]
            assert (told.pitch, told.speed, told.sink_rate) == (
                glide.trim.pitch, glide.trim.speed, glide.trim.sink_rate,
            )  # fmt: skip
            assert len(glide.others) == len(search.solutions) - 1

    def test_turn_where_the_run_turns(self) -> None:
        found, run = found_of(load_preset("quad-bellows-spiral"))
        glide = found.glides[-1]
        at = int(np.searchsorted(run.values["z"], glide.depth))
        assert glide.trim is not None and glide.trim.turn_radius is not None
        # the run has settled, but for density, which changes as it sinks
        assert glide.trim.turn_radius == pytest.approx(run.values["turn_radius"][at], rel=5e-4)
        assert glide.trim.pitch == pytest.approx(run.values["theta"][at], abs=1e-5)

    def test_are_missing_where_weight_and_buoyancy_are_equal(self, dual_bellows: Design) -> None:
        still = changed(trim_ballast(dual_bellows)[0], mission__control__schedules=[], mission__initial__extensions={})
        found, _ = found_of(still)
        (glide,) = found.glides
        assert glide.trim is None and glide.rest is not None
        assert glide.why is not None and "weighs what it displaces" in glide.why
        assert "no steady glide with the cells as held 0 to 20 s" in messages(found, "warn")
        document = json.loads(series_json(consequences_document(found)))
        assert document["holds"][0]["trim"] is None
        assert document["holds"][0]["rest"]["pitch"] == pytest.approx(glide.rest.pitch)

    def test_upside_down_ones_are_warned_of(self, dual_bellows: Design) -> None:
        found, _ = found_of(changed(dual_bellows, vehicle__mass_properties__center_of_mass__2=-0.001))
        assert all(glide.trim is not None and abs(glide.trim.pitch) > math.pi / 2 for glide in found.glides)
        assert messages(found, "bad").count("upside down") == 2

    def test_unstable_ones_are_warned_of_with_their_growth(self, dual_bellows: Design) -> None:
        found, _ = found_of(dual_bellows)
        first = found.glides[0]
        assert first.trim is not None
        loose = replace(first, trim=replace(first.trim, growth=0.1))
        (warned,) = warnings_of(dual_bellows, [loose], None, (), end=20.0)
        assert warned.severity == "bad" and warned.times == ((0.0, 10.0),)
        assert warned.problem.message.startswith("unstable glide")
        assert f"double in {math.log(2.0) / 0.1:.3g} s" in warned.problem.message

    def test_holds_beyond_the_end_of_the_run_are_neither_trims_nor_warned_of(self, dual_bellows: Design) -> None:
        design = changed(dual_bellows, mission__duration=5.0)
        found = consequences_of(assemble(dual_bellows), simulate(design))
        flown, missed = found.glides
        assert flown.hold.reached and flown.hold.spans == ((0.0, 5.0),)
        assert not missed.hold.reached and missed.trim is None and missed.why == "not reached, the run ended at 5 s"
        assert not any("10 to 20 s" in warned.problem.message for warned in found.warnings)
        assert [hold["reached"] for hold in consequences_document(found)["holds"]] == [True, False]

    def test_wait_for_the_compiler_without_a_warning(self, dual_bellows: Design) -> None:
        found = consequences_of(assemble(dual_bellows), None, analyses=False)
        assert [glide.why for glide in found.glides] == [COMPILING, COMPILING]
        assert consequences_document(found)["analyses"] == "compiling"
        assert not any("steady glide" in warned.problem.message for warned in found.warnings)


@pytest.mark.usefixtures("kernel")
class TestFloating:
    def test_net_buoyancy_and_centres_are_those_of_the_run(self, dual_bellows: Design) -> None:
        found, run = found_of(dual_bellows)
        for glide, time in zip(found.glides, (9.0, 19.0), strict=True):
            at = int(np.searchsorted(run.times, time))
            assert glide.reserve.now == pytest.approx(run.values["net_buoyancy"][at], abs=1e-9)
            for axis, offset in zip("xz", glide.offset[[0, 2]], strict=True):
                apart = run.values[f"com_{axis}"][at] - run.values[f"cob_{axis}"][at]
                assert offset == pytest.approx(apart, abs=1e-12)

    def test_the_reserve_is_the_volume_left_to_the_stops(self, dual_bellows: Design) -> None:
        found, _ = found_of(dual_bellows)
        reserve = found.glides[0].reserve
        cells = [part for _, part in dual_bellows.vehicle.actuated]
        ends = []
        for k in (0, 1):
            at_stops = {cell.name: cell.stroke[k] for cell in cells}
            there = changed(dual_bellows, mission__control__schedules=[], mission__initial__extensions=at_stops)
            ends.append(simulate(changed(there, mission__duration=0.1)).values["net_buoyancy"][0])
        assert (reserve.least, reserve.most) == (pytest.approx(ends[0], abs=1e-9), pytest.approx(ends[1], abs=1e-9))
        assert reserve.share == pytest.approx((reserve.now - ends[0]) / (ends[1] - ends[0]))

    def test_too_little_reserve_is_warned_of(self, dual_bellows: Design) -> None:
        found, _ = found_of(dual_bellows)
        span = found.glides[0].reserve.most - found.glides[0].reserve.least
        declared = dual_bellows.vehicle.mass_properties
        assert isinstance(declared, DeclaredMass)
        heavy, _ = found_of(changed(dual_bellows, vehicle__mass_properties__mass=declared.mass + span / 9.81))
        assert heavy.glides[0].reserve.most < 0.0
        assert "as light as its stops allow net buoyancy is -" in messages(heavy, "bad")
        assert not messages(found, "bad")


@pytest.mark.usefixtures("kernel")
class TestMarginsEnergyAndStops:
    def test_margins_are_those_of_the_library(self) -> None:
        design = spiral(duration=120.0)
        found, run = found_of(design)
        whole = stability_over(run, 1)
        assert found.margins is not None
        at = np.searchsorted(run.times, found.margins.times)
        for name, values in found.margins.series.items():
            np.testing.assert_allclose(values, getattr(whole, name)[at], rtol=1e-12, atol=1e-15)
        told = consequences_document(found)["margins"]["worst"]
        assert told["yaw_margin"]["value"] == np.nanmin(found.margins.series["yaw_margin"])
        lost = next(w for w in found.warnings if "margin in yaw" in w.problem.message)
        assert lost.times[0][0] <= told["yaw_margin"]["time"] <= lost.times[-1][1]

    def test_energy_is_the_bill_of_the_run(self) -> None:
        found, run = found_of(spiral(duration=60.0))
        assert found.energy == energy_bill(run)
        assert consequences_document(found)["energy"]["whole"]["total"] == pytest.approx(
            run.values["battery_energy"][-1], rel=1e-9
        )

    def test_a_planar_run_has_no_bill_and_no_lateral_margins(self, dual_bellows: Design) -> None:
        found, _ = found_of(dual_bellows)
        document = consequences_document(found)
        assert document["energy"] is None
        assert set(document["margins"]["series"]) == {"hydrostatic_margin", "pitch_stiffness", "pitch_margin"}

    def test_a_cell_at_its_stop_is_told_with_its_times_and_its_field(self, dual_bellows: Design) -> None:
        index, cell = dual_bellows.vehicle.actuated[0]
        ends = cell.stroke
        found, run = found_of(scheduled(dual_bellows, {"time": 2.0, "extension": ends[1]}))
        reach = found.cells[0].high
        ((start, end),) = reach.at
        extension = run.cell_values["extension"][:, 0]
        assert extension[np.searchsorted(run.times, start)] == pytest.approx(ends[1], abs=1e-6 * (ends[1] - ends[0]))
        assert 2.0 <= start < end == run.times[-1]
        (note,) = (w for w in found.warnings if "stop" in w.problem.message)  # and none that it comes near
        assert note.times == reach.at
        assert note.problem.pointer == f"/vehicle/components/{index}/extension_range"
        assert note.problem.limit == ends[1]
        told = consequences_document(found)["cells"][0]
        assert (told["side"], told["nearest"], told["near"], told["at"]) == ("upper", pytest.approx(0.0), True, True)

    @pytest.mark.parametrize(("share", "near"), [(0.06, False), (0.04, True), (0.001, True)])
    def test_a_cell_near_its_stop_is_told_with_its_times_and_its_field(
        self, dual_bellows: Design, share: float, near: bool
    ) -> None:
        index, cell = dual_bellows.vehicle.actuated[0]
        low, high = cell.stroke
        asked = high - share * (high - low)
        found, run = found_of(scheduled(dual_bellows, {"time": 2.0, "extension": asked}))
        told = consequences_document(found)
        assert told["near_stop"] == NEAR_STOP
        assert (told["cells"][0]["near"], told["cells"][0]["at"]) == (near, False)
        notes = [w for w in found.warnings if "stop" in w.problem.message]
        assert len(notes) == near
        for note in notes:
            assert note.severity == "note"
            assert f"comes within {100 * share:.2g} % of its stroke of its upper stop" in note.problem.message
            assert note.problem.pointer == f"/vehicle/components/{index}/extension_range"
            assert note.problem.limit == pytest.approx(high - NEAR_STOP * (high - low))
            ((start, end),) = note.times
            inside = (run.times >= start) & (run.times <= end)
            beyond = run.cell_values["extension"][:, 0] >= note.problem.limit
            np.testing.assert_array_equal(inside, beyond)

    def test_every_visit_to_a_stop_is_told(self, dual_bellows: Design) -> None:
        _, cell = dual_bellows.vehicle.actuated[0]
        low, high = cell.stroke
        points = [
            {"time": k + 0.5 * back, "extension": low + 0.1 * (high - low) if back else high}
            for k in range(20) for back in (0, 1)
        ]  # fmt: skip
        found, run = found_of(scheduled(dual_bellows, *points))
        visits = math.ceil(run.times[-1])  # it surfaces before the end
        assert visits > 14
        (note,) = (w for w in found.warnings if "upper stop" in w.problem.message)
        document = note.as_dict()
        assert (len(document["times"]), document["more_times"]) == (visits, 0)

    def test_stretches_that_are_too_many_to_send_are_counted(self) -> None:
        spans = tuple((2.0 * k, 2.0 * k + 1.0) for k in range(MOST_SPANS + 46))
        document = Warned("note", Problem("/vehicle", "often"), spans).as_dict()
        assert (document["times"], document["more_times"]) == (spans[:MOST_SPANS], 46)


class TestTheHolds:
    def test_a_ramp_holds_nothing(self, dual_bellows: Design) -> None:
        design = scheduled(
            dual_bellows, {"time": 4.0, "extension": 0.01}, {"time": 9.0, "extension": 0.02, "shape": "ramp"}
        )
        assert [hold.spans for hold in scheduled_holds(design)] == [((0.0, 4.0),), ((9.0, 20.0),)]

    def test_a_ramp_to_where_it_is_holds(self, dual_bellows: Design) -> None:
        design = scheduled(
            dual_bellows, {"time": 4.0, "extension": 0.01}, {"time": 9.0, "extension": 0.01, "shape": "ramp"}
        )
        assert [hold.spans for hold in holds_of(assemble(design), None)[0]] == [((0.0, 4.0),), ((4.0, 20.0),)]

    def test_the_same_extensions_are_one_hold_and_the_longest_are_told(self, dual_bellows: Design) -> None:
        points = [{"time": float(2 * k), "extension": 0.01 + 0.001 * (k % 6)} for k in range(9)]
        holds, left_out = holds_of(assemble(scheduled(dual_bellows, *points)), None)
        assert len(holds) == MOST_HOLDS
        assert len(left_out) == 2
        assert spans_of(left_out) == ((8.0, 12.0),)
        assert holds[0].spans == ((0.0, 2.0), (12.0, 14.0))
        assert holds == sorted(holds, key=lambda hold: hold.spans)

    def test_when_the_run_is_in_those_left_out_is_told(self, kernel: None, dual_bellows: Design) -> None:
        points = [{"time": float(2 * k), "extension": 0.01 + 0.001 * k} for k in range(8)]
        design = changed(scheduled(dual_bellows, *points), mission__duration=15.5)
        document = consequences_document(consequences_of(assemble(design), simulate(design), analyses=False))
        assert document["left_out"] == 4
        assert document["left_out_spans"] == ((8.0, 15.5),)

    def test_of_a_controlled_run_are_its_phases(self, kernel: None) -> None:
        design = load_preset("quad-bellows-heading")
        run = simulate(design)
        holds, _ = holds_of(assemble(design), run)
        assert holds and all(hold.about for hold in holds)
        for hold in holds:
            for k, name in enumerate(run.cells):
                extension = run.cell_values["extension"][:, k]
                assert extension.min() <= hold.extensions[name] <= extension.max()

    def test_spans_are_where_flags_hold(self) -> None:
        flags = np.array([True, True, False, True, False, True])
        assert spans_where(np.arange(6.0), flags) == ((0.0, 1.0), (3.0, 3.0), (5.0, 5.0))
        assert spans_where(np.arange(3.0), np.zeros(3, dtype=bool)) == ()


class TestOnTheWay:
    def test_follow_an_edit_after_its_run(self, session: Session) -> None:
        live = session.consequences
        wait_until(lambda: live.document is not None and live.document["analyses"] == "ready")
        before = live.document
        assert before is not None
        session.set_field("/vehicle/components/1/position/0", 0.19)
        wait_until(lambda: live.document is not None and live.document["run"] > before["run"])
        after = live.document
        assert after is not None
        assert after["run"] == session.run_number
        expected = consequences_document(consequences_of(session.assembly, session.run))
        assert series_json({name: after[name] for name in expected}) == series_json(
            expected
        )  # NaN is null there, and itself
        assert after["holds"][0]["trim"]["pitch"] != before["holds"][0]["trim"]["pitch"]

    def test_older_ones_do_not_replace_newer_ones(self, session: Session) -> None:
        live, run = LiveConsequences(), session.run
        assert run is not None
        told: list[int] = []
        live.subscribe(lambda: told.append((live.document or {})["run"]))
        live.update(session.assembly, run, 7)
        live._work_out(session.assembly, run, 6, analyses=True)
        assert told[-1] == 7 and (live.document or {})["run"] == 7

    def test_the_page_is_sent_them(self, studio: Studio) -> None:
        client, session_id = studio.open()
        live = studio.sessions.find(session_id).session.consequences  # type: ignore[union-attr]
        with closing(client):
            wait_until(lambda: live.document is not None)
            assert client.get("state").json()["consequences"]["run"] >= 1
            with client.stream("GET", "events") as stream:
                lines = stream.iter_lines()
                patch = [{"op": "replace", "path": "/vehicle/components/1/position/0", "value": 0.2}]
                assert client.post("edit", json={"patch": patch}, headers={"Origin": studio.url}).status_code == 200
                assert next(line for line in lines if line == "event: consequences")
                sent = json.loads(next(lines).removeprefix("data: "))
            assert set(sent) == set(client.get("state").json()["consequences"])
            assert all(math.isfinite(hold["reserve"]["now"]) for hold in sent["holds"])
