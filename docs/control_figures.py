"""Owns the figures of docs/control.md: SVG with thinned curves, the same byte for byte between two runs."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import matplotlib
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Circle

from docs import control_comparison as comparison
from docs import control_studies as studies
from docs.control_analyses_figures import locus_figure, polar_figure, stability_figure
from docs.figures import DIM, FAINT, INK, PATH, STYLE, new_figure
from docs.validation_figures import thin
from models.presets.quad_control import FAST, SLOW
from models.presets.quad_glider import CELLS
from models.run import Run

WANTED = "#d4652f"
TWIN = "#7a4fc4"
DASHED = (0, (4, 2))


def write_figures(folder: Path) -> list[str]:
    """Draw every figure into the folder; return the file names."""
    drawn: dict[str, Callable[[], Figure]] = {
        "heading": lambda: mission_figure(studies.preset_run("heading"), current=True),
        "s-turn": lambda: mission_figure(studies.s_turn(), current=False),
        "twin": twin_figure, "places": places_figure,
        "polar": polar_figure, "locus": locus_figure, "stability": stability_figure,
    }  # fmt: skip
    with matplotlib.rc_context(STYLE):
        for name, draw in drawn.items():
            path = folder / f"control-{name}.svg"
            draw().savefig(path, format="svg", metadata={"Date": None, "Creator": None})
    return [f"control-{name}.svg" for name in drawn]


def mission_figure(run: Run, *, current: bool) -> Figure:
    """Draw the path from above, and heading, bank and cells over time with what was wanted of them."""
    figure, whole = new_figure(9.2, 5.6)
    whole.remove()
    axes = figure.subplot_mosaic([["path", "psi"], ["path", "phi"], ["path", "cells"]], width_ratios=(1.0, 1.5))
    v, minutes, shown = run.values, run.times / 60.0, thin(len(run.times), 400)
    _path(axes["path"], run, "Path from above")
    if current:
        _arrow(axes["path"], run)
    for name, target, title in (("psi", "heading_target", "Heading [deg]"), ("phi", "roll_target", "Bank [deg]")):
        axes[name].plot(minutes[shown], np.degrees(v[target][shown]), color=WANTED, ls=DASHED, lw=1.1, label="wanted")
        axes[name].plot(minutes[shown], np.degrees(v[name][shown]), color=PATH, label="flown")
        axes[name].set_title(title)
    axes["psi"].legend(ncols=2)
    for k, (name, color) in enumerate(zip(run.cells, (look[2] for look in CELLS.values()), strict=True)):
        extension = 1e3 * run.cell_values["extension"][shown, k]
        axes["cells"].plot(minutes[shown], extension, color=color, lw=1.3, label=name.removesuffix(" cell"))
    axes["cells"].set(title="Extension of the cells [mm]", xlabel="Time [min]", ylim=(0, 100))
    figure.legend(*axes["cells"].get_legend_handles_labels(), loc="outside lower center", ncols=4, columnspacing=1.6)
    for name in ("psi", "phi", "cells"):
        axes[name].set_xlim(0.0, minutes[-1])
    return figure


def _path(ax: Axes, run: Run, title: str) -> None:
    """Draw a path from above with its start."""
    shown = thin(len(run.times), 600)
    ax.plot(run.values["y"][shown], run.values["x"][shown], color=PATH, lw=1.3)
    ax.plot(run.values["y"][0], run.values["x"][0], "o", color=INK, ms=4.5)
    ax.set(title=title, xlabel="East [m]", ylabel="North [m]")
    ax.set_aspect("equal", adjustable="datalim")


def _arrow(ax: Axes, run: Run, corner: tuple[float, float] = (0.05, 0.86)) -> None:
    """Draw where the current goes: an arrow from a corner, in shares of the axes."""
    north, east = run.design.mission.environment.current.velocity
    speed = float(np.hypot(north, east))
    tail = (corner[0] + 0.05, corner[1])
    tip = (tail[0] + 0.16 * east / speed, tail[1] + 0.12 * north / speed)
    ax.annotate("", tip, tail, xycoords="axes fraction", textcoords="axes fraction",
                arrowprops={"arrowstyle": "->", "color": DIM, "lw": 1.4})  # fmt: skip
    ax.text(corner[0], corner[1] + 0.07, f"current {speed:.2f} m/s", transform=ax.transAxes, color=DIM, fontsize=8.5)


def twin_figure() -> Figure:
    """Draw the radius of steady turns against the bank, and a step of the heading with what it takes."""
    figure, whole = new_figure(9.2, 4.6)
    whole.remove()
    axes = figure.subplot_mosaic([["turns", "psi"], ["turns", "energy"]], width_ratios=(1.2, 1.0))
    left, upper, lower = (axes[name] for name in ("turns", "psi", "energy"))
    for drive, marker in ((SLOW, "o"), (FAST, "s")):
        quad, _, twin = comparison.compared(drive)
        for which, color, word in ((quad, PATH, "quad"), (twin, TWIN, "twin")):
            banks, radii = (np.array(x) for x in zip(*((t.bank, t.radius) for t in which.turns), strict=True))
            able = np.array([turn.missing < comparison.MISSING for turn in which.turns])
            left.plot(np.degrees(banks), radii, color=color, lw=1.0)
            left.plot(np.degrees(banks[able]), radii[able], marker, ms=4.5, color=color, ls="none",
                      label=f"{word}, {drive.heave:g} N")  # fmt: skip
            left.plot(np.degrees(banks[~able]), radii[~able], marker, ms=4.5, mfc="white", color=color, ls="none")
    left.set(title="Steady turns in dives", xlabel="Bank [deg]", ylabel="Radius [m]", ylim=(0, 120), xlim=(0, 28))
    left.legend()
    quad, _, twin = comparison.compared(SLOW)
    for which, color, word in ((quad, PATH, "quad"), (twin, TWIN, "twin")):
        run, shown = which.step.run, thin(len(which.step.run.times), 200)
        upper.plot(run.times[shown], np.degrees(run.values["psi"][shown]), color=color, label=word)
        energy = run.values["battery_energy"] - run.design.vehicle.hotel_power * run.times
        lower.plot(run.times[shown], energy[shown], color=color, label=word)
    upper.axhline(np.degrees(comparison.STEP), color=WANTED, ls=DASHED, lw=1.1)
    upper.set_title("Heading [deg]")
    upper.legend()
    lower.set(title="Taken by the actuators [J]", xlabel="Time [s]")
    return figure


def places_figure() -> Figure:
    """Draw the path around the waypoints, and that on station."""
    figure, (left, right) = new_figure(9.2, 4.6, ncols=2)
    way, station = studies.preset_run("waypoints"), studies.preset_run("station")
    guidance = way.design.mission.control.controller.lateral.guidance
    corners = np.array([[0.0, 0.0], *guidance.points])
    left.plot(corners[:, 1], corners[:, 0], color=FAINT, ls=DASHED, lw=1.2)
    for north, east in guidance.points:
        left.add_patch(Circle((east, north), guidance.radius, fill=False, color=WANTED, lw=1.1))
    _path(left, way, "Waypoints, by line of sight with integral")
    _arrow(left, way, corner=(0.55, 0.1))
    place = station.design.mission.control.controller.lateral.guidance
    for share, style in ((1.0, "-"), (0.5, DASHED)):
        right.add_patch(Circle(place.center[::-1], share * place.radius, fill=False, color=WANTED, ls=style, lw=1.1))
    _path(right, station, "Station")
    _arrow(right, station)
    return figure
