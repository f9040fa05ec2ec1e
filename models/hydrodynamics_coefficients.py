"""Owns the coefficient form of the glider literature: dimensional coefficients in the flow frame, angles in radians.

D = (K_D0 + K_D alpha^2 + K_Db beta^2) V^2, SF = K_beta beta V^2, L = (K_L0 + K_L alpha) V^2; the force (-D, SF, -L) and
the moment (K, M, N) stand in the flow frame (Leonard, Graver, 2001, IEEE J. Ocean. Eng. 26; Zhang et al., 2013, Ocean
Eng. 60). K = (K_MR beta + K_p p) V^2, M = (K_M0 + K_M alpha + K_q q + K_q2 q |q|) V^2, N = (K_MY beta + K_r r) V^2.
"""

from __future__ import annotations

from typing import Literal

from models.fields import Switch, quantity, text
from models.hydrodynamics import Source, coefficient

PER_SPEED2, MOMENT_PER_SPEED2 = "N s2/m2", "N m s2/m2"


class CoefficientForm(Source):
    """Lift, drag, side force and moments by the coefficients of the glider literature."""

    kind: Literal["coefficients"] = text("Which source this is: coefficients of the glider literature.")
    includes_munk_moment: Switch = text(
        "Whether the moments already hold the Munk moment; those of the literature do not.", default=False
    )
    alpha_limit_deg: float = quantity(
        "Largest angle of attack for which the coefficients were meant; beyond it they go on, and the run says so.",
        unit="deg", symbol="alpha_max", gt=0.0, le=180.0, default=20.0,
    )  # fmt: skip
    beta_limit_deg: float = quantity(
        "Largest sideslip for which the coefficients were meant; beyond it they go on, and the run says so.",
        unit="deg", symbol="beta_max", gt=0.0, le=90.0, default=20.0,
    )  # fmt: skip
    drag_zero: float = quantity("Drag at zero angles.", unit=PER_SPEED2, symbol="K_D0", gt=0.0, le=1e9)
    drag_attack: float = coefficient(
        "Drag by the squared angle of attack.", unit=f"{PER_SPEED2}/rad2", symbol="K_D", ge=0.0
    )
    drag_sideslip: float = coefficient(
        "Drag by the squared sideslip.", unit=f"{PER_SPEED2}/rad2", symbol="K_Dbeta", ge=0.0
    )
    side_sideslip: float = coefficient("Side force by sideslip.", unit=f"{PER_SPEED2}/rad", symbol="K_beta")
    lift_zero: float = coefficient("Lift at zero angle of attack.", unit=PER_SPEED2, symbol="K_L0")
    lift_attack: float = coefficient("Lift by the angle of attack.", unit=f"{PER_SPEED2}/rad", symbol="K_L")
    roll_sideslip: float = coefficient("Roll moment by sideslip.", unit=f"{MOMENT_PER_SPEED2}/rad", symbol="K_MR")
    roll_rate: float = coefficient("Roll moment by roll rate.", unit=f"{MOMENT_PER_SPEED2} s/rad", symbol="K_p")
    pitch_zero: float = coefficient("Pitch moment at zero angle of attack.", unit=MOMENT_PER_SPEED2, symbol="K_M0")
    pitch_attack: float = coefficient(
        "Pitch moment by the angle of attack.", unit=f"{MOMENT_PER_SPEED2}/rad", symbol="K_M"
    )
    pitch_rate: float = coefficient("Pitch moment by pitch rate.", unit=f"{MOMENT_PER_SPEED2} s/rad", symbol="K_q")
    pitch_rate_square: float = coefficient("Pitch moment by q |q|.", unit=f"{MOMENT_PER_SPEED2} s2/rad2", symbol="K_q2")
    yaw_sideslip: float = coefficient("Yaw moment by sideslip.", unit=f"{MOMENT_PER_SPEED2}/rad", symbol="K_MY")
    yaw_rate: float = coefficient("Yaw moment by yaw rate.", unit=f"{MOMENT_PER_SPEED2} s/rad", symbol="K_r")
    rate_scaling: Literal["speed_squared", "speed", "none"] = text(
        "What the terms with p, q, r are multiplied by: V^2 (the literature's), V, or nothing; units change with it.",
        default="speed_squared",
    )
