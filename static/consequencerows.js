// Which consequences the right column shows: trims, balance, margins, energy; and how each is written.
// A row reads from {consequences, hold, t}: all of them, the hold in force at the clock, and the clock.

import { degrees, fixed, millimetres, toDegrees } from "./format.js";
import { energy, mass, metres, radius, volume } from "./readoutrows.js";
import { at, locate } from "./series.js";

const trim = (key) => ({ hold }) => hold?.trim?.[key];
const percent = (v, digits = 1) => fixed(100 * v, digits);
const newtons = (v) => fixed(v, Math.abs(v) >= 10 ? 2 : 4);

const NEUTRAL = 1e-7; // 1/s: slower, a disturbance neither dies out nor grows

// Where nothing disturbs it any more: 1/e of a disturbance is left after this long, or it has doubled.
// Time to 1/e of a trim's slowest small motion, s; undefined where it does not die out.
export const settlesIn = (trim) => (trim?.growth < -NEUTRAL ? -1 / trim.growth : undefined);
const settles = ({ hold }) => settlesIn(hold?.trim);
const doubles = ({ hold }) => (hold?.trim?.growth > NEUTRAL ? Math.LN2 / hold.trim.growth : undefined);
const seconds = (v) => fixed(v, v < 10 ? 2 : 1);

function margin(name) {
  return ({ consequences, t }) => {
    const { times, series } = consequences.margins ?? {};
    return series?.[name] ? at(series[name], locate(times, t)) : undefined;
  };
}

const worst = (name, show) => ({ consequences }) => {
  const found = consequences.margins?.worst[name];
  return found && { text: `least ${show(found.value)} at`, time: found.time, bad: found.value < 0 };
};

const spent = (read) => ({ consequences }) => (consequences.energy ? read(consequences.energy.whole) : undefined);

// Where a command moves the cells at time zero, the run begins with another buoyancy than they start with.
function commandedAtOnce({ state }) {
  const moved = state?.schedules.some(({ initial, points: [first] }) => first?.time === 0 && first.extension !== initial);
  const [start, begun] = [state?.mass.net_buoyancy, state?.run?.columns.net_buoyancy?.[0]];
  return moved && Math.abs(begun - start) > 1e-4 ? { text: `${newtons(begun)} N by the commands at 0 s` } : undefined;
}

const actuators = ({ parts }) => Object.values(parts).reduce((sum, joules) => sum + joules, 0);
const sideways = "spatial";

// [id, label, unit, how to write it, where it comes from, what it is, more: {model, note, differ}]
export const TRIM = [
  ["trim-pitch", "Pitch", "°", degrees, trim("pitch"), "Nose above the horizon in the steady glide that these extensions lead to"],
  ["trim-roll", "Roll", "°", degrees, trim("roll"), "Starboard wing down positive, in the steady glide", { model: sideways }],
  ["trim-glide-angle", "Glide angle", "°", degrees, trim("glide_angle"), "Of the path to the horizon, climb positive"],
  ["trim-attack", "Attack angle", "°", (v) => degrees(v, 2), trim("angle_of_attack"), "atan2(w, u) in the steady glide"],
  ["trim-speed", "Speed", "m/s", (v) => fixed(v, 3), trim("speed"), "Through the water in the steady glide"],
  ["trim-glide-ratio", "Glide ratio", "", (v) => fixed(v, 2), trim("glide_ratio"), "Horizontal way per change of depth"],
  ["trim-sink-rate", "Sink rate", "m/s", (v) => fixed(v, 4), trim("sink_rate"), "Vertical speed, down positive"],
  ["trim-turn-radius", "Turn radius", "m", radius, ({ hold }) => hold?.trim && (hold.trim.turn_radius ?? Infinity), "Over ground, to the right positive", { model: sideways, endless: true }],
  ["trim-settles", "Settles in", "s", seconds, settles, "Time to 1/e of the slowest small motion; see the modes. Depth and extensions are held", { optional: true }],
  ["trim-doubles", "Doubles in", "s", seconds, doubles, "Time in which the fastest growing small motion doubles; see the modes. Depth and extensions are held", { optional: true }],
];

