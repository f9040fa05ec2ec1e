// What a schedule becomes in another cell or at another time: mirrored, shifted, stretched. Pure functions.

// The command at a time: steps jump at theirs, ramps arrive at theirs.
export function commandAt(points, start, t) {
  let before = { time: 0, extension: start };
  for (const point of points) {
    if (point.time > t) {
      if (point.shape !== "ramp") return before.extension;
      return before.extension + ((point.extension - before.extension) * (t - before.time)) / (point.time - before.time);
    }
    before = point;
  }
  return before.extension;
}

// New points among old ones; where two would meet, the new one stays.
export function merged(points, added, gap) {
  const kept = points.filter((p) => !added.some((a) => Math.abs(a.time - p.time) < gap));
  return [...kept, ...added].sort((a, b) => a.time - b.time);
}

export const pointsAt = (points, at) => points.map((p) => ({ ...p, time: p.time - points[0].time + at }));

export const MIRRORS = {
  same: (e) => e,
  change: (e, from, to) => to + (e - from),
  mirrored: (e, from, to) => to - (e - from),
};

// Extensions for another cell, by its neutral one; `cut` counts what its stops did not allow.
export function converted(points, how, { source, target }) {
  let cut = 0;
  const made = points.map((point) => {
    const wanted = MIRRORS[how](point.extension, source.extension_neutral, target.extension_neutral);
    const extension = Math.min(Math.max(wanted, target.extension_min), target.extension_max);
    if (Math.abs(extension - wanted) > 1e-9) cut += 1;
    return { ...point, extension };
  });
  return { points: made, cut };
}

export const stretched = (points, factor) => points.map((p) => ({ ...p, time: p.time * factor }));

// The command as a whole later by `by` seconds (earlier where negative). Wrapped, what leaves at one end of the mission
// comes in at the other; else it holds its first value before, and what leaves is gone.
export function shifted(points, by, { start, duration, wrap, gap }) {
  if (!points.length || !by) return points;
  return wrap ? wrapped(points, by, { start, duration, gap }) : moved(points, by, { start, duration, gap });
}

function moved(points, by, { start, duration, gap }) {
  const later = points.map((p) => ({ ...p, time: p.time + by }));
  const inside = later.filter((p) => p.time >= 0 && p.time <= duration);
  const after = later.find((p) => p.time > duration);
  const edges = [];
  if (by < 0) edges.push({ time: 0, extension: commandAt(points, start, -by), shape: "step" });
  // A ramp that begins at the start of the mission would begin earlier, and be another ramp.
  else if (points[0].shape === "ramp") edges.push({ time: by, extension: start, shape: "step" });
  if (after?.shape === "ramp") edges.push({ time: duration, extension: commandAt(points, start, duration - by), shape: "ramp" });
  return merged(edges, inside, gap);
}

function wrapped(points, by, { start, duration, gap }) {
  const shift = ((by % duration) + duration) % duration;
  if (!shift) return points;
  const cut = duration - shift; // the moment that becomes the start
  const head = points.filter((p) => p.time <= cut).map((p) => ({ ...p, time: p.time + shift }));
  const tail = points.filter((p) => p.time > cut && p.time <= duration).map((p) => ({ ...p, time: p.time - cut }));
  const edges = [{ time: 0, extension: commandAt(points, start, cut), shape: "step" }];
  const [crossing] = points.filter((p) => p.time > cut);
  if (crossing?.shape === "ramp") edges.push({ time: duration, extension: commandAt(points, start, cut), shape: "ramp" });
  edges.push({ time: shift, extension: commandAt(points, start, 0), shape: "step" });
  return merged(edges, [...tail, ...head], gap);
}
