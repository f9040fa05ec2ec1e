"""Owns sine, cosine and arctangent without branches or library calls, so that loops over designs can vectorise.

Polynomials: Cephes Math Library (S. Moshier, 1984-2000) for sine and cosine, fdlibm (Sun Microsystems, 1993) for the
arctangent; errors below 2e-16 (`sincos`, |x| < 1e5) and 5e-16 (`atan2`).
"""

from __future__ import annotations

from models.kernel.choice import real, select, whole
from models.kernel.jit import inlined

TINY = 1e-300


@inlined
def sincos(x):
    """Return sin(x), cos(x); x in rad, |x| < 1e5."""
    n = real(whole(x * 0.6366197723675814 + select(x >= 0.0, 0.5, -0.5)))
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
    quadrant = whole(n) & 3
    odd = (quadrant & 1) == 1
    sine = select(odd, c, s)
    cosine = select(odd, s, c)
    return select(quadrant >= 2, -sine, sine), select((quadrant == 1) | (quadrant == 2), -cosine, cosine)


@inlined
def atan2(y, x):
    """Return the angle of (x, y) in [-pi, pi], rad; 0 for the origin."""
    ay = abs(y)
    ax = abs(x)
    steep = ay > ax
    small = select(steep, ax, ay)
    large = select(steep, ay, ax)
    far = small > 0.41421356237309503 * large
    t = select(far, small - large, small) / max(select(far, small + large, large), TINY)
    q = t * t
    r = q * q
    r2 = r * r
    odd = 3.33333333333329318027e-1 + r * 1.42857142725034663711e-1
    odd += r2 * (9.09088713343650656196e-2 + r * 6.66107313738753120669e-2)
    odd += r2 * r2 * (4.97687799461593236017e-2 + r * 1.62858201153657823623e-2)
    even = -1.99999999998764832476e-1 - r * 1.11111104054623557880e-1
    even -= r2 * (7.69187620504482999495e-2 + r * 5.83357013379057348645e-2)
    even -= r2 * r2 * 3.65315727442169155270e-2
    angle = t - t * (q * odd + r * even)
    angle = select(far, 0.7853981633974483 + angle, angle)
    angle = select(steep, 1.5707963267948966 - angle, angle)
    angle = select(x < 0.0, 3.141592653589793 - angle, angle)
    return select(y < 0.0, -angle, angle)
