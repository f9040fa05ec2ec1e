"""Owns the panel at the left of the 3D view: the list of components, the selected one's fields, and the glider's."""

from __future__ import annotations

import threading
from collections.abc import Callable
from typing import Any

import viser

from models.design import Design
from models.problems import DesignError
from studio.palette import component_colors
from studio.panel import force_rows, mass_rows, mission_rows, skin
from studio.panel.component_rows import component_rows
from studio.panel.rows import Row
from studio.panel.schedule_rows import schedule_rows
from studio.panel.section import Field, Section
from studio.session import Session

WIDTH = 304
KINDS = {
    "+ Bellows": "bellows",
    "+ Piston": "piston",
    "+ Bladder": "bladder",
    "+ Movable mass": "movable_mass",
    "+ Rolling mass": "rolling_mass",
    "+ Rigid": "rigid",
}
DUPLICATE, REMOVE = "Duplicate", "Remove"


def _weight(mass: float) -> str:
    """Return a mass for the list: grams, or kilograms of a heavy part."""
    return f"{mass:.4g} kg" if mass >= 10.0 else f"{mass * 1e3:.4g} g"


class Form:
    """The panel of one session. Widgets write through the session's operations and are refreshed from its document."""

    def __init__(self, gui: viser.GuiApi, session: Session) -> None:
        self._gui, self._session = gui, session
        self._lock = threading.RLock()
        self._selected = -1
        self._listed: list[tuple[str, str, str, bool]] = []
        self._buttons: list[Any] = []
        gui.main_panel.dock_left()
        gui.main_panel.set_width(WIDTH)
        gui.set_panel_label("Editor")
        self._style = gui.add_html("", order=0.0)
        gui.add_html(skin.heading("Components"), order=1.0)
        self._list = gui.add_folder(None, order=2.0)
        self._add_actions()
        self._message = gui.add_html("", order=5.0, visible=False)
        self._component = self._section("Component", 6.0, self._selected_rows, expanded=True)
        self._schedule = self._section("Schedule", 7.0, self._selected_schedule)
        gui.add_html(skin.heading("Glider and mission"), order=9.0)
        self._others = [
            self._section("Mass properties", 10.0, mass_rows.mass_rows),
            self._section("Hydrodynamics", 11.0, self._hydrodynamics),
            self._section("Added mass and damping", 12.0, force_rows.damping_rows),
            self._section("Water", 13.0, mission_rows.water_rows),
            self._section("Mission", 13.5, mission_rows.mission_rows),
            self._section("Solver", 14.0, mission_rows.solver_rows),
        ]
        self.update()

    def _section(
        self, label: str, order: float, rows: Callable[[Design], list[Row]], *, expanded: bool = False
    ) -> Section:
        return Section(self._gui, label, order=order, rows=rows, editor=self, expanded=expanded)

    def _add_actions(self) -> None:
        adding = self._gui.add_button_group("Add", list(KINDS), hint="Add a component in the widest gap.", order=3.0)
        adding.on_click(self._add_pressed)
        hint = "Copy or remove the selected component."
        changing = self._gui.add_button_group("Selected", [DUPLICATE, REMOVE], hint=hint, order=4.0)
        changing.on_click(self._change_pressed)

    def _add_pressed(self, event: Any) -> None:
        kind = KINDS.get(str(event.target.value))
        if kind is not None:
            self._try(lambda: self._session.add_component(kind))

    def _change_pressed(self, event: Any) -> None:
        if event.target.value == DUPLICATE:
            self._try(lambda: self._session.duplicate_component(self._session.selected))
        elif event.target.value == REMOVE:
            self._try(lambda: self._session.remove_component(self._session.selected_component.name))

    def _selected_rows(self, design: Design) -> list[Row]:
        return component_rows(design, self._index(design))

    def _selected_schedule(self, design: Design) -> list[Row]:
        return schedule_rows(design, self._index(design))

    def _hydrodynamics(self, design: Design) -> list[Row]:
        return force_rows.hydrodynamics_rows(design)

    def _index(self, design: Design) -> int:
        return min(self._session.selected, len(design.vehicle.components) - 1)

    def update(self) -> None:
        """Show the session's document, selection and problem."""
        with self._lock:
            design, problem = self._session.design, self._session.problem
            index = self._index(design)
            refused = bool(problem) and index == self._selected
            self._selected = index
            name = design.vehicle.components[index].name
            rebuilt = self._component.update(design, refused=refused, label=name)
            rebuilt |= self._schedule.update(design, refused=refused, label=f"Schedule of {name}")
            for section in self._others:
                rebuilt |= section.update(design, refused=bool(problem))
            rebuilt |= self._update_list(design, index)
            if rebuilt:
                self._dress()
            content = skin.problem_box(problem, [c.name for c in design.vehicle.components])
            if content != self._message.content:
                self._message.content, self._message.visible = content, bool(content)

    def _update_list(self, design: Design, index: int) -> bool:
        components = design.vehicle.components
        wanted = [
            (c.name, color, _weight(c.mass), i == index)
            for i, (c, color) in enumerate(zip(components, component_colors(components), strict=True))
        ]
        if wanted == self._listed:
            return False
        while len(self._buttons) > len(wanted):
            self._buttons.pop().remove()
        with self._list:
            while len(self._buttons) < len(wanted):
                self._buttons.append(self._list_button(len(self._buttons)))
        for button, (name, *_) in zip(self._buttons, wanted, strict=True):
            if button.label != name:
                button.label = name
        self._listed = wanted
        return True

    def _list_button(self, index: int) -> Any:
        button = self._gui.add_button(f"{index}")

        def choose(_: Any) -> None:
            self._try(lambda: self._session.select(index))

        button.on_click(choose)
        return button

    def _dress(self) -> None:
        sections = [self._component, self._schedule, *self._others]
        units = [pair for section in sections for pair in section.units()]
        listed = [
            (str(button._impl.uuid), color, mass, selected)
            for button, (_, color, mass, selected) in zip(self._buttons, self._listed, strict=True)
        ]
        self._style.content = skin.style(units, listed)

    def commit(self, field: Field) -> None:
        """Write a widget's present value into the document; a refused one stays in the box beside the message."""
        # callbacks run in parallel and out of order: whoever comes last through the lock writes what the widget holds
        with self._lock:
            try:
                patch = field.take(self._session.design)
            except DesignError as error:
                self._session.refuse(error)
                field.keep_draft()
                return
            if patch and self._try(lambda: self._session.edit(patch)):
                field.agree(self._session.design)
            elif patch:
                field.keep_draft()

    def press(self, row: Row, choice: Any) -> None:
        """Apply the patch behind a button."""
        self._try(lambda: self._session.edit(row.write(self._session.design, choice)))

    def field(self, label: str) -> Field:
        """Return the first field with a label; raises `KeyError` where there is none."""
        for section in (self._component, self._schedule, *self._others):
            try:
                return section.field(label)
            except KeyError:
                continue
        raise KeyError(label)

    def _try(self, change: Callable[[], object]) -> bool:
        """Make a change; where it is refused the session tells why, and the message appears."""
        try:
            change()
        except DesignError:
            return False
        return True
