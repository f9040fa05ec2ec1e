"""Owns the figures of the analyses in docs/control.md: glide polar, root locus, stability along a dive."""

from __future__ import annotations

import math
from itertools import groupby, pairwise

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import LinearSegmentedColormap, Normalize
from matplotlib.figure import Figure
from numpy.typing import NDArray

from docs.control_sections import linear_models as linear
from docs.control_sections import stability_over_the_schedule as schedule
from docs.control_sections import trim_and_polar as trims
from docs.figures import ABOVE, BELOW, DIM, FAINT, INK, OTHERS, PATH, new_figure
from docs.validation_figures import thin
from models.glide_polar import PolarCurve

Array = NDArray[np.float64]
HEAVES = ("#7fb9dc", "#0b74a8", "#1d4a7a", INK)
"""Curves of the polar, from the smallest share of heave to the largest."""
RAYS = (15, 30, 45, 60)
"""Paths that are drawn as rays, deg."""
REACH = 0.37
"""Largest horizontal speed shown, m/s."""
LABELS = {
    "best range": (14, 22), "least energy": (16, 16), "slowest sink": (-70, -66), "tightest turn": (-62, 42),
}  # fmt: skip
"""Where the names of points stand, in points from them."""
WARMING = LinearSegmentedColormap.from_list("warming", ["#0b74a8", "#b9a6c9", "#d4652f", "#96281b"])
DOTTED = (0, (1, 1.2))
SHADE = "#fbe6dc"


def polar_figure() -> Figure:
    """Draw the envelope of the polar with its named points."""
    figure, ax = new_figure(9.2, 5.8)
    for angle in RAYS:
        for sign in (1.0, -1.0):
            end = np.array([math.cos(math.radians(angle)), sign * math.sin(math.radians(angle))]) * 0.6
            ax.plot([0.0, end[0]], [0.0, end[1]], color=FAINT, lw=0.7, ls=(0, (1, 3)), zorder=0.9)
            stop = end * min(1.0, (REACH - 0.012) / end[0], 0.395 / abs(end[1]))
            ax.text(*stop, f"{angle:d}°", color=DIM, fontsize=8, ha="center", va="center",
                    bbox={"fc": "white", "ec": "none", "pad": 0.8})  # fmt: skip
    curves = trims.polar().curves
    largest = max(abs(curve.heave) for curve in curves)
    for curve in curves:
        share = abs(curve.heave) / largest
        _curve(ax, curve, HEAVES[round(4 * share) - 1], f"heave {100 * share:.0f} %" if curve.heave < 0.0 else None)
    for name, trim in trims.named_points().items():
        place = trim.horizontal_speed, trim.sink_rate
        ax.plot(*place, "o", ms=6.5, color=OTHERS[0], mec="white", mew=1.0, zorder=4)
        ax.annotate(name, place, LABELS[name], textcoords="offset points", fontsize=9, color=OTHERS[0], zorder=5,
                    bbox={"fc": "white", "ec": "none", "pad": 0.6},
                    arrowprops={"arrowstyle": "-", "color": OTHERS[0], "lw": 0.8})  # fmt: skip
    ax.axhline(0.0, color=FAINT, lw=0.8)
    ax.set(title="Glide polar of the quad glider", xlabel="Horizontal speed [m/s]",
           ylabel="Vertical speed, down positive [m/s]", xlim=(0.0, REACH), ylim=(0.42, -0.42))  # fmt: skip
    ax.plot([], [], color=DIM, ls=DOTTED, lw=1.6, label="unstable")
    figure.legend(*ax.get_legend_handles_labels(), loc="outside lower center", ncols=5, columnspacing=1.6)
    return figure


def _curve(ax: Axes, curve: PolarCurve, color: str, label: str | None) -> None:
    """Draw a curve by the order of its moments, dotted where unstable; a single glide as a dot."""
    x = np.array([trim.horizontal_speed for trim in curve.points])
    y = np.array([trim.sink_rate for trim in curve.points])
    if len(x) == 1:
        ax.plot(x, y, "s", ms=5, color=color, label=label)
        return
    stable = [trim.stable for trim in curve.points]
    solid = np.array([a and b for a, b in pairwise(stable)])
    first = 0
    for is_solid, group in groupby(solid.tolist()):
        last = first + len(list(group))
        ax.plot(x[first : last + 1], y[first : last + 1], color=color, ls="-" if is_solid else DOTTED,
                label=label if is_solid else None)  # fmt: skip
        label, first = None if is_solid else label, last


