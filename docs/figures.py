"""Owns the figures of docs/paper.md: SVG that is the same byte for byte between two runs on one machine."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import matplotlib
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.layout_engine import ConstrainedLayoutEngine
from matplotlib.patches import Polygon
from numpy.typing import NDArray

from docs.studies import Case, Study, edited, force_law, preset, preset_run, table
from models.components import Bellows, Component
from models.hydrodynamic_law import build_law, coefficients_by_speed, select_data
from models.shapes import BellowsShape, HullShape, Shape, WingShape

Array = NDArray[np.float64]
INK, DIM, FAINT, GRID = "#15222f", "#47596c", "#8b9aaa", "#dde5ed"
PATH, PITCH, ATTACK, FLOW = "#0b74a8", "#15222f", "#7a4fc4", "#66788a"
FRONT, FRONT_TEXT = "#f2b134", "#8a5f08"
"""The front bellows has its colour of the studio; the rear one brings its own in the design."""
BELOW, ABOVE = ("#0b74a8", "#7fb9dc"), ("#efa75a", "#d4652f", "#96281b")
"""Lines below and above the preset's value; the preset's own is in ink."""
OTHERS = ("#c0392b", "#7a4fc4", "#b2760a", "#16785b")
STYLE = {
    "svg.fonttype": "path", "svg.hashsalt": "glider-studio", "path.simplify": True,
    "font.family": "DejaVu Sans", "font.size": 9.0, "axes.titlesize": 9.5, "axes.titleweight": "bold",
    "axes.titlelocation": "left", "axes.edgecolor": FAINT, "axes.labelcolor": DIM, "axes.linewidth": 0.8,
    "axes.spines.top": False, "axes.spines.right": False, "axes.grid": True, "axes.axisbelow": True,
    "axes.unicode_minus": True, "grid.color": GRID, "grid.linewidth": 0.7, "text.color": INK,
    "xtick.color": DIM, "ytick.color": DIM, "legend.frameon": False, "legend.fontsize": 8.5,
    "lines.linewidth": 1.6, "lines.solid_capstyle": "round", "figure.facecolor": "white", "figure.dpi": 100,
}  # fmt: skip
SNAPSHOTS = (0.0, 2.0, 4.0, 6.0, 8.0, 10.0, 12.0, 14.0, 17.0, 20.0)


def write_figures(folder: Path, studies: Sequence[Study]) -> list[str]:
    """Draw every figure into the folder; return the file names."""
    with matplotlib.rc_context(STYLE):
        drawn = {"paper-forces": forces(), "paper-snapshots": snapshots(), "paper-glide": glide()}
        drawn |= {f"paper-{study.name}": comparison(study) for study in studies}
        for name, figure in drawn.items():
            figure.savefig(folder / f"{name}.svg", format="svg", metadata={"Date": None, "Creator": None})
    return [f"{name}.svg" for name in drawn]


def new_figure(width: float, height: float, **grid: Any) -> tuple[Figure, Any]:
    """Return a figure of this size (inches) and its axes, laid out so that nothing overlaps."""
    figure = Figure(figsize=(width, height), layout=ConstrainedLayoutEngine(w_pad=0.06, h_pad=0.06))
    return figure, figure.subplots(**grid)


def forces() -> Figure:
    """Draw the force coefficients: data of all speeds, their mean, and both laws, all around and on 0 to 90 deg."""
    figure, axes = new_figure(9.2, 8.4, nrows=3, ncols=2, sharex="col")
    names = ("Lift / V² [N s²/m²]", "Drag / V² [N s²/m²]", "Moment / V² [N m s²/m²]")
    degrees = np.linspace(-180.0, 180.0, 721)
    laws = {law: build_law(edited(force_law(law, None)).vehicle.hydrodynamics) for law in ("pchip", "polynomial")}
    angles, mean = select_data(table())
    markers = zip(
        coefficients_by_speed(table()).items(), ("o", "s", "^"), ("#9ecae1", "#5b9bc8", "#1d4a7a"), strict=True
    )
    by_speed = [(f"data, {v:g} m/s", *data, marker, color) for (v, data), marker, color in markers]
    for j, name in enumerate(names):
        for column, ax in enumerate(axes[j]):
            shown = (degrees >= 0.0) & (degrees <= 90.0) if column else np.full(len(degrees), True)
            x = degrees[shown]
            ax.plot(x, laws["pchip"](np.radians(x))[j], color=PATH, label="PCHIP through the mean")
            ax.plot(
                x, laws["polynomial"](np.radians(x))[j], color="#c0392b", ls=(0, (4, 2)), lw=1.3, label="polynomials"
            )
            for label, a, values, marker, color in by_speed:
                ax.plot(np.degrees(a), values[j], marker, ms=3.2, color=color, mew=0, ls="none", label=label)
            ax.plot(np.degrees(angles), mean[j], "+", ms=5.0, mew=0.9, color=INK, ls="none", label="mean of the speeds")
            ax.axhline(0.0, color=FAINT, lw=0.8, zorder=0.5)
            ax.set_xticks(np.arange(0, 91, 15) if column else np.arange(-180, 181, 60))
        axes[j, 0].set_ylabel(name)
    axes[0, 0].set_title("Whole circle, mirrored and reflected")
    axes[0, 1].set_title("Where the data are")
    for ax in axes[2]:
        ax.set_xlabel("Angle of attack α [deg]")
    handles, labels = axes[0, 1].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside upper center", ncols=6, columnspacing=1.4, handletextpad=0.5)
    return figure


def glide() -> Figure:
    """Draw the preset's path, and pitch, angle of attack and flow angle over time."""
    d = preset_run().data
    figure, (left, right) = new_figure(9.2, 4.0, ncols=2, width_ratios=(1.0, 1.1))
    left.plot(d["x"], d["z"], color=PATH)
    for t, offset in ((0.0, (7, 2)), (5.0, (7, 4)), (10.0, (-4, -15)), (15.0, (8, -8)), (20.0, (-8, 8))):
        at = d.sel(time=t, method="nearest")
        place = float(at["x"]), float(at["z"])
        left.plot(*place, "o", ms=4.5, color=PATH, mec="white", mew=0.8)
        left.annotate(f"{t:g} s", place, xytext=offset, color=DIM, textcoords="offset points", fontsize=8.5)
    left.set(title="Path", xlabel="Distance x [m]", ylabel="Depth z [m]")
    left.set_ylim(0.25, 1.0, auto=True)
    left.invert_yaxis()
    left.set_aspect("equal", adjustable="datalim")
    curves = (("theta", PITCH, "pitch θ"), ("alpha", ATTACK, "angle of attack α"), ("flow_angle", FLOW, "flow angle"))
    for name, color, label in curves:
        style = {"ls": (0, (4, 2))} if name == "flow_angle" else {}
        right.plot(d["time"][1:], np.degrees(d[name][1:]), color=color, label=label, **style)
    _mark_switch(right)
    right.set(title="Angles", xlabel="Time t [s]", ylabel="Angle [deg]", xlim=(0, 20), ylim=(-95, 95))
    right.set_yticks(np.arange(-90, 91, 30))
    right.text(10.25, 84, "front cell expands", fontsize=8.5, color=FRONT_TEXT)
    figure.legend(*right.get_legend_handles_labels(), loc="outside lower center", ncols=3, columnspacing=1.6)
    return figure


