"""Owns small vector algebra on scalars: attitude, cross products, symmetric solves."""

from __future__ import annotations

from models.kernel.jit import internal


@internal
def rotation(q0, q1, q2, q3):
    """Return R (body to world) row by row, of a quaternion that need not have length 1."""
    s = 2.0 / (q0 * q0 + q1 * q1 + q2 * q2 + q3 * q3)
    x, y, z = s * q1, s * q2, s * q3
    return (
        1.0 - (q2 * y + q3 * z), q1 * y - q0 * z, q1 * z + q0 * y,
        q1 * y + q0 * z, 1.0 - (q1 * x + q3 * z), q2 * z - q0 * x,
        q1 * z - q0 * y, q2 * z + q0 * x, 1.0 - (q1 * x + q2 * y),
    )  # fmt: skip


@internal
def cross(ax, ay, az, bx, by, bz):
    """Return a x b."""
    return ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx


@internal
def times_symmetric(xx, yy, zz, xy, xz, yz, a, b, c):
    """Return a symmetric 3x3 matrix times (a, b, c)."""
    return xx * a + xy * b + xz * c, xy * a + yy * b + yz * c, xz * a + yz * b + zz * c


@internal
def inverse_symmetric(xx, yy, zz, xy, xz, yz):
    """Return the inverse of a symmetric positive definite 3x3 matrix, in the same order of entries."""
    cxx, cyy, czz = yy * zz - yz * yz, xx * zz - xz * xz, xx * yy - xy * xy
    cxy, cxz, cyz = xz * yz - xy * zz, xy * yz - xz * yy, xy * xz - xx * yz
    d = 1.0 / (xx * cxx + xy * cxy + xz * cxz)
    return d * cxx, d * cyy, d * czz, d * cxy, d * cxz, d * cyz
