// Unit quaternions (w, x, y, z), body to world, in the physics' own axes: x north or forward, y east or starboard, z down.

export const LEVEL = [1, 0, 0, 0];

export const about = ([x, y, z], angle) => {
  const share = Math.sin(angle / 2) / (Math.hypot(x, y, z) || 1);
  return [Math.cos(angle / 2), share * x, share * y, share * z];
};

// First b, then a.
export const times = ([aw, ax, ay, az], [bw, bx, by, bz]) => [
  aw * bw - ax * bx - ay * by - az * bz,
  aw * bx + ax * bw + ay * bz - az * by,
  aw * by - ax * bz + ay * bw + az * bx,
  aw * bz + ax * by - ay * bx + az * bw,
];

export const inverse = ([w, x, y, z]) => [w, -x, -y, -z];

const cross = ([a, b, c], [d, e, f]) => [b * f - c * e, c * d - a * f, a * e - b * d];

export function rotate([w, ...u], v) {
  const once = cross(u, v);
  const twice = cross(u, once.map((c, k) => c + w * v[k]));
  return v.map((c, k) => c + 2 * twice[k]);
}

// Linear between two samples and made of length 1 again; of q and -q, one attitude, the nearer one.
export function between(a, b, share) {
  const sign = a.reduce((sum, c, k) => sum + c * b[k], 0) < 0 ? -1 : 1;
  const q = a.map((c, k) => c + (sign * b[k] - c) * share);
  const length = Math.hypot(...q);
  return length > 1e-9 ? q.map((c) => c / length) : a;
}

// The shortest turn that takes +x to a direction.
export function xAxisTo(direction) {
  const length = Math.hypot(...direction);
  if (length < 1e-12) return LEVEL;
  const [x, y, z] = direction.map((c) => c / length);
  if (x < -1 + 1e-9) return [0, 0, 1, 0];
  const q = [1 + x, 0, -z, y];
  const size = Math.hypot(...q);
  return q.map((c) => c / size);
}
