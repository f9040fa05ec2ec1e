// Other extensions for one hold of the schedule, as JSON Patch operations. A pure function.

import { join } from "./fieldschema.js";
import { pointsPatch } from "./schedule.js";
import { commandAt } from "./schedulecopy.js";

const CLOSE = 1e-6; // s, within which two times are one
const SAME = 1e-9; // m or rad

// The points in the hold take the new extension, one is added where it begins; where it ends the old command goes on.
function heldPoints({ points, initial }, [from, to], extension, duration) {
  const old = commandAt(points, initial, from + CLOSE);
  const inside = ({ time }) => time >= from - CLOSE && time < to - CLOSE;
  const rampFrom = (point, k) => Math.abs(point.time - to) < CLOSE && Math.abs(point.extension - old) < SAME && (point.shape === "ramp" || points[k + 1]?.shape === "ramp");
  const moved = points.map((point, k) => (inside(point) || rampFrom(point, k) ? { ...point, extension } : point));
  const near = (t) => points.some(({ time }) => Math.abs(time - t) < CLOSE);
  const added = near(from) ? [] : [{ time: from, extension, shape: "step" }];
  if (!near(to) && to < duration - CLOSE) added.push({ time: to, extension: commandAt(points, initial, to), shape: "step" });
  return [...moved, ...added].sort((a, b) => a.time - b.time);
}

export function holdPatch({ schedules, duration }, span, extensions) {
  const whole = span[0] < CLOSE && span[1] > duration - CLOSE;
  return schedules.filter(({ cell }) => cell in extensions).flatMap((schedule) => {
    const { cell, points, initial } = schedule;
    const extension = extensions[cell];
    if (Math.abs(commandAt(points, initial, span[0] + CLOSE) - extension) < SAME) return [];
    // A cell that never moves needs no schedule to be elsewhere all along.
    if (!points.length && whole) return [{ op: "add", path: join("/mission/initial/extensions", cell), value: extension }];
    return pointsPatch(schedule, heldPoints(schedule, span, extension, duration));
  });
}
