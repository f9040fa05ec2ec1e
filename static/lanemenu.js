// What can be done with a lane's schedule as a whole, and with the points chosen in it.

import { openMenu } from "./floating.js";

export function openLaneMenu(set, lane) {
  const { cell, points } = lane.schedule;
  const chosen = set.selection.of(cell).size;
  const [held, none] = [lane.fixed, !points.length];
  const about = chosen > 1 ? `the ${chosen} points` : "the point";
  return openMenu(lane.menu, `Schedule of ${cell}`, [
    ["Copy schedule to…", () => set.copier.open(lane), { disabled: none || lane.schedule.controlled, testid: "copy-schedule" }],
    ["Shift or stretch…", () => set.copier.open(lane, { to: cell }), { disabled: none || held, testid: "shift-schedule" }],
    ["Choose all points", () => set.chooseAll(lane), { disabled: none, keys: "Ctrl A", testid: "choose-all" }],
    ["Add a point at the clock", () => set.addAtClock(lane), { disabled: held, testid: "add-at-clock" }],
    null,
    [`Copy ${about}`, () => set.copy(), { disabled: !chosen, keys: "Ctrl C", testid: "copy-points" }],
    ["Paste at the clock", () => set.paste(), { disabled: held || !set.clip, keys: "Ctrl V", testid: "paste-points" }],
    [chosen > 1 ? `Make ${about} steps` : "Make it a step", () => set.toggleShape("step"), { disabled: held || !chosen, keys: "R", testid: "make-steps" }],
    [chosen > 1 ? `Make ${about} ramps` : "Make it a ramp", () => set.toggleShape("ramp"), { disabled: held || !chosen, keys: "R", testid: "make-ramps" }],
    [`Delete ${about}`, () => set.remove(), { disabled: held || !chosen, keys: "Del", testid: "delete-points" }],
  ]);
}