def _mark_switch(ax: Axes) -> None:
    ax.axvline(10.0, color=FRONT, lw=1.4, zorder=0.8)


def snapshots() -> Figure:
    """Draw the glider to scale at several instants, with the path so far and to come."""
    d = preset_run().data
    figure, axes = new_figure(9.2, 3.7, nrows=2, ncols=5, sharex=True, sharey=True)
    x, z, time = d["x"].values, d["z"].values, d["time"].values
    front = next(c for c in preset().vehicle.components if isinstance(c, Bellows) and c.position[0] > 0.0)
    for ax, t in zip(axes.flat, SNAPSHOTS, strict=True):
        at = d.sel(time=t, method="nearest")
        past = time <= t + 1e-9
        ax.axhline(0.0, color="#8fd0ee", lw=1.2)
        ax.plot(x, z, color="#b9d8e8", lw=1.2)
        extensions = {str(cell): float(at["extension"].sel(cell=cell)) for cell in d["cell"].values}
        _draw_glider(ax, (float(at["x"]), float(at["z"]), float(at["theta"])), extensions)
        ax.plot(x[past], z[past], color=PATH, lw=1.6, zorder=5)
        change = 1e3 * (extensions[front.name] - front.neutral)
        ax.set_title(f"{t:g} s", pad=3)
        ax.text(1.0, 1.02, f"front {change:+.1f} mm".replace("-", "−"), transform=ax.transAxes, ha="right", va="bottom",
                fontsize=8, color=FRONT_TEXT)  # fmt: skip
        ax.set_aspect("equal")
    axes[0, 0].set(xlim=(-0.36, 1.2), ylim=(1.1, -0.06), xticks=[0, 0.5, 1.0], yticks=[0, 0.5, 1.0])
    for ax in axes[1]:
        ax.set_xlabel("Distance x [m]")
    for ax in axes[:, 0]:
        ax.set_ylabel("Depth z [m]")
    return figure


