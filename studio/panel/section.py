"""Owns one section of the panel: a folder of widgets made from rows, refreshed in place while the rows are alike."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any, Protocol

import viser

from models.design import Design
from models.problems import DesignError, Problem
from studio.changes import Patch
from studio.panel import skin
from studio.panel.rows import Row


class Editor(Protocol):
    """Who applies what a person does with a widget."""

    def commit(self, field: Field) -> None:
        """Write a widget's present value into the document."""

    def press(self, row: Row, choice: Any) -> None:
        """Apply the patch behind a button."""


class Field:
    """One widget. It holds no state: `shown` is what document and widget last agreed on.

    A person's value that was refused stays in the box as a draft, beside the message, until the next accepted change.
    """

    def __init__(self, gui: viser.GuiApi, row: Row, design: Design, *, editor: Editor) -> None:
        self.row, self._editor = row, editor
        self.shown = row.show(design)
        self._draft = False
        self.handle = self._make(gui, design)

    def _make(self, gui: viser.GuiApi, design: Design) -> Any:
        row, hint = self.row, self.row.hint
        handle: Any
        match row.widget:
            case "slider":
                low, high = row.slider_range(design)
                handle = gui.add_slider(row.label, low, high, row.step, float(self.shown), hint=hint)
                handle.precision = row.unit.decimals
            case "number" | "readout":
                # a limit given to the client would clamp silently: the document refuses, and says why
                disabled = row.widget == "readout"
                handle = gui.add_number(row.label, float(self.shown), step=row.step, hint=hint, disabled=disabled)
                handle.precision = row.unit.decimals
            case "integer":
                handle = gui.add_number(row.label, int(self.shown), step=1, hint=hint)
            case "switch":
                handle = gui.add_checkbox(row.label, bool(self.shown), hint=hint)
            case "choice":
                handle = gui.add_dropdown(
                    row.label, [label for label, _ in row.choices], initial_value=self.shown, hint=hint
                )
            case "text":
                handle = gui.add_text(row.label, str(self.shown), hint=hint)
            case "actions":
                handle = gui.add_button_group(row.label, [label for label, _ in row.choices], hint=hint)
                handle.on_click(self._pressed)
                return handle
            case _:
                return gui.add_html(skin.plain(str(self.shown)))
        handle.on_update(self._updated)
        return handle

    @property
    def identity(self) -> str:
        """Id of the widget's element in the client."""
        return str(self.handle._impl.uuid)

    def refresh(self, design: Design, row: Row, *, refused: bool) -> None:
        """Show the document's value, unless the widget has it or a refused draft is still being told about."""
        self.row = row
        if row.widget == "actions":
            return
        value = row.show(design)
        if value == self.shown and not (self._draft and not refused):
            return
        self.shown, self._draft = value, False
        if row.widget == "note":
            self.handle.content = skin.plain(str(value))
            return
        if row.widget == "slider":
            low, high = row.slider_range(design)
            if (low, high) != (self.handle.min, self.handle.max):
                self.handle.min, self.handle.max = low, high
        self.handle.value = value

    def take(self, design: Design) -> Patch:
        """Return the patch for what the widget holds now (not for what an event said: those may come late)."""
        value = self.handle.value
        if value == self.shown and not self._draft:
            return []
        if self.row.widget in ("number", "slider", "integer") and not _is_finite(value):
            raise DesignError([Problem("", f"'{self.row.label}' must be a finite number")])
        return self.row.patch(design, value)

    def agree(self, design: Design) -> None:
        """Remember that document and widget agree."""
        self.shown, self._draft = self.row.show(design), False

    def keep_draft(self) -> None:
        """Leave what the person typed, though the document refused it."""
        self._draft = True

    def _updated(self, event: Any) -> None:
        if event.client is not None:  # set by a person, not by this program
            self._editor.commit(self)

    def _pressed(self, event: Any) -> None:
        if event.client is not None:
            pressed = event.target.value
            self._editor.press(self.row, next(choice for label, choice in self.row.choices if label == pressed))


def _is_finite(value: Any) -> bool:
    return isinstance(value, int | float) and abs(value) < float("inf")


class Section:
    """A folder whose widgets follow the rows that a design has."""

    def __init__(
        self, gui: viser.GuiApi, label: str, *, order: float, rows: Callable[[Design], list[Row]], editor: Editor,
        expanded: bool = False,
    ) -> None:  # fmt: skip
        self._gui, self._rows, self._editor = gui, rows, editor
        self._folder = gui.add_folder(label, order=order, expand_by_default=expanded)
        self._fields: list[Field] = []
        self._shapes: list[tuple[Any, ...]] | None = None

    def update(self, design: Design, *, refused: bool = False, label: str | None = None) -> bool:
        """Show the design; True where widgets were made anew."""
        rows = self._rows(design)
        if label is not None and label != self._folder.label:
            self._folder.label = label
        shapes = [row.shape for row in rows]
        if shapes != self._shapes:
            self._shapes = shapes
            self._rebuild(rows, design)
            return True
        for field, row in zip(self._fields, rows, strict=True):
            field.refresh(design, row, refused=refused)
        return False

    def _rebuild(self, rows: list[Row], design: Design) -> None:
        for field in self._fields:
            field.handle.remove()
        self._folder.visible = bool(rows)
        with self._folder:
            self._fields = [Field(self._gui, row, design, editor=self._editor) for row in rows]

    def units(self) -> Iterator[tuple[str, str]]:
        """Return the element id and unit of each number; an empty unit keeps the column free all the same."""
        for field in self._fields:
            if field.row.widget in ("slider", "number", "readout", "integer"):
                yield field.identity, field.row.unit.symbol

    def field(self, label: str) -> Field:
        """Return the field with a label; raises `KeyError` where there is none."""
        for field in self._fields:
            if field.row.label == label:
                return field
        raise KeyError(label)
