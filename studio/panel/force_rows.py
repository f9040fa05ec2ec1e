"""Owns the rows of the forces of the water: the source of the hydrodynamics, added mass and linear damping."""

from __future__ import annotations

from models.design import Design
from models.hydrodynamic_law import FitError, build_law
from models.hydrodynamics import AddedMass, Damping, PolarTable
from models.hydrodynamics_angles import AngleTable
from models.hydrodynamics_coefficients import CoefficientForm
from studio.panel.rows import DAMPING, DAMPING_LINEAR, Row, Unit, field_row, is_spatial, note

ROOT = ("vehicle", "hydrodynamics")
LAWS = (("PCHIP", "pchip"), ("polynomial", "polynomial"))
SQUARE, SQUARE_PER_RAD2 = Unit("N s²/m²", 1.0, 5), Unit("/rad²", 1.0, 5)
LIFT_SLOPE, MOMENT_SLOPE = Unit("/rad", 1.0, 5), Unit("/rad", 1.0, 5)
ANGLE = Unit("°", 1.0, 2)  # these fields are in degrees in the document too


def hydrodynamics_rows(design: Design) -> list[Row]:
    """Return what can be chosen of the force data, and what they are and are not."""
    source = design.vehicle.hydrodynamics
    match source:
        case PolarTable():
            rows = _polar_rows(design, source)
        case AngleTable():
            rows = [note(lambda d: _grid_in_words(d.vehicle.hydrodynamics))]
        case CoefficientForm():
            rows = _coefficient_rows()
    return [*rows, note(lambda d: _provenance_in_words(d))]


def _provenance_in_words(design: Design) -> str:
    about = design.vehicle.hydrodynamics.provenance
    return f"{about.title}. {about.limits}".strip()


def _polar_rows(design: Design, table: PolarTable) -> list[Row]:
    speeds = (("average", None), *((f"{v:g} m/s", v) for v in table.speeds))
    rows = [
        field_row("Law", (*ROOT, "law"), PolarTable, widget="choice", choices=LAWS),
        field_row("Data speed", (*ROOT, "speed"), PolarTable, widget="choice", choices=speeds),
        note(lambda d: _misfit_in_words(d)),
    ]
    if is_spatial(design):
        rows.append(note(lambda d: _lateral_in_words(d)))
    return rows


def _misfit_in_words(design: Design) -> str:
    source = design.vehicle.hydrodynamics
    errors: tuple[FitError, ...] = build_law(source).errors if isinstance(source, PolarTable) else ()
    fits = "; ".join(f"{e.quantity} {100 * e.relative:.1f} % at {e.largest_at_deg:.0f}°" for e in errors)
    return f"Largest misfit of the data's range: {fits}."


def _lateral_in_words(design: Design) -> str:
    lateral = getattr(design.vehicle.hydrodynamics, "lateral", None)
    if lateral is None:
        return "No side force, roll or yaw moment is known: nothing holds the glider against sideslip."
    return f"Side force, roll and yaw moments: {lateral.source}"


def _grid_in_words(source: object) -> str:
    if not isinstance(source, AngleTable):
        return ""
    a, b = source.alpha_deg, source.beta_deg
    mirrored = " (and mirrored)" if source.mirrored else ""
    return (
        f"Table over {len(a)} angles of attack, {a[0]:g} to {a[-1]:g}°, and {len(b)} sideslips, {b[0]:g} to "
        f"{b[-1]:g}°{mirrored}. Beyond, the forces of its edge are held."
    )


def _coefficient_rows() -> list[Row]:
    form = CoefficientForm
    return [
        field_row("Drag K_D0", (*ROOT, "drag_zero"), form, unit=SQUARE),
        field_row("Drag K_D", (*ROOT, "drag_attack"), form, unit=SQUARE_PER_RAD2),
        field_row("Lift K_L0", (*ROOT, "lift_zero"), form, unit=SQUARE),
        field_row("Lift K_L", (*ROOT, "lift_attack"), form, unit=LIFT_SLOPE),
        field_row("Pitch K_M", (*ROOT, "pitch_attack"), form, unit=MOMENT_SLOPE),
        field_row("Side K_beta", (*ROOT, "side_sideslip"), form, unit=LIFT_SLOPE),
        field_row("Roll K_MR", (*ROOT, "roll_sideslip"), form, unit=MOMENT_SLOPE),
        field_row("Yaw K_MY", (*ROOT, "yaw_sideslip"), form, unit=MOMENT_SLOPE),
        field_row("Attack up to", (*ROOT, "alpha_limit_deg"), form, unit=ANGLE),
        field_row("Sideslip up to", (*ROOT, "beta_limit_deg"), form, unit=ANGLE),
    ]


def damping_rows(design: Design) -> list[Row]:
    """Return the switch of the added mass, and the linear damping."""
    root = ("vehicle", "damping")
    rows: list[Row] = []
    if design.vehicle.added_mass is not None:
        rows.append(field_row("Added mass", ("vehicle", "added_mass", "enabled"), AddedMass, widget="switch"))
    rows += [
        field_row("Pitch damping C33", (*root, "pitch"), Damping, unit=DAMPING, step=0.001),
        field_row("Surge damping", (*root, "surge"), Damping, unit=DAMPING_LINEAR, step=0.01),
        field_row("Heave damping", (*root, "heave"), Damping, unit=DAMPING_LINEAR, step=0.01),
    ]
    if is_spatial(design):
        rows += [
            field_row("Sway damping", (*root, "sway"), Damping, unit=DAMPING_LINEAR, step=0.01),
            field_row("Roll damping", (*root, "roll"), Damping, unit=DAMPING, step=0.001),
            field_row("Yaw damping", (*root, "yaw"), Damping, unit=DAMPING, step=0.001),
        ]
        if design.vehicle.damping.matrix is not None:
            rows.append(note(lambda _: "A full damping matrix is stated in the document, and added to these."))
    return rows
