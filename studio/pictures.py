"""Owns the pictures that the command line draws of analyses, by Matplotlib; the ending of the file says the format."""

from __future__ import annotations

import math
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from models.design import Design
from server import schemas_analyses as wire
from server import schemas_linear as small
from studio.palette import PLOT_COLORS

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from models.loop_response import LoopResponse

DEGREES = 180.0 / math.pi


def sheet(design: Design, rows: int, columns: int, *, size: tuple[float, float]) -> tuple[Figure, Any]:
    """Return a figure with its axes, titled by the design; loaded here, for Matplotlib takes a second."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure = Figure(figsize=size, layout="constrained")
    FigureCanvasAgg(figure)
    figure.suptitle(design.name, fontsize=11)
    axes = figure.subplots(rows, columns, squeeze=False)
    for each in axes.flat:
        each.grid(True, color="#dddddd", linewidth=0.6)
        each.set_axisbelow(True)
    return figure, axes


def save(figure: Figure, path: Path) -> None:
    """Write a figure; raises `OSError` where the file cannot be written or has no known ending."""
    if path.suffix[1:] not in figure.canvas.get_supported_filetypes():
        raise OSError(f"a picture is written as .png, .svg or .pdf, not '{path.suffix}'")
    figure.savefig(path, dpi=150)


def polar(answer: wire.PolarAnswer, design: Design, path: Path) -> None:
    """Draw horizontal and vertical speed of every glide, and the named points."""
    figure, axes = sheet(design, 1, 1, size=(9.0, 5.2))
    plot: Axes = axes[0, 0]
    for k, curve in enumerate(answer.curves):
        color = PLOT_COLORS[k % len(PLOT_COLORS)]
        across = [trim.speed * math.cos(trim.glide_angle) for trim in curve.trims]
        line = "-" if len(across) > 1 else "."
        plot.plot(across, [-t.sink_rate for t in curve.trims], line, color=color, label=f"heave {curve.heave:+.3g} N")
        shaky = [(a, -t.sink_rate) for a, t in zip(across, curve.trims, strict=True) if not t.stable]
        if shaky:
            plot.plot(*zip(*shaky, strict=True), "x", color=color, markersize=4)
    cheapest = None if answer.best_energy is None else answer.best_energy.trim
    named = {
        "best range": answer.best_range, "least energy": cheapest, "slowest sink": answer.slowest_sink,
        "tightest turn": answer.tightest_turn,
    }  # fmt: skip
    for (name, trim), mark in zip(named.items(), "o^sD", strict=True):
        if trim is not None:
            at = (trim.speed * math.cos(trim.glide_angle), -trim.sink_rate)
            plot.plot(*at, mark, color="#222222", markersize=7, label=name)
    plot.axhline(0.0, color="#888888", linewidth=0.8)
    plot.set_xlabel("horizontal speed, m/s")
    plot.set_ylabel("vertical speed, m/s (up)")
    plot.set_title("Glide polar; crosses are unstable", fontsize=10)
    figure.legend(fontsize=8, loc="outside right upper")
    save(figure, path)


def linear(answer: small.LinearizeAnswer, design: Design, path: Path) -> None:
    """Draw the eigenvalues, the root locus if there is one, and the frequency responses."""
    bode = bool(answer.responses)
    figure, axes = sheet(design, 1, 3 if bode else 1, size=(15.0 if bode else 8.5, 4.8))
    _eigenvalues(axes[0, 0], answer)
    if bode:
        for k, response in enumerate(answer.responses):
            label = f"{response.input.removeprefix('command of ')} to {response.output}"
            color = PLOT_COLORS[k % len(PLOT_COLORS)]
            decibels = [math.nan if value is None else value for value in response.magnitude_db]
            axes[0, 1].semilogx(response.frequencies, decibels, color=color, label=label)
            axes[0, 2].semilogx(response.frequencies, np.array(response.phase) * DEGREES, color=color)
        axes[0, 1].set_ylabel("magnitude, dB")
        axes[0, 2].set_ylabel("phase, deg")
        axes[0, 1].legend(fontsize=8)
        for plot in axes[0, 1:]:
            plot.set_xlabel("frequency, rad/s")
    save(figure, path)


def _eigenvalues(plot: Axes, answer: small.LinearizeAnswer) -> None:
    if answer.locus is not None:
        table = np.array([row for row in answer.locus.eigenvalues if row is not None])
        for k in range(table.shape[1]):
            color = PLOT_COLORS[k % len(PLOT_COLORS)]
            plot.plot(table[:, k, 0], table[:, k, 1], "-", color=color, linewidth=1.2)
            plot.plot(table[:, k, 0], -table[:, k, 1], "-", color=color, linewidth=1.2)
    for k, mode in enumerate(answer.modes.modes):
        color = PLOT_COLORS[k % len(PLOT_COLORS)]
        plot.plot([mode.real] * 2, [mode.imag, -mode.imag], "x", color=color, markersize=8, label=mode.name)
    plot.axvline(0.0, color="#888888", linewidth=0.8)
    plot.set_xlabel("growth, 1/s")
    plot.set_ylabel("angular frequency, rad/s")
    plot.set_title("Modes", fontsize=10)
    plot.figure.legend(*plot.get_legend_handles_labels(), fontsize=7, loc="outside left upper")


def stability(answer: small.StabilityAnswer, design: Design, path: Path) -> None:
    """Draw the margins and the growth of small motions over the mission."""
    figure, axes = sheet(design, 3, 1, size=(9.0, 7.5))
    for plot in axes[1:, 0]:
        plot.sharex(axes[0, 0])
    still, flow, growth = axes[:, 0]
    times = answer.times
    for name, label, color, line in (
        ("pitch_stiffness", "stiffness in pitch", PLOT_COLORS[1], "-"),
        ("roll_stiffness", "stiffness in roll", PLOT_COLORS[2], "-"),
        ("hydrostatic_margin", "CoB above CoM", PLOT_COLORS[0], "--"),
    ):
        still.plot(times, 1e3 * np.array(getattr(answer, name), dtype=float), line, color=color, label=label)
    for name, label, color in (("pitch_margin", "in pitch", PLOT_COLORS[0]), ("yaw_margin", "in yaw", PLOT_COLORS[1])):
        values = np.array(getattr(answer, name), dtype=float)
        if np.isfinite(values).any():
            flow.plot(times, values, color=color, label=label)
    growth.plot(answer.growth_times, np.array(answer.growth, dtype=float), color=PLOT_COLORS[3], label="largest growth")
    for plot, label in zip(
        (still, flow, growth), ("hydrostatic margin, mm", "hydrodynamic margin, lengths", "growth, 1/s"), strict=True
    ):
        plot.axhline(0.0, color="#888888", linewidth=0.8)
        plot.set_ylabel(label)
        plot.legend(fontsize=8, loc="best")
    growth.set_xlabel("time, s")
    save(figure, path)


def step(response: LoopResponse, design: Design, path: Path) -> None:
    """Draw the response to a step, linear and flown, and the commands that it takes."""
    figure, axes = sheet(design, 2, 1, size=(9.0, 6.0))
    state, commands = axes[:, 0]
    commands.sharex(state)
    angle = response.state != "u"
    factor = DEGREES if angle else 1.0
    state.axhline(factor * response.goal, color="#888888", linewidth=0.8)
    state.plot(response.times, factor * response.predicted_state, "--", color=PLOT_COLORS[0], label="linear")
    if response.run is not None:
        flown = factor * response.flown_state
        state.plot(response.times[: len(flown)], flown, color=PLOT_COLORS[1], label="flown")
    state.set_ylabel(f"{response.state}, {'deg' if angle else 'm/s'}")
    for k, cell in enumerate(response.cells):
        color = PLOT_COLORS[k % len(PLOT_COLORS)]
        commands.step(response.times, 1e3 * response.commands[:, k], where="post", color=color, label=cell)
    commands.set_ylabel("commands, mm or mrad (linear)")
    commands.set_xlabel("time, s")
    for plot in (state, commands):
        plot.legend(fontsize=8, loc="best")
    save(figure, path)
