"""Owns the formulas by which the quad-bellows glider's lateral coefficients and added mass follow from its geometry.

Body axes (x to the nose, y to starboard, z down through the keel), moments about the body origin, SI units. Every
coefficient multiplies V, V^2 or an acceleration as stated. The Munk moment is not in them: the added mass brings it.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

PLATE_CROSSFLOW, CYLINDER_CROSSFLOW, BLUNT_CYLINDER = 1.2, 0.9, 0.9
"""Drag coefficients of a plate across the flow (square: 1.17), a cylinder across it (0.82 at 10 diameters, 0.98 at 40)
and a blunt cylinder along it (0.87 at 4 diameters, 0.99 at 7). Matthews, 2002, Aeronautical Engineer's Data Book,
section 5.9; Hoerner, 1965, Fluid-Dynamic Drag, chapter III."""


@dataclass(frozen=True)
class Fin:
    """A flat upright panel over the hull: a trapezium whose root lies at height z = `root_z` (m, negative: above).

    `leading_x` is where the root's leading edge lies, `sweep` how far the tip's leading edge lies behind it (m).
    """

    span: float
    chord: float
    tip_chord: float
    sweep: float
    thickness: float
    leading_x: float
    root_z: float

    @property
    def area(self) -> float:
        """Area of one side, m2."""
        return 0.5 * self.span * (self.chord + self.tip_chord)

    @property
    def aspect_ratio(self) -> float:
        """Span squared over area, of the panel alone."""
        return self.span**2 / self.area

    def integral(self, integrand: Callable[[Array, Array, Array], Array]) -> float:
        """Integrate over the span a function of chord c, mid-chord x and height z (m), by Gauss-Legendre (exact)."""
        nodes, weights = np.polynomial.legendre.leggauss(6)
        s = 0.5 * (1.0 + nodes)
        c = self.chord + (self.tip_chord - self.chord) * s
        x = self.leading_x - self.sweep * s - 0.5 * c
        z = self.root_z - self.span * s
        return float(0.5 * self.span * np.sum(weights * integrand(c, x, z)))


@dataclass(frozen=True)
class Bar:
    """A circular cylinder along x outside the hull, centred at (x, 0, z), m."""

    length: float
    diameter: float
    x: float
    z: float


def helmbold_slope(aspect_ratio: float) -> float:
    """Return the lift slope of a straight wing of any aspect ratio, 1/rad, on its area.

    a = 2 pi A / (2 + sqrt(A^2 + 4)); 2 pi for A to infinity, pi A / 2 (R. T. Jones, 1946) for A to 0. Helmbold, 1942,
    Jahrbuch der Deutschen Luftfahrtforschung, I 111; DATCOM (Hoak, 1978), section 4.1.3.2, unswept and incompressible.
    """
    return 2.0 * math.pi * aspect_ratio / (2.0 + math.hypot(aspect_ratio, 2.0))


def fin_strength(fin: Fin, *, density: float, body_factor: float) -> float:
    """Return G = rho a / 2, the side force of the fin per unit area, speed and cross velocity, kg/m3 /rad.

    The hull below acts as an end plate: the slope is that of `body_factor` times the panel's aspect ratio, between 1
    (free panel) and 2 (plane wall). DATCOM (Hoak, 1978), section 5.3.1.1.
    """
    return 0.5 * density * helmbold_slope(body_factor * fin.aspect_ratio)


def fin_coefficients(fin: Fin, *, density: float, body_factor: float) -> dict[str, float]:
    """Return the fin's side force and moments by sideslip (times V^2) and by the rates of turning (times V).

    Each strip meets the cross velocity at its three-quarter chord, v + (x - c/4) r - z p, and makes the force -G c dz V
    times that at its mid-chord; what shifts the whole to the quarter chord is the fin's own Munk moment, which its
    added mass brings. As the vertical tail of Etkin, Reid, 1996, Dynamics of Flight, sections 5.6 to 5.8; the point of
    the cross velocity by Pistolesi's theorem, Thwaites, 1960, Incompressible Aerodynamics.
    """
    G = fin_strength(fin, density=density, body_factor=body_factor)
    return {
        "Y_b": -G * fin.area,
        "K_b": G * fin.integral(lambda c, x, z: c * z),
        "N_b": -G * fin.integral(lambda c, x, z: c * x),
        "Y_p": G * fin.integral(lambda c, x, z: c * z),
        "Y_r": -G * fin.integral(lambda c, x, z: c * (x - c / 4.0)),
        "K_p": -G * fin.integral(lambda c, x, z: c * z * z),
        "K_r": G * fin.integral(lambda c, x, z: c * z * (x - c / 4.0)),
        "N_p": G * fin.integral(lambda c, x, z: c * z * x),
        "N_r": -G * fin.integral(lambda c, x, z: c * x * (x - c / 4.0)),
    }


def roll_damping_slope(ratio: float, chord: Callable[[Array], Array] = np.ones_like, *, terms: int = 60) -> float:
    """Return -C_lp of a straight wing by lifting-line theory, on p b / 2V; its sections have the slope 2 pi.

    `chord` gives the chord over its mean at a share of the half span (-1 to 1); by default the wing is a rectangle.
    The sum over even n of A_n sin(n t) (mu n + sin t) = mu alpha sin t, with mu = 2 pi c / 4 b and alpha = cos(t) here;
    C_l = pi A A_2 / 4 on area and span. Glauert, 1926, The Elements of Aerofoil and Airscrew Theory, chapter XI. An
    elliptic wing has (pi / 4) A / (A + 4); strip theory alone, 2 pi / 6 for a rectangle, is the limit of A to infinity.
    """
    n = 2.0 * np.arange(1, terms + 1)
    t = 0.5 * np.pi * (np.arange(1, terms + 1) - 0.5) / terms
    mu = 0.5 * np.pi / ratio * chord(np.cos(t))[:, None]
    system = np.sin(np.outer(t, n)) * (mu * n + np.sin(t)[:, None])
    coefficients = np.linalg.solve(system, mu[:, 0] * np.cos(t) * np.sin(t))
    return float(0.25 * math.pi * ratio * coefficients[0])


def wing_roll_damping(span: float, chord: float, *, density: float) -> float:
    """Return K_p (times V) of a rectangular wing: -C_lp rho S b^2 / 4. Etkin, Reid, 1996, section 5.7."""
    return -roll_damping_slope(span / chord) * density * span * chord * span**2 / 4.0


def wing_pitch_rate(span: float, chord: float, x: float, *, density: float) -> dict[str, float]:
    """Return Z_q, M_q (times V) of a rectangular wing with its mid-chord at x (m).

    It meets the cross velocity w - (x - c/4) q at its three-quarter chord, and makes the lift rho a S V / 2 times that
    at its mid-chord, as in `fin_coefficients`. Etkin, Reid, 1996, section 5.4; Thwaites, 1960.
    """
    strength = 0.5 * density * helmbold_slope(span / chord) * span * chord
    return {"Z_q": strength * (x - chord / 4.0), "M_q": -strength * x * (x - chord / 4.0)}


def wing_yaw_damping(span: float, chord: float, *, drag: float, density: float) -> float:
    """Return N_r (times V) of a rectangular wing by the drag of its strips at V - r y: -rho C_D c b^3 / 12.

    Etkin, Reid, 1996, section 5.8 (the wing's share), with the profile drag coefficient on the wing's area.
    """
    return -density * drag * chord * span**3 / 12.0


def hull_side(length: float, radius: float, nose: float, tail: float) -> tuple[float, float]:
    """Return area (m2) and first moment about mid-length (m3) of the silhouette of a hull with elliptic ends."""
    middle = length - nose - tail
    parts = (
        (2.0 * radius * middle, 0.5 * (tail - nose)),
        (0.5 * math.pi * radius * nose, 0.5 * length - nose + 4.0 * nose / (3.0 * math.pi)),
        (0.5 * math.pi * radius * tail, -0.5 * length + tail - 4.0 * tail / (3.0 * math.pi)),
    )
    return sum(area for area, _ in parts), sum(area * x for area, x in parts)


def crossflow(area: float, moment_x: float, moment_z: float, *, drag: float, density: float) -> dict[str, float]:
    """Return Y_bb, K_bb, N_bb (times V^2 sin(beta) |sin(beta)|) of a silhouette with first moments in x and z (m3).

    The cross-flow principle: each strip has the drag rho C_D v |v| / 2 of its area in the cross velocity alone.
    Hoerner, 1965, chapter III; Fossen, 2011, Handbook of Marine Craft Hydrodynamics and Motion Control, section 6.4.3.
    """
    strength = 0.5 * density * drag
    return {"Y_bb": -strength * area, "K_bb": strength * moment_z, "N_bb": -strength * moment_x}


def linearised(quadratic: float, rate: float) -> float:
    """Return the linear damping that takes the same work over a swing of amplitude `rate`: 8 rate quadratic / 3 pi.

    Equivalent linearisation: Faltinsen, 1990, Sea Loads on Ships and Offshore Structures.
    """
    return 8.0 * rate * quadratic / (3.0 * math.pi)


def strip_moment_damping(width: float, reach: tuple[float, float], *, drag: float, density: float) -> float:
    """Return the moment per squared rate of a strip of one width (m) turning about the origin, N m s2.

    rho C_D width / 2 times the integral of |s|^3 over its reach (m): the cross-flow principle, as in `crossflow`.
    """
    low, high = reach
    return 0.5 * density * drag * width * (high**3 * abs(high) - low**3 * abs(low)) / 4.0


def plate_factor(ratio: float) -> float:
    """Return the added mass of a rectangular plate over (pi/4) rho c^2 s, at a ratio c / s of its sides.

    Pabst's fit to measurements, (1 - 0.425 t / (1 + t^2)) / sqrt(1 + t^2); 1 for a long plate. Pabst, 1930, Theorie des
    Landestosses von Seeflugzeugen (NACA TM 580). It lies within 4 % of the table of DNV-RP-H103, 2011.
    """
    return (1.0 - 0.425 * ratio / (1.0 + ratio**2)) / math.hypot(1.0, ratio)


def fin_added_mass(fin: Fin, *, density: float) -> Array:
    """Return the fin's added mass about the body origin, (6, 6): sway, roll, yaw and what couples them.

    Strips of (pi/4) rho c^2 at their mid-chord, times the factor of a plate of twice the span (the hull below mirrors
    it), and pi rho c^4 / 128 for the turning of each strip about its own axis. Newman, 1977, Marine Hydrodynamics,
    Table 4.3; the strips as in Fossen, 2011, chapter 6.
    """
    whole = plate_factor(fin.area / fin.span / (2.0 * fin.span)) * 0.25 * math.pi * density
    return whole * _across(
        fin.integral(lambda c, x, z: c**2),
        fin.integral(lambda c, x, z: c**2 * x),
        fin.integral(lambda c, x, z: c**2 * z),
        fin.integral(lambda c, x, z: c**2 * (x**2 + c**2 / 32.0)),
        fin.integral(lambda c, x, z: c**2 * x * z),
        fin.integral(lambda c, x, z: c**2 * z**2),
    )


def _across(m: float, m_x: float, m_z: float, m_xx: float, m_xz: float, m_zz: float) -> Array:
    """Return the (6, 6) matrix of strips that resist only v + x r - z p, from the moments of their added mass."""
    A = np.zeros((6, 6))
    A[1, 1], A[3, 3], A[5, 5] = m, m_zz, m_xx
    A[1, 3] = A[3, 1] = -m_z
    A[1, 5] = A[5, 1] = m_x
    A[3, 5] = A[5, 3] = -m_xz
    return A


def bar_added_mass(bar: Bar, *, density: float) -> Array:
    """Return the added mass of a cylinder along x about the body origin, (6, 6): rho pi d^2 / 4 a length, both ways.

    Newman, 1977, Table 4.3, by strips; the hull beside it is left out, and so are its ends.
    """
    m = 0.25 * math.pi * density * bar.diameter**2 * bar.length
    x, z, own = bar.x, bar.z, bar.length**2 / 12.0
    A = m * _across(1.0, x, z, x * x + own, x * z, z * z)
    A[2, 2], A[4, 4] = m, m * (x * x + own)
    A[2, 4] = A[4, 2] = -m * x
    return A


def bar_forces(bar: Bar, alpha: Array, *, density: float) -> Array:
    """Return lift, drag and pitching moment over V^2 of the cylinder at angles of attack of 0 to 90 deg, (3, n).

    Along: the drag of a blunt cylinder; across: the cross-flow principle. The moment of the drag about the origin, even
    in alpha, is left out: the table holds odd moments only. The Munk moment of the
    tube is in, as it is in the stand-in's. Hoerner, 1965, chapter III.
    """
    along = 0.5 * density * BLUNT_CYLINDER * 0.25 * math.pi * bar.diameter**2 * np.cos(alpha) ** 2
    across = 0.5 * density * CYLINDER_CROSSFLOW * bar.diameter * bar.length * np.sin(alpha) ** 2
    lift = across * np.cos(alpha) - along * np.sin(alpha)
    drag = across * np.sin(alpha) + along * np.cos(alpha)
    munk = 0.25 * math.pi * density * bar.diameter**2 * bar.length * np.sin(alpha) * np.cos(alpha)
    return np.array([lift, drag, bar.x * across + munk])


def friction(reynolds: float) -> float:
    """Return the friction coefficient of a turbulent plate, 0.455 / log10(Re)^2.58 (Prandtl, Schlichting, 1932)."""
    return float(0.455 / math.log10(reynolds) ** 2.58)


def fin_drag(fin: Fin, *, speed: float, density: float, viscosity: float) -> float:
    """Return the fin's drag over V^2: friction on both sides times 1 + 2 t/c + 60 (t/c)^4. Hoerner, 1965, chap. VI."""
    mean = fin.area / fin.span
    t = fin.thickness / mean
    form = 1.0 + 2.0 * t + 60.0 * t**4
    return density * friction(speed * mean / viscosity) * form * fin.area


def munk_yaw_slope(added_mass: Array) -> float:
    """Return the destabilising yaw moment per V^2 and sideslip, -(A22 - A11). Munk, 1924, NACA Report 184."""
    return -float(added_mass[1, 1] - added_mass[0, 0])


def tube_bulk_modulus(radius: float, wall: float, *, young: float, poisson: float) -> float:
    """Return the stiffness of a closed thin tube against outer pressure: K = E t / (r (2.5 - 2 nu)), Pa.

    Hoop stress p r / t and axial stress p r / 2 t strain it by dV/V = 2 e_hoop + e_axial. Young, Budynas, 2002, Roark's
    Formulas for Stress and Strain, Table 13.1.
    """
    return young * wall / (radius * (2.5 - 2.0 * poisson))


def lateral_matrix(
    mass: Array, coefficients: dict[str, float], damping: Array, *, velocity: tuple[float, float], pitch: float,
    heaviness: float, arm: tuple[float, float],
) -> Array:  # fmt: skip
    """Return the matrix (4, 4) of the small motions v, p, r, roll about a straight glide: d/dt = matrix times them.

    `mass` (6, 6) is the rigid body's and the added mass together; `velocity` u and w (m/s); `heaviness` is weight less
    buoyancy (N), `arm` the x and z of weight times its place less buoyancy times its own (N m). Kirchhoff's equations,
    P' = -omega x P and L' = -omega x L - v x P + moments, made linear: Fossen, 2011, chapter 6. The Munk moment is in.
    """
    (u, w), speed = velocity, math.hypot(*velocity)
    P = mass @ np.array([u, 0.0, w, 0.0, 0.0, 0.0])
    odd = [1, 3, 5]
    inertia = mass[np.ix_(odd, odd)]
    sway = inertia[0]
    rows = [[coefficients.get(f"{force}_{by}", 0.0) * speed for by in "bpr"] for force in "YKN"]
    forces = np.array(rows) - damping[np.ix_(odd, odd)]
    forces += [
        [0.0, P[2], -P[0]],
        [-P[2] + w * sway[0], w * sway[1], P[4] + w * sway[2]],
        [P[0] - u * sway[0], -P[4] - u * sway[1], -u * sway[2]],
    ]
    by_roll = math.cos(pitch) * np.array([heaviness, -arm[1], arm[0]])
    return np.vstack([np.linalg.solve(inertia, np.column_stack([forces, by_roll])), [0.0, 1.0, math.tan(pitch), 0.0]])
