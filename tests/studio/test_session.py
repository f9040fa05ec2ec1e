from __future__ import annotations

import threading
import time

import pytest

from models.design import Design
from models.mass_properties import mass_balance
from models.problems import DesignError
from models.run import Run, Status
from studio.session import Change, Session
from tests.studio.conftest import wait_until

X = "/vehicle/components/1/position/0"


def x_of(session: Session) -> float:
    return session.design.vehicle.components[1].position[0]


def final_x(session: Session) -> float:
    wait_until(lambda: not session.simulating)
    assert session.run is not None
    return session.run.final["x"]


def test_an_edit_is_simulated_and_told(session: Session) -> None:
    told: list[Change] = []
    session.subscribe(told.append)
    before, revision = final_x(session), session.revision
    session.set_field(X, 0.19)
    assert x_of(session) == 0.19
    assert session.revision == revision + 1
    assert final_x(session) != before
    wait_until(lambda: told[-1:] == [Change.run])


def test_an_edit_whose_run_may_take_long_is_told_before_the_run(session: Session) -> None:
    told: list[tuple[Change, bool]] = []
    session.subscribe(lambda change: told.append((change, session.simulating)))
    session.set_field("/mission/duration", 15.0)
    wait_until(lambda: told[-1:] == [(Change.run, False)])
    assert told[0] == (Change.document, True)


def test_undo_and_redo_walk_through_the_same_documents(session: Session) -> None:
    documents = [session.design]
    for pointer, value in ((X, 0.19), ("/mission/duration", 15.0), ("/name", "Another")):
        session.set_field(pointer, value)
        documents.append(session.design)
    for expected in reversed(documents[:-1]):
        assert session.undo()
        assert session.design == expected
    assert not session.undo()
    for expected in documents[1:]:
        assert session.redo()
        assert session.design == expected
    assert not session.redo()
    session.undo()
    session.set_field("/name", "A third")
    assert not session.can_redo


def test_a_drag_is_one_step_of_undo(session: Session) -> None:
    start = session.design
    for step in range(20):
        session.set_field(X, 0.18 + 1e-4 * step)
    session.undo()
    assert session.design == start


@pytest.mark.parametrize(
    ("pointer", "value", "told"),
    [
        ("/vehicle/components/1/mass", -1.0, "/vehicle/components/1/mass"),
        ("/vehicle/components/1/pleats", 2.5, "/vehicle/components/1/pleats"),
        ("/mission/initial/position/2", -3.0, "/mission/initial/position/2"),
        ("/vehicle/nothing", 1.0, "/patch/0/path"),
    ],
)
def test_a_refused_edit_keeps_document_and_run(session: Session, pointer: str, value: object, told: str) -> None:
    design, run, revision = session.design, session.run, session.revision
    with pytest.raises(DesignError):
        session.set_field(pointer, value)
    assert (session.design, session.run, session.revision) == (design, run, revision)
    assert session.problem[0].pointer == told
    assert not session.can_undo
    session.set_field(X, 0.19)
    assert session.problem == ()


def test_renaming_takes_schedule_and_initial_extension_along(session: Session) -> None:
    session.edit([{"op": "add", "path": "/mission/initial/extensions/Front bellows", "value": 0.012}])
    session.set_field("/vehicle/components/1/name", "Nose")
    mission = session.design.mission
    assert [s.cell for s in mission.control.schedules] == ["Nose"]
    assert mission.initial.extensions == {"Nose": 0.012}
    session.undo()
    assert session.design.mission.control.schedules[0].cell == "Front bellows"


def test_removing_takes_schedule_and_initial_extension_away(session: Session) -> None:
    session.edit([{"op": "add", "path": "/mission/initial/extensions/Front bellows", "value": 0.012}])
    session.remove_component("Front bellows")
    assert [c.name for c in session.design.vehicle.components] == ["Body", "Rear bellows"]
    assert session.design.mission.control.schedules == ()
    assert session.design.mission.initial.extensions == {}


def test_the_last_component_stays(session: Session) -> None:
    session.remove_component("Front bellows")
    session.remove_component("Rear bellows")
    with pytest.raises(DesignError, match="last component"):
        session.remove_component("Body")


