// Schedule edits as JSON Patch operations on the design (RFC 6902). Pure functions, easy to test.

const ROOT = "/mission/control/schedules";
const GAP = 0.01; // seconds between two points, so that their order never depends on rounding

const clean = ({ time, extension, shape }) => ({ time: round(time, 1e4), extension: round(extension, 1e7), shape });
const round = (value, per) => Math.round(value * per) / per;

export function movePatch(schedule, k, point) {
  return [{ op: "replace", path: `${ROOT}/${schedule.index}/points/${k}`, value: clean(point) }];
}

export function addPatch(schedule, point) {
  const value = clean(point);
  if (schedule.index === null) return [{ op: "add", path: `${ROOT}/-`, value: { cell: schedule.cell, points: [value] } }];
  return [{ op: "add", path: `${ROOT}/${schedule.index}/points/${insertionIndex(schedule.points, value.time)}`, value }];
}

export function removePatch(schedule, k) {
  // A schedule without points says nothing: it goes with its last point.
  if (schedule.points.length === 1) return [{ op: "remove", path: `${ROOT}/${schedule.index}` }];
  return [{ op: "remove", path: `${ROOT}/${schedule.index}/points/${k}` }];
}

export function insertionIndex(points, time) {
  const later = points.findIndex((p) => p.time > time);
  return later < 0 ? points.length : later;
}

// Times a point may take without overtaking its neighbours.
export function timeRange(points, k, duration) {
  const low = k > 0 ? points[k - 1].time + GAP : 0;
  const high = k + 1 < points.length ? points[k + 1].time - GAP : duration;
  return [low, Math.max(low, high)];
}

export const clamp = (value, low, high) => Math.min(Math.max(value, low ?? -Infinity), high ?? Infinity);