export const BALANCE = [
  ["mass", "Mass", "g", mass, ({ consequences }) => consequences.mass, "All components, or as declared"],
  ["displaced-volume", "Displaced volume", "cm³", volume, ({ state }) => state?.mass.displaced_volume, "Of all components, cells as at the start", { own: true }],
  ["start-net-buoyancy", "Net buoyancy at start", "N", newtons, ({ state }) => state?.mass.net_buoyancy, "All cells at their extension at start, before any command moves them, in the density of the surface, fully immersed", { own: true, note: commandedAtOnce }],
  ["held-net-buoyancy", "Net buoyancy held", "N", newtons, ({ hold }) => hold?.reserve.now, "Buoyancy less weight with the cells as held, at the depth of the trim, nothing compressed"],
  ["reserve-up", "Cells can add", "N", newtons, ({ hold }) => hold && hold.reserve.most - hold.reserve.now, "Until every cell is as large as its stops allow",
    { note: ({ hold }) => hold && hold.reserve.most > hold.reserve.least && { text: `${percent(1 - hold.reserve.share, 0)} % of the stroke` } }],
  ["reserve-down", "Cells can shed", "N", newtons, ({ hold }) => hold && hold.reserve.now - hold.reserve.least, "Until every cell is as small as its stops allow",
    { note: ({ hold }) => hold && hold.reserve.most > hold.reserve.least && { text: `${percent(hold.reserve.share, 0)} % of the stroke` } }],
  ["com-below-cob", "CoM below CoB", "mm", millimetres, ({ hold }) => hold?.offset[2], "Body z of the centre of mass less that of buoyancy, cells as held: what rights the glider"],
  ["com-ahead-of-cob", "CoM ahead of CoB", "mm", millimetres, ({ hold }) => hold?.offset[0], "Body x of the centre of mass less that of buoyancy, cells as held: what sets the pitch"],
  ["com-starboard-of-cob", "CoM to starboard", "mm", millimetres, ({ hold }) => hold?.offset[1], "Body y of the centre of mass less that of buoyancy, cells as held: what banks the glider", { model: sideways }],
];

const length = ({ consequences }) => consequences.margins?.length;

export const MARGINS = [
  ["margin-pitch-stiffness", "Hydrostatic, pitch", "mm", millimetres, margin("pitch_stiffness"), "Righting moment per angle over the weight, about body y; at the clock, and the least of the run", { note: worst("pitch_stiffness", (v) => `${millimetres(v)} mm`), warn: true }],
  ["margin-roll-stiffness", "Hydrostatic, roll", "mm", millimetres, margin("roll_stiffness"), "Righting moment per angle over the weight, about body x; at the clock, and the least of the run", { model: sideways, note: worst("roll_stiffness", (v) => `${millimetres(v)} mm`), warn: true }],
  ["margin-pitch", "Hydrodynamic, pitch", "% L", (v) => percent(v, 2), margin("pitch_margin"), "Centre of mass ahead of the point where a change of lift acts, by the vehicle's length; below 0 the flow turns it over, and weight must right it", { note: worst("pitch_margin", (v) => `${percent(v, 2)} % L`), warn: true }],
  ["margin-yaw", "Hydrodynamic, yaw", "% L", (v) => percent(v, 2), margin("yaw_margin"), "Centre of mass ahead of the point where a change of side force acts, by the vehicle's length", { model: sideways, note: worst("yaw_margin", (v) => `${percent(v, 2)} % L`), warn: true }],
  ["margin-length", "Length L", "m", metres, length, "Of the vehicle along x: what the hydrodynamic margins count by"],
];

export const ENERGY = [
  ["energy-per-km", "Energy per km", "J/km", (v) => energy(v, "/km"), spent((whole) => whole.per_km ?? undefined), "Of the run's horizontal way over ground", { model: sideways }],
  ["energy-whole", "Whole run", "J", energy, spent((whole) => whole.total), "Taken from the battery: actuators and hotel load", { model: sideways }],
  ["energy-actuators", "Actuators", "J", energy, spent(actuators), "Work of the actuators over their efficiency", { model: sideways }],
  ["energy-hotel", "Hotel load", "J", energy, spent((whole) => whole.hotel), "Power of the electronics times time", { model: sideways }],
];

const SLOWEST = 1e-3; // m/s: slower, the flow has no direction and no forces

// Whether the flow at a moment is within what the force data hold: in words, and whether it is.
export function withinSource({ source }, run, place) {
  const moving = at(run.columns.speed, place);
  if (!(moving > SLOWEST)) return { inside: true, text: "at rest, no flow" };
  const beyond = (value, range, unit) => (range && (value < range[0] - 1e-9 || value > range[1] + 1e-9) ? `${fixed(value, 2)} ${unit}` : null);
  const off = [
    beyond(moving, source.speed, "m/s"),
    beyond(toDegrees(at(run.columns.alpha, place)), source.attack_deg, "° attack"),
    run.columns.beta ? beyond(toDegrees(at(run.columns.beta, place)), source.sideslip_deg, "° sideslip") : null,
  ].filter(Boolean);
  return off.length ? { inside: false, text: `outside: ${off.join(", ")}` } : { inside: true, text: "inside" };
}
