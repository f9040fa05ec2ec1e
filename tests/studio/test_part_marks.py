"""Locked parts cannot be changed by anybody, marks follow names, and both last as long as the session's file."""

from __future__ import annotations

from pathlib import Path

import pytest

from models.problems import DesignError
from studio.part_marks import PartMarks, read_marks
from studio.part_patches import moved
from studio.registry import Sessions
from studio.session import Session
from studio.state import state_of

FRONT = "/vehicle/components/1"
SCHEDULE = {"op": "replace", "path": "/mission/control/schedules/0/points/1/extension", "value": 0.0168}
START = {"op": "add", "path": "/mission/initial/extensions/Front bellows", "value": 0.015}


@pytest.mark.parametrize(
    ("operation", "told"),
    [
        ({"op": "replace", "path": f"{FRONT}/mass", "value": 0.031}, f"{FRONT}/mass"),
        ({"op": "replace", "path": f"{FRONT}/position/0", "value": 0.19}, f"{FRONT}/position"),
        ({"op": "replace", "path": f"{FRONT}/color", "value": "#123456"}, f"{FRONT}/color"),
        ({"op": "replace", "path": f"{FRONT}/name", "value": "Nose"}, FRONT),
        ({"op": "remove", "path": FRONT}, FRONT),
        (SCHEDULE, "/mission/control/schedules/0"),
        ({"op": "remove", "path": "/mission/control/schedules/0"}, "/mission/control/schedules/0"),
        (START, "/mission/initial/extensions/Front bellows"),
    ],
)
def test_a_locked_part_is_refused_with_the_way_out(session: Session, operation: dict[str, object], told: str) -> None:
    before = session.design
    session.mark(1, locked=True)
    with pytest.raises(DesignError) as refused:
        session.edit([operation])
    (problem,) = refused.value.problems
    assert problem.pointer == told
    assert problem.message == "'Front bellows' is locked"
    assert problem.hint == "unlock it first: by its lock in the list of parts, or by L there"
    assert session.design is before and session.problem == (problem,)
    session.mark(1, locked=False)
    session.edit([operation])
    assert session.design != before


def test_other_parts_go_on_changing_and_so_does_the_order(session: Session) -> None:
    session.mark(1, locked=True)
    session.set_field("/vehicle/components/2/mass", 0.031)
    session.set_field("/mission/duration", 15.0)
    session.add_component("ballast")
    session.arrange(lambda design: moved(design, 1, 0), select=0)
    assert session.selected_component.name == "Front bellows"
    with pytest.raises(DesignError, match="is locked"):
        session.set_field("/vehicle/components/0/mass", 0.04)


def test_marks_follow_a_new_name_and_end_with_their_part(session: Session) -> None:
    session.mark(1, hidden=True)
    session.mark(2, locked=True, hidden=True)
    session.set_field(f"{FRONT}/name", "Nose")
    assert session.marks.locked == {"Rear bellows"} and session.marks.hidden == {"Nose", "Rear bellows"}
    session.undo()
    assert session.marks.hidden == {"Front bellows", "Rear bellows"}
    session.edit([{"op": "remove", "path": FRONT}])
    assert session.marks.locked == session.marks.hidden == {"Rear bellows"}


def test_another_document_has_no_marks_and_no_lock_holds_it_back(session: Session) -> None:
    session.mark(1, locked=True)
    session.link(False)
    session.replace(session.design.model_copy(update={"name": "Another"}))
    assert session.design.name == "Another" and not session.marks.locked and session.linked


def test_hiding_changes_neither_document_nor_revision(session: Session) -> None:
    design, revision = session.design, session.revision
    session.mark(0, hidden=True)
    rows = state_of(session, saved_at=None)["components"]
    assert [row["hidden"] for row in rows] == [True, False, False]
    assert [row["locked"] for row in rows] == [False] * 3
    assert session.design is design and session.revision == revision


def test_the_selection_stays_with_its_part(session: Session) -> None:
    session.select(2)
    session.edit([{"op": "remove", "path": FRONT}])
    assert session.selected_component.name == "Rear bellows"
    session.undo()
    assert session.selected_component.name == "Rear bellows"
    session.set_field("/vehicle/components/2/name", "Tail")
    assert session.selected_component.name == "Tail"


def test_marks_last_as_long_as_the_file(kernel: None, dual_bellows: object, tmp_path: Path) -> None:
    sessions = Sessions(tmp_path)
    opened, _ = sessions.create(dual_bellows)  # type: ignore[arg-type]
    opened.session.mark(1, locked=True)
    opened.session.mark(2, hidden=True)
    opened.session.link(False)
    opened.save()
    sessions.close()
    again = Sessions(tmp_path)
    found = again.find(opened.session.id)
    assert found is not None
    assert found.session.marks.document() == {"locked": ["Front bellows"], "hidden": ["Rear bellows"], "linked": False}
    assert not found.session.linked
    again.close()


@pytest.mark.parametrize("document", [None, {}, {"locked": None}, "nonsense"])
def test_a_file_of_before_has_no_marks(document: object) -> None:
    assert read_marks(document).document() == PartMarks().document() == {"locked": [], "hidden": [], "linked": True}