def locus_figure() -> Figure:
    """Draw the slow eigenvalues in the complex plane, and their growth, as the metacentric height shrinks."""
    figure, (left, right) = new_figure(9.2, 4.6, ncols=2, width_ratios=(1.15, 1.0))
    found, crossings = linear.locus()
    height, scale = 1e3 * linear.HEIGHTS, Normalize(1e3 * linear.HEIGHTS.min(), 1e3 * linear.HEIGHTS.max())
    for k, name in enumerate(found.names):
        roots = found.eigenvalues[:, k]
        if name in ("depth", "heading") or roots.real.min() < -0.7:
            continue
        up = roots.imag >= 0.0
        dots = left.scatter(roots.real[up], roots.imag[up], c=height[up], cmap=WARMING.reversed(), norm=scale, s=13,
                            linewidths=0, zorder=2)  # fmt: skip
        color, word = {"pitch oscillation": (PATH, "pitch"), "roll-sway oscillation": (OTHERS[1], "roll and sway"),
                       "surge": (OTHERS[3], "surge")}[name]  # fmt: skip
        known = right.get_legend_handles_labels()[1]
        right.plot(height, roots.real, color=color, label=None if word in known else word)
    figure.colorbar(dots, ax=left, label="Metacentric height [mm]", shrink=0.9)
    for word, place in (("pitch", (-0.085, 0.30)), ("roll and sway", (-0.29, 0.13)), ("surge", (-0.37, 0.065))):
        left.text(*place, word, color=DIM, fontsize=8.5)
    left.axvline(0.0, color=INK, lw=0.9)
    left.set(
        title="Slow eigenvalues, upper half",
        xlabel="Re λ [1/s]",
        ylabel="Im λ [rad/s]",
        ylim=(-0.015, 0.45),
        xlim=(-0.42, 0.2),
    )
    right.axhline(0.0, color=INK, lw=0.9)
    crossing = 1e3 * float(crossings[0])
    right.plot(crossing, 0.0, "o", ms=6, color=OTHERS[0], mec="white", zorder=4)
    right.annotate(f"unstable from {crossing:.2f} mm on", (crossing, 0.0), (-6, 24), textcoords="offset points",
                   ha="right", color=OTHERS[0], fontsize=8.5,
                   arrowprops={"arrowstyle": "-", "color": OTHERS[0], "lw": 0.8})  # fmt: skip
    right.set(title="Growth [1/s]", xlabel="Metacentric height [mm]", xlim=(height.max(), height.min()))
    right.legend(loc="lower left", bbox_to_anchor=(0.0, 0.06))
    return figure


def stability_figure() -> Figure:
    """Draw margins, growth and pitch along the dive in which the ballast is lifted."""
    figure, axes = new_figure(9.2, 5.2, nrows=2, ncols=2, sharex=True)
    (still, flow), (growth, pitch) = axes
    run, history = schedule.lifted()
    shown = thin(len(run.times), 400)
    series = (
        (still, 1e3, "hydrostatic_margin", "margin", PATH),
        (still, 1e3, "pitch_stiffness", "pitch stiffness", OTHERS[2]),
        (still, 1e3, "roll_stiffness", "roll stiffness", OTHERS[1]), (flow, 100.0, "pitch_margin", "pitch", OTHERS[2]),
        (flow, 100.0, "yaw_margin", "yaw", OTHERS[3]),
    )  # fmt: skip
    for ax, factor, name, label, color in series:
        style = {"ls": (0, (4, 2))} if name == "pitch_stiffness" else {}
        ax.plot(run.times[shown], factor * getattr(history, name)[shown], color=color, label=label, **style)
    growth.plot(history.growth_times, history.growth, color=ABOVE[1])
    pitch.plot(run.times[shown], np.degrees(run.values["theta"])[shown], color=BELOW[0])
    bad = history.growth > 0.0
    for ax in axes.flat:
        ax.axvspan(history.growth_times[bad][0], history.growth_times[bad][-1], color=SHADE, lw=0, zorder=0.5)
        ax.set_xlim(0.0, run.times[-1])
    for ax in (still, flow, growth):
        ax.axhline(0.0, color=INK, lw=0.9)
    still.set_title("Hydrostatic margin and stiffnesses [mm]")
    flow.set_title("Hydrodynamic margins [% of length]")
    growth.set(title="Growth [1/s]", xlabel="Time [s]")
    pitch.set(title="Pitch [deg]", xlabel="Time [s]")
    still.legend(loc="center left")
    flow.legend(loc="center left")
    return figure
