"""Owns sine, cosine and arctangent without branches or library calls, so that loops over designs can vectorise.

Cephes Math Library (S. Moshier, 1984-2000) polynomials; errors below 2e-16 (`sincos`, |x| < 1e5) and 5e-16 (`atan2`).
"""

from __future__ import annotations

from models.kernel.jit import inlined

TINY = 1e-300


@inlined
def sincos(x):
    """Return sin(x), cos(x); x in rad, |x| < 1e5."""
    n = float(int(x * 0.6366197723675814 + (0.5 if x >= 0.0 else -0.5)))
    y = ((x - n * 1.57079632673412561417e0) - n * 6.07710050630396597660e-11) - n * 2.02226624879595063154e-21
    q = y * y
    s = 1.58962301576546568060e-10
    s = s * q - 2.50507477628578072866e-8
    s = s * q + 2.75573136213857245213e-6
    s = s * q - 1.98412698295895385996e-4
    s = s * q + 8.33333333332211858878e-3
    s = s * q - 1.66666666666666307295e-1
    s = y + y * q * s
    c = -1.13585365213876817300e-11
    c = c * q + 2.08757008419747316778e-9
    c = c * q - 2.75573141792967388112e-7
    c = c * q + 2.48015872888517045348e-5
    c = c * q - 1.38888888888730564116e-3
    c = c * q + 4.16666666666665929218e-2
    c = 1.0 - 0.5 * q + q * q * c
    quadrant = int(n) & 3
    odd = (quadrant & 1) == 1
    sine = c if odd else s
    cosine = s if odd else c
    return (-sine if quadrant >= 2 else sine), (-cosine if quadrant == 1 or quadrant == 2 else cosine)


@inlined
def atan2(y, x):
    """Return the angle of (x, y) in [-pi, pi], rad; 0 for the origin."""
    ay = abs(y)
    ax = abs(x)
    steep = ay > ax
    small = ax if steep else ay
    large = ay if steep else ax
    far = small > 0.41421356237309503 * large
    t = ((small - large) if far else small) / ((small + large if far else large) + TINY)
    q = t * t
    p = -8.750608600031904122785e-1
    p = p * q - 1.615753718733365076637e1
    p = p * q - 7.500855792314704667340e1
    p = p * q - 1.228866684490136173410e2
    p = p * q - 6.485021904942025371773e1
    d = q + 2.485846490142306297962e1
    d = d * q + 1.650270098316988542046e2
    d = d * q + 4.328810604912902668951e2
    d = d * q + 4.853903996359136964868e2
    d = d * q + 1.945506571482613964425e2
    angle = t + t * (q * p / d)
    angle = (0.7853981633974483 + angle) if far else angle
    angle = (1.5707963267948966 - angle) if steep else angle
    angle = (3.141592653589793 - angle) if x < 0.0 else angle
    return -angle if y < 0.0 else angle
