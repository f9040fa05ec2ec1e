"""Owns the figures of docs/validation.md: SVG with thinned curves, the same byte for byte between two runs."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import matplotlib
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Circle
from numpy.typing import NDArray

from docs import validation_conservation as conservation
from docs import validation_energy as energy
from docs import validation_equations as equations
from docs import validation_motions as motions
from docs import validation_seawing as seawing
from docs import validation_slocum as slocum
from docs import validation_symmetries as symmetries
from docs import validation_water as water
from docs.figures import DIM, FAINT, INK, OTHERS, PATH, STYLE, new_figure

Array = NDArray[np.float64]
HUES = (PATH, "#d4652f", "#16785b", "#7a4fc4", "#b2760a", "#c0392b", "#47596c", "#7fb9dc", "#96281b", "#8b9aaa",
        "#e58a6b", "#b58be0")  # fmt: skip
SMALLEST = 1e-17
"""Where a difference of zero is drawn on a logarithmic axis."""
DOTS = {"ls": "none", "marker": "o", "ms": 3.6, "mec": "white", "mew": 0.5}


def write_figures(folder: Path) -> list[str]:
    """Draw every figure into the folder; return the file names."""
    drawn: dict[str, Callable[[], Figure]] = {
        "equations": equations_figure, "conservation": conservation_figure, "symmetries": symmetries_figure,
        "terminal": terminal_figure, "trim": trim_figure, "balance": balance_figure, "seawing": seawing_figure,
        "slocum": slocum_figure, "water": water_figure, "bill": bill_figure,
    }  # fmt: skip
    with matplotlib.rc_context(STYLE):
        for name, draw in drawn.items():
            path = folder / f"validation-{name}.svg"
            draw().savefig(path, format="svg", metadata={"Date": None, "Creator": None})
    return [f"validation-{name}.svg" for name in drawn]


def thin(count: int, points: int = 160) -> NDArray[np.intp]:
    """Return the indices of at most `points` samples, evenly spread, the ends among them."""
    return np.unique(np.linspace(0, count - 1, min(count, points)).astype(np.intp))


def _legend_below(figure: Figure, ax: Axes, columns: int) -> None:
    figure.legend(*ax.get_legend_handles_labels(), loc="outside lower center", ncols=columns, columnspacing=1.6)


def equations_figure() -> Figure:
    """Draw the differences of M, V, G by components, and the histogram of those of the spatial accelerations."""
    figure, (left, right) = new_figure(9.2, 3.4, ncols=2)
    planar = equations.planar_differences()
    for name, color, marker in (("M", PATH, "o"), ("V", "#d4652f", "s"), ("G", "#16785b", "^")):
        values = [max(getattr(case, name), SMALLEST) for case in planar]
        left.semilogy([case.count for case in planar], values, marker, ms=5, color=color, ls="none", label=name)
    left.axhline(equations.DEMANDED["planar"], color=FAINT, ls=(0, (4, 2)), lw=1.2)
    left.set(title="Planar: largest of the random states", xlabel="Components", ylabel="Relative difference",
             ylim=(1e-17, 1e-10), xticks=range(1, 6))  # fmt: skip
    left.legend(ncols=3)
    cases = equations.spatial_differences()
    groups = ([c for c in cases if "test" in c.name], [c for c in cases if "test" not in c.name])
    data = [np.maximum(np.concatenate([c.relative for c in group]), SMALLEST) for group in groups]
    right.hist(data, bins=np.logspace(-17, -8, 37), stacked=True, color=[PATH, "#f2b134"],
               label=["test glider", "presets"])  # fmt: skip
    right.axvline(equations.DEMANDED["spatial"], color=FAINT, ls=(0, (4, 2)), lw=1.2)
    right.set(title="Spatial: accelerations at random states", xlabel="Relative difference", ylabel="States",
              xscale="log")  # fmt: skip
    right.legend()
    return figure


def conservation_figure() -> Figure:
    """Draw drift of energy and error of states against the step, with the orders by theory."""
    figure, axes = new_figure(9.2, 3.8, ncols=2)
    looks = {"planar": ("o", "-"), "spatial": ("s", "--")}
    for ax, what in zip(axes, ("drift", "state"), strict=True):
        for case in conservation.convergences():
            if case.what != what:
                continue
            color, (marker, line) = PATH if case.theory == 4 else "#d4652f", looks[case.model]
            ax.loglog(case.steps, case.errors, marker, ms=5, color=color, label=f"{case.model}, {case.method}")
            slope = case.errors[-1] * (case.steps / case.steps[-1]) ** case.theory
            ax.loglog(case.steps, slope, color=color, ls=line, lw=1.0)
        ax.set(xlabel="Step [s]")
    axes[0].set(title="Drift of T + U without dissipation", ylabel="Largest drift [J]")
    axes[1].set(title="Error of the states", ylabel="Largest error [m, rad, m/s, rad/s]")
    _legend_below(figure, axes[0], 4)
    return figure


def symmetries_figure() -> Figure:
    """Draw planar paths over spatial ones, and the spiral mirrored, turned and carried."""
    figure, (left, right) = new_figure(9.2, 4.4, ncols=2, width_ratios=(1.0, 1.1))
    for case, color in zip(symmetries.plane_cases(), HUES, strict=False):
        x, z = case.planar.values["x"], case.planar.values["z"]
        length = float(np.abs(x).max())
        shown, dots = thin(len(x)), thin(len(x), 16)
        left.plot(x[shown] / length, (z - z[0])[shown] / length, color=color, label=case.preset_id)
        s = case.spatial.values
        left.plot(s["x"][dots] / length, (s["z"] - z[0])[dots] / length, color=color, **DOTS)
    left.set(title="Planar (lines) and spatial (dots)", xlabel="Distance, share of the whole",
             ylabel="Depth gained, same scale")  # fmt: skip
    left.invert_yaxis()
    left.legend()
    moved = next(case for case in symmetries.moved_cases() if case.name == symmetries.DRAWN)
    original = symmetries.path(moved.original)
    shown, dots = thin(len(original)), thin(len(original), 46)
    right.plot(*original[shown, 1::-1].T, color=INK, lw=2.2, label="original")
    words = {"mirror": "mirrored", "yaw": "turned by 40°", "current": "carried by a current"}
    for i, ((kind, run), color) in enumerate(zip(moved.runs.items(), OTHERS, strict=False)):
        right.plot(*symmetries.path(run)[shown, 1::-1].T, color=color, lw=1.2, label=words[kind])
        back = symmetries.mapped_back(kind, run)[dots[i::3]]
        right.plot(*back[:, 1::-1].T, color=color, **DOTS)
    right.set(title="From above: dots are mapped back", xlabel="East y [m]", ylabel="North x [m]", aspect="equal")
    _legend_below(figure, right, 4)
    return figure


def terminal_figure() -> Figure:
    """Draw terminal speed against net weight, and the approach to it."""
    figure, (left, right) = new_figure(9.2, 3.5, ncols=2)
    for sign, marker, word in ((1, "v", "sinking"), (-1, "^", "rising")):
        cases = [f for f in motions.falls() if f.net_weight * sign > 0]
        W = np.array([abs(f.net_weight) for f in cases])
        if sign > 0:
            left.loglog(W, [abs(f.expected) for f in cases], color=INK, lw=1.2, label=r"$\sqrt{W / P_D}$")
        face = PATH if sign > 0 else "none"
        left.loglog(W, [abs(f.speed) for f in cases], marker, ms=5.0 if sign > 0 else 9.0, mfc=face, ls="none",
                    color=PATH if sign > 0 else "#d4652f", label=word)  # fmt: skip
    left.set(title="Terminal speed", xlabel="Net weight W [N]", ylabel="Speed [m/s]")
    left.legend()
    t = np.linspace(0.0, 4.0, 120)
    right.plot(t, np.tanh(t), color=INK, lw=1.2, label="tanh")
    for i, (f, color) in enumerate(zip(motions.falls()[:7:2], HUES, strict=False)):
        time, share = f.approach
        dots = np.flatnonzero(time <= 4.0)[2 * i :: 8]
        right.plot(time[dots], share[dots], color=color, label=f"{f.net_weight:g} N", **DOTS)
    right.set(title="Approach to it", xlabel=r"Time [$m / \sqrt{W P_D}$]", ylabel="Share of the terminal speed")
    right.legend()
    return figure


def trim_figure() -> Figure:
    """Draw the departure from the closed-form equilibrium over time, started on it and off it."""
    figure, ax = new_figure(7.2, 3.4)
    for offset, color in zip(slocum.OFFSETS_DEG, (INK, PATH, "#16785b", "#d4652f"), strict=True):
        run = slocum.started_at_trim(offset, "spatial")
        values, shown = np.maximum(slocum.departure(run), SMALLEST), thin(len(run.times), 200)
        label = "on it" if offset == 0.0 else f"pitch {offset:g}° off"
        ax.semilogy(run.times[shown], values[shown], color=color, lw=1.3, label=label)
    ax.axhline(slocum.FIXED_POINT, color=FAINT, ls=(0, (4, 2)), lw=1.2)
    ax.set(title="Departure from the closed-form equilibrium", xlabel="Time [s]", xlim=(0, 600),
           ylabel="Largest of θ, u, w, q [rad, m/s, rad/s]", ylim=(1e-14, 1.0))  # fmt: skip
    _legend_below(figure, ax, 4)
    return figure


def balance_figure() -> Figure:
    """Draw the energy residual of every preset over time, and its largest against the tolerance."""
    figure, (left, right) = new_figure(9.2, 4.2, ncols=2)
    for balance, color in zip(energy.balances(), HUES, strict=False):
        times, shares = energy.largest_over_time(balance.run)
        left.semilogy(times / balance.run.times[-1], shares, color=color, lw=1.2, label=balance.preset_id)
        right.loglog(list(balance.relative), list(balance.relative.values()), "o-", ms=4, color=color, lw=1.0)
    left.axhline(energy.DEMANDED["balance"], color=FAINT, ls=(0, (4, 2)), lw=1.2)
    left.set(title="Over time, at the default tolerance", xlabel="Time, share of the mission",
             ylabel="Residual / energy exchanged", ylim=(1e-17, 1e-5))  # fmt: skip
    right.set(title="Largest", xlabel="Tolerance", ylabel="Residual / energy exchanged")
    right.invert_xaxis()
    _legend_below(figure, left, 4)
    return figure


def seawing_figure() -> Figure:
    """Draw the path from above with the published radius, and the approach of the angles and the turn rate."""
    figure, whole = new_figure(9.2, 5.0)
    whole.remove()
    axes = figure.subplot_mosaic([["path", "phi", "theta"], ["path", "beta", "turn_rate"]], width_ratios=(1.8, 1, 1))
    run, ax = seawing.spiral(), axes["path"]
    shown = thin(len(run.times), 300)
    ax.plot(run.values["y"][shown], run.values["x"][shown], color=PATH, lw=1.2, label="simulated")
    x, y = seawing.center()
    radius = seawing.published()["published"]["R_m"]
    ax.add_patch(
        Circle((y, x), radius, fill=False, color="#d4652f", ls=(0, (4, 2)), label="published radius, our axis")
    )
    ax.plot(run.values["y"][0], run.values["x"][0], "o", color=INK, ms=5, label="start, at rest")
    ax.set(title="Path from above", xlabel="East y [m]", ylabel="North x [m]", aspect="equal")
    ax.legend(loc="upper center", bbox_to_anchor=(0.5, -0.16))
    for row in seawing.rows():
        q = row.quantity
        if q.name not in axes:
            continue
        early = run.times <= 150.0
        axes[q.name].plot(run.times[early], q.factor * run.values[q.name][early], color=PATH, lw=1.3)
        axes[q.name].axhline(row.published, color="#d4652f", ls=(0, (4, 2)), lw=1.2)
        axes[q.name].set(title=f"{q.words} [{q.unit}]", xlabel="Time [s]", xlim=(0, 150))
    axes["turn_rate"].set_ylim(-0.02, 0.03)  # it swings ten times as far in the first seconds
    return figure


def slocum_figure() -> Figure:
    """Draw the glide polar at one ballast, and the angle of attack and mass position against the path angle."""
    figure, (left, right) = new_figure(9.2, 3.9, ncols=2)
    left.plot(*slocum.polar_line().T, color=INK, lw=1.2, label="closed form")
    looks = (("planar", "o", 6.5, PATH), ("spatial", "x", 5.0, "#d4652f"))
    for model, marker, size, color in looks:
        finals = [case.runs[model].final for case in slocum.polar()]
        left.plot([f["x_dot"] for f in finals], [f["z_dot"] for f in finals], marker, ms=size, color=color, ls="none",
                  label=f"simulated, {model}")  # fmt: skip
    left.set(title="Glide polar at one ballast", xlabel="Horizontal speed [m/s]", ylabel="Sinking speed [m/s]")
    left.invert_yaxis()
    left.legend()
    angles = np.linspace(slocum.shallowest() + 1e-9, np.radians(50.0), 160)
    lines = [slocum.closed_form(-float(a), slocum.published()["parameters"]["V_d"]) for a in angles]
    right.plot(np.degrees(angles), np.degrees([g.alpha for g in lines]), color=INK, lw=1.2, label="closed form")
    for model, marker, size, color in looks:
        cases = [case for case in slocum.glides() if case.closed.xi < 0.0]
        right.plot([-np.degrees(c.closed.xi) for c in cases], np.degrees([c.runs[model].final["alpha"] for c in cases]),
                   marker, ms=size, color=color, ls="none")  # fmt: skip
    shallowest = float(np.degrees(slocum.shallowest()))
    right.axvline(shallowest, color=FAINT, ls=(0, (4, 2)), lw=1.2)
    right.annotate("shallowest", (shallowest, 1.0), xytext=(4, 0), textcoords="offset points", color=DIM)
    right.set(title="Angle of attack at 0.3 m/s", xlabel="Path angle, down [deg]", ylabel="α [deg]", ylim=(0, 17))
    return figure


def water_figure() -> Figure:
    """Draw the floats' oscillations over the closed form, and the differences of density."""
    figure, (left, right) = new_figure(9.2, 3.6, ncols=2, width_ratios=(1.7, 1.0))
    for case, color in zip(water.oscillations(), HUES, strict=False):
        shown, dots = thin(len(case.run.times), 200), thin(len(case.run.times), 60)
        left.plot(case.run.times[shown], case.closed[shown] / case.amplitude, color=color, lw=1.1, label=case.name)
        left.plot(case.run.times[dots], case.simulated[dots] / case.amplitude, color=color, **DOTS)
    left.set(title="Float about its neutral depth", xlabel="Time [s]", ylabel="Depth less neutral, share of the start")
    data = water.published()
    right.plot(np.array(data["p"]), 1e3 * (water.densities() - np.array(data["rho"])), "o", color=PATH, ms=5)
    for sign in (1.0, -1.0):
        right.axhline(sign * 1e3 * data["agreement"]["rho"], color=FAINT, ls=(0, (4, 2)), lw=1.2)
    right.set(title="Density less published", xlabel="Pressure [dbar]", ylabel="Difference [g/m³]")
    _legend_below(figure, left, 3)
    return figure


def bill_figure() -> Figure:
    """Draw the energy that one expansion takes against the depth."""
    figure, ax = new_figure(6.4, 3.4)
    pumps = sorted({(bill.efficiency, bill.recovery) for bill in energy.bills()})
    for (efficiency, recovery), color in zip(pumps, HUES, strict=False):
        cases = [b for b in energy.bills() if (b.efficiency, b.recovery) == (efficiency, recovery)]
        ends = (0.0, energy.DEPTHS[-1])
        label = f"efficiency {efficiency:g}" + (f", recovery {recovery:g}" if recovery else "")
        ax.plot(ends, [energy.closed_bill(d, efficiency, recovery) for d in ends], color=color, lw=1.2, label=label)
        ax.plot([b.depth for b in cases], [b.taken for b in cases], color=color, **(DOTS | {"ms": 5.5}))
    ax.set(title="Lines: p ΔV / efficiency; dots: simulated", xlabel="Depth [m]", ylabel="Energy taken [J]")
    ax.legend()
    return figure
