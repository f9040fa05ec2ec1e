// Reading a run between its samples.

// Index i with t[i] <= time < t[i + 1], and the fraction between the two.
export function locate(t, time) {
  let low = 0;
  let high = t.length - 1;
  if (high < 1 || time <= t[0]) return { i: 0, f: 0 };
  if (time >= t[high]) return { i: high - 1, f: 1 };
  while (high - low > 1) {
    const middle = (low + high) >> 1;
    if (t[middle] <= time) low = middle;
    else high = middle;
  }
  return { i: low, f: (time - t[low]) / (t[high] - t[low]) };
}

// What is not a number (the radius of a straight way) comes as null, and must not count as 0.
export function at(values, { i, f }) {
  if (!values?.length) return NaN;
  const a = values[i];
  const b = values[Math.min(i + 1, values.length - 1)];
  return a === null || b === null ? NaN : a + (b - a) * f;
}

// An angle that jumps by a full turn between samples must not be averaged through zero.
export function angleAt(values, place) {
  if (!values?.length) return NaN;
  const a = values[place.i];
  const b = values[Math.min(place.i + 1, values.length - 1)];
  if (a === null || b === null) return NaN;
  if (Math.abs(b - a) > Math.PI) return place.f < 0.5 ? a : b;
  return a + (b - a) * place.f;
}

const STILL = 1e-4; // m/s: slower, the flow has no direction, only noise
export const isMoving = (speed) => speed > STILL;

// The angles of the flow, null where there is none.
export const ofFlow = (angles, speed) => angles.map((angle, k) => (isMoving(speed[k]) ? angle : null));

export function extent(values) {
  let low = Infinity;
  let high = -Infinity;
  for (const v of values) {
    if (v === null) continue;
    if (v < low) low = v;
    if (v > high) high = v;
  }
  return low <= high ? [low, high] : [0, 0];
}

// What the schedule asks for, as corner points: a step jumps at its time, a ramp arrives at it.
export function commandCorners(points, start, duration) {
  const corners = [[0, start]];
  let value = start;
  for (const { time, extension, shape } of points) {
    if (shape !== "ramp") corners.push([time, value]);
    corners.push([time, extension]);
    value = extension;
  }
  corners.push([Math.max(duration, points.at(-1)?.time ?? 0), value]);
  return corners;
}

// The stretches of time in which a condition holds; a lone sample reaches half-way to its neighbours.
export function stretches(t, values, holds) {
  const found = [];
  let start = null;
  for (let i = 0; i <= t.length; i += 1) {
    const inside = i < t.length && values[i] !== null && holds(values[i]);
    if (inside && start === null) start = i ? (t[i - 1] + t[i]) / 2 : t[0];
    if (!inside && start !== null) {
      found.push([start, i < t.length ? (t[i - 1] + t[i]) / 2 : t.at(-1)]);
      start = null;
    }
  }
  return found;
}

// The samples from the last one before a window to the first one behind it, as indices [first, last].
export function within(t, from, to) {
  const last = t.length - 1;
  if (last < 0 || t[0] > to || t[last] < from) return [0, -1];
  const { i } = locate(t, from);
  const { i: j } = locate(t, to);
  return [i, Math.min(j + 1, last)];
}

export function extentWithin(t, values, from, to) {
  const [first, last] = within(t, from, to);
  let [low, high] = [Infinity, -Infinity];
  for (let k = first; k <= last; k += 1) {
    const v = values[k];
    if (v === null) continue;
    if (v < low) low = v;
    if (v > high) high = v;
  }
  return low <= high ? [low, high] : null;
}
