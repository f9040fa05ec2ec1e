// Schedule edits as JSON Patch operations on the design (RFC 6902). Pure functions, easy to test.

import { merged, pointsAt } from "./schedulecopy.js";

const ROOT = "/mission/control/schedules";
export const GAP = 0.01; // seconds between two points, so that their order never depends on rounding

const round = (value, per) => Math.round(value * per) / per;
export const clean = ({ time, extension, shape }) => ({ time: round(time, 1e4), extension: round(extension, 1e7), shape });
export const clamp = (value, low, high) => Math.min(Math.max(value, low ?? -Infinity), high ?? Infinity);

// `moves` is a Map of a schedule to a Map of index and new point: one patch for all of them.
export function movePatch(moves) {
  return [...moves].flatMap(([schedule, points]) =>
    [...points].map(([k, point]) => ({ op: "replace", path: `${ROOT}/${schedule.index}/points/${k}`, value: clean(point) })));
}

export function addPatch(schedule, point) {
  return pointsPatch(schedule, merged(schedule.points, [clean(point)], GAP));
}

// `removals` is a Map of a schedule to the indices that go. From the last to the first, so that indices stay true.
export function removePatch(removals) {
  const patch = [];
  for (const [schedule, indices] of [...removals].sort(([a], [b]) => b.index - a.index)) {
    // A schedule without points says nothing: it goes with its last point.
    if (indices.length >= schedule.points.length) patch.push({ op: "remove", path: `${ROOT}/${schedule.index}` });
    else for (const k of [...indices].sort((a, b) => b - a)) patch.push({ op: "remove", path: `${ROOT}/${schedule.index}/points/${k}` });
  }
  return patch;
}

// A schedule's points all anew, whether it had any or not.
export function pointsPatch(schedule, value) {
  if (schedule.index === null) return value.length ? [{ op: "add", path: `${ROOT}/-`, value: { cell: schedule.cell, points: value } }] : [];
  if (!value.length) return [{ op: "remove", path: `${ROOT}/${schedule.index}` }];
  return [{ op: "replace", path: `${ROOT}/${schedule.index}/points`, value }];
}

// How far the chosen points of a schedule may move in time without overtaking the others, or leaving the mission.
export function timeRoom(points, chosen, duration) {
  let [low, high] = [-Infinity, Infinity];
  for (const k of chosen) {
    const before = chosen.has(k - 1) ? -Infinity : k > 0 ? points[k - 1].time + GAP : 0;
    const after = chosen.has(k + 1) ? Infinity : k + 1 < points.length ? points[k + 1].time - GAP : Math.max(duration, points[k].time);
    low = Math.max(low, before - points[k].time);
    high = Math.min(high, after - points[k].time);
  }
  return [Math.min(low, 0), Math.max(high, 0)];
}

// Copied points laid at a time, in the limits of the cell that takes them; what is beyond the mission is left out.
export function pastePatch(schedule, copied, { at, component, duration }) {
  const put = pointsAt(copied, at).filter(({ time }) => time <= duration);
  const within = put.map((p) => clean({ ...p, extension: clamp(p.extension, component.extension_min, component.extension_max) }));
  return pointsPatch(schedule, merged(schedule.points, within, GAP));
}