@pytest.mark.parametrize("kind", ["bellows", "piston", "bladder", "movable_mass", "rigid"])
def test_each_kind_can_be_added_copied_and_simulated(session: Session, kind: str) -> None:
    session.add_component(kind)
    assert session.selected_component.kind == kind
    session.duplicate_component(session.selected)
    wait_until(lambda: not session.simulating)
    assert len(session.design.vehicle.components) == 5
    assert len({c.name for c in session.design.vehicle.components}) == 5
    assert session.run is not None
    # declared mass: what a new part displaces is not outweighed, so the glider may well rise to the surface
    assert session.run.status in (Status.completed, Status.surface)


@pytest.mark.parametrize("kind", ["bellows", "piston", "bladder"])
def test_a_new_cell_is_neutral_by_itself(session: Session, kind: str) -> None:
    session.set_field("/vehicle/mass_properties", {"kind": "composite"})
    before = mass_balance(session.design.vehicle)
    session.add_component(kind)
    after = mass_balance(session.design.vehicle)
    # its mass is rounded to four digits
    assert after.mass - before.mass == pytest.approx(1000.0 * (after.volume - before.volume), rel=1e-3)


def test_trimming_makes_it_neutral_and_can_be_undone(session: Session) -> None:
    session.set_field("/vehicle/mass_properties/mass", 0.8)
    before = session.design
    assert "cm3" in session.trim_ballast()
    session.undo()
    assert session.design == before


def test_only_the_newest_of_many_edits_must_be_simulated(session: Session) -> None:
    runs: list[Run] = []

    def count(change: Change) -> None:
        if change is Change.run and session.run is not None:
            runs.append(session.run)

    session.subscribe(count)
    for step in range(40):
        session.set_field(X, 0.18 + 1e-4 * step)
    wait_until(lambda: not session.simulating)
    assert session.run is not None
    assert session.run.design == session.design
    assert len(runs) <= 41
    places = [run.design.vehicle.components[1].position[0] for run in runs]
    assert places == sorted(places), "an older run never follows a newer one"


def test_a_newer_edit_cancels_a_long_simulation(session: Session) -> None:
    # 20 s at a fixed step of 5e-6 s are 4 million steps: a second or more
    session.edit(
        [
            {"op": "replace", "path": "/mission/solver/method", "value": "rk4"},
            {"op": "replace", "path": "/mission/solver/step", "value": 5e-6},
        ]
    )
    wait_until(lambda: session._runner._control is not None)
    long = session.assembly
    began = time.monotonic()
    session.edit([{"op": "replace", "path": "/mission/solver/method", "value": "adaptive"}])
    seen: list[Run] = []
    session.subscribe(lambda _: seen.append(session.run) if session.run else None)
    wait_until(lambda: not session.simulating)
    assert all(run.design is not long.design for run in seen), "the cancelled run is not shown"
    assert time.monotonic() - began < 5.0
    assert session.run is not None
    assert session.run.status is Status.completed


def test_a_failing_view_does_not_stop_the_others(session: Session, caplog: pytest.LogCaptureFixture) -> None:
    def fail(_: Change) -> None:
        raise RuntimeError("a view's mistake")

    told = threading.Event()
    session.subscribe(fail)
    session.subscribe(lambda _: told.set())
    session.select(2)
    assert told.wait(10.0)
    assert "a view's mistake" in caplog.text


def test_replacing_the_document_is_a_step_too(session: Session, dual_bellows: Design) -> None:
    other = dual_bellows.model_copy(update={"name": "Other"})
    session.replace(other)
    assert session.design == other
    session.undo()
    assert session.design == dual_bellows


def test_an_added_cell_weighs_where_mass_is_declared(session: Session) -> None:
    before = mass_balance(session.design.vehicle)
    session.add_component("piston")
    after = mass_balance(session.design.vehicle)
    added = session.design.vehicle.components[-1]
    # what it displaces at neutral it weighs, to the four digits its mass is given with
    assert after.mass - before.mass == pytest.approx(added.mass, rel=1e-12)
    assert after.mass - 1000.0 * after.volume == pytest.approx(before.mass - 1000.0 * before.volume, abs=1e-5)


@pytest.mark.parametrize("index", ["9" * 5000, "01", "١", "-1", "1e0"])
def test_an_index_that_is_none_is_refused(session: Session, index: str) -> None:
    with pytest.raises(DesignError):
        session.edit([{"op": "replace", "path": f"/vehicle/components/{index}/name", "value": "X"}])
    assert [c.name for c in session.design.vehicle.components] == ["Body", "Front bellows", "Rear bellows"]
