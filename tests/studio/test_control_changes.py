"""Renaming and removing components that a controller names: nothing a user made is lost, and the design stays valid."""

from __future__ import annotations

from typing import Any

import pytest

from models.assemble import assemble
from models.design import Design, parse_design
from models.presets import load_preset
from studio.session import Session
from studio.state import state_of

CELLS = ["Front port cell", "Front starboard cell", "Rear port cell", "Rear starboard cell"]
PLAIN = {"kind": "cascade", "vertical": {"kind": "heave", "heave": -2.0}}
NAMED = PLAIN | {"allocation": {"cells": CELLS, "effort": {CELLS[0]: 2.0}}}
FEEDBACK = {
    "kind": "state_feedback", "cells": CELLS[:1], "states": ["theta", CELLS[0]],
    "points": [{"value": 0.0, "extensions": [0.05], "state": [0.0, 0.05], "gains": [[0.0, 0.0]]}],
}  # fmt: skip


def controlled(controller: dict[str, Any]) -> Design:
    document = load_preset("quad-bellows-glide").model_dump(mode="json")
    document["mission"]["control"] = {"schedules": [], "controller": controller}
    return parse_design(document)


def session_of(controller: dict[str, Any]) -> Session:
    return Session("test", controlled(controller))


def place_of(session: Session, name: str) -> int:
    return next(i for i, c in enumerate(session.design.vehicle.components) if c.name == name)


@pytest.mark.parametrize("controller", [PLAIN, NAMED, FEEDBACK])
def test_a_renamed_cell_stays_under_control(controller):
    session = session_of(controller)
    path = f"/vehicle/components/{place_of(session, CELLS[0])}/name"
    session.edit([{"op": "replace", "path": path, "value": "Nose"}])
    assert assemble(session.design).params.control[0]["kind"] > 0
    text = session.design.mission.control.model_dump_json()
    assert CELLS[0] not in text
    session.undo()
    assert session.design == controlled(controller)


@pytest.mark.parametrize(("controller", "stays"), [(PLAIN, True), (NAMED, True), (FEEDBACK, False)])
def test_a_controller_does_without_a_removed_cell(controller, stays):
    session = session_of(controller)
    session.remove_component(CELLS[0])
    assert session.problem == ()
    assert (session.design.mission.control.controller is not None) == stays
    session.undo()
    assert session.design == controlled(controller)


def test_the_page_knows_which_lanes_are_under_control():
    rule = {"allocation": {"cells": CELLS[:2]}}
    rows = state_of(session_of(PLAIN | rule), saved_at=None)["schedules"]
    assert {row["cell"]: row["controlled"] for row in rows} == {name: name in CELLS[:2] for name in CELLS}