def _draw_glider(ax: Axes, pose: tuple[float, float, float], extensions: dict[str, float]) -> None:
    x, z, theta = pose
    s, c = np.sin(theta), np.cos(theta)
    for component in preset().vehicle.components:
        for shape in component.shapes:
            outline = _outline(component, shape, extensions)
            body = outline + np.array(component.position)[::2] + np.array(shape.offset)[::2]
            world = np.column_stack([x + c * body[:, 0] + s * body[:, 1], z - s * body[:, 0] + c * body[:, 1]])
            dark = "#5d6f82" if isinstance(shape, WingShape) else component.color
            ax.add_patch(
                Polygon(world, facecolor=dark, edgecolor=INK, lw=0.5, zorder=4 if isinstance(component, Bellows) else 3)
            )


def _outline(component: Component, shape: Shape, extensions: dict[str, float]) -> Array:
    """Return the silhouette of a shape from abeam about its own centre, (n, 2) in body x and z, m."""
    if isinstance(shape, HullShape):
        half, turn = 0.5 * shape.length, np.linspace(0.0, 0.5 * np.pi, 16)
        nose = np.column_stack([half - shape.nose_length * (1.0 - np.cos(turn)), shape.radius * np.sin(turn)])
        tail = np.column_stack([-half + shape.tail_length * (1.0 - np.cos(turn)), shape.radius * np.sin(turn)])
        keel = np.concatenate([nose, tail[::-1]])
        return np.concatenate([keel, keel[::-1] * [1.0, -1.0]])
    if isinstance(shape, WingShape):
        length, height = shape.chord, 2.0 * shape.thickness
    elif isinstance(shape, BellowsShape) and isinstance(component, Bellows):
        length = shape.length + extensions[component.name] - component.neutral
        height = 2.0 * shape.outer_radius
    else:
        raise TypeError(f"no silhouette for the shape {shape.kind!r}")
    return 0.5 * np.array([[length, height], [-length, height], [-length, -height], [length, -height]])


def comparison(study: Study) -> Figure:
    """Overlay the glides of one study: depth gained over distance, and pitch over time."""
    figure, (left, right) = new_figure(9.2, 4.1, ncols=2, width_ratios=(1.0, 1.0))
    reference = next(case for case in study.cases if case.reference)
    for case, style in zip(study.cases, _styles(study), strict=True):
        left.plot(case.distance, case.depth, label=case.label, **style)
        pitch = case.pitch - reference.pitch if study.pitch_relative else case.pitch
        right.plot(case.time, pitch, **style)
        if case.ending != "completed":
            right.plot(case.time[-1], pitch[-1], "x", color=style["color"], ms=6, mew=1.6, zorder=4)
    _mark_switch(right)
    for ax in (left, right):
        ax.axhline(0.0, color=FAINT, lw=0.8, zorder=0.5)
    left.set(title=_symbols(study.title), xlabel="Distance [m]", ylabel="Depth gained [m]")
    _limit_to_glides(left, study.cases)
    left.invert_yaxis()
    left.set_aspect("equal", adjustable="datalim")
    title = f"Pitch less that of '{reference.label}'" if study.pitch_relative else "Pitch"
    right.set(title=title, xlabel="Time t [s]", ylabel="Pitch θ [deg]", xlim=(0, 20), xticks=range(0, 21, 5))
    columns = 4 if len(study.cases) == 8 else len(study.cases)
    figure.legend(loc="outside lower center", ncols=columns, columnspacing=1.6, handlelength=2.2)
    return figure


def _symbols(title: str) -> str:
    return title.replace("C33", "$C_{33}$").replace("l_gz", "$l_{gz}$")


def _limit_to_glides(ax: Axes, cases: Sequence[Case]) -> None:
    """Frame the glides that ran to their end: one that runs away leaves the frame."""
    whole = [case for case in cases if case.ending == "completed"]
    for axis, name in (("x", "distance"), ("y", "depth")):
        low = min(float(getattr(case, name).min()) for case in whole)
        high = max(float(getattr(case, name).max()) for case in whole)
        pad = 0.06 * (high - low)
        getattr(ax, f"set_{axis}lim")(low - pad, high + pad, auto=True)


def _styles(study: Study) -> list[dict[str, Any]]:
    """Return a line style for each case: cool to warm where a number varies, else one hue each; the preset in ink."""
    place = next(i for i, case in enumerate(study.cases) if case.reference)
    hues = iter(OTHERS)
    styles: list[dict[str, Any]] = []
    for i, case in enumerate(study.cases):
        if case.reference:
            styles.append({"color": INK, "lw": 2.2, "zorder": 3})
        elif study.name == "source":
            color = {"0.1 m/s": "#7a4fc4", "0.2 m/s": "#0b74a8", "0.5 m/s": "#16785b"}.get(case.label[-7:], INK)
            styles.append({"color": color, "lw": 1.4, "ls": (0, (4, 2)) if "poly" in case.label else "-"})
        elif study.name in ("c33", "lgz"):
            styles.append({"color": BELOW[i] if i < place else ABOVE[i - place - 1]})
        else:
            styles.append({"color": next(hues), "ls": (0, (5, 1.5))})
    return styles
