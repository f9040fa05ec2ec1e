// Which numbers of the run and of the design the right column shows, in which unit, and where each comes from.

import { clockText, compass, cubicCentimetres, degrees, fixed, grams, longerThan, scientific } from "./format.js";
import { angleAt, at, isMoving } from "./series.js";

const now = (key, read = at) => (run, place) => read(run.columns[key], place);
const ofFlow = (key, read = at) => (run, place) => (isMoving(at(run.columns.speed, place)) ? read(run.columns[key], place) : NaN);
const last = (key) => ({ run }) => run?.columns[key]?.at(-1);
export const metres = (v) => fixed(v, Math.abs(v) >= 1e4 ? 0 : 3);
const FULL = 2 * Math.PI;
const FARTHEST = 1e4; // metres: a wider circle is no turn that anyone could tell

// A small vehicle is told in grams, a big one in kilograms; likewise volumes and energies.
export const mass = (v) => (Math.abs(v) >= 10 ? [fixed(v, 3), "kg"] : [grams(v), "g"]);
export const volume = (v) => (Math.abs(v) >= 0.01 ? [fixed(v * 1e3, 3), "dm³"] : [cubicCentimetres(v), "cm³"]);
export const energy = (v, per = "") => (Math.abs(v) >= 1e4 ? [fixed(v / 1e3, 2), `kJ${per}`] : [fixed(v, Math.abs(v) < 100 ? 2 : 1), `J${per}`]);
// The last moment, as the axis tells moments.
const time = (v) => [clockText(v, Math.abs(v), { digits: 2, unit: false }), longerThan(Math.abs(v)).symbol];
export const radius = (v) => (Math.abs(v) > FARTHEST ? ["straight", ""] : [fixed(v, 2), "m"]);

// Joules mean little on their own: the residual counts against the energy that went back and forth.
function residual({ run }) {
  if (!run) return undefined;
  return run.energy_exchanged > 0 ? run.energy_residual / run.energy_exchanged : run.energy_residual;
}
// Where none did there is no share to tell.
const residualUnit = ({ run }) => (run && !(run.energy_exchanged > 0) ? "J" : undefined);

// [id, label, unit, how to write it (a text, or a text and its unit), where it comes from, only for this model, more]
export const NOW = [
  ["pitch", "Pitch", "°", degrees, now("theta", angleAt)],
  ["roll", "Roll", "°", degrees, now("phi", angleAt), "spatial"],
  ["heading", "Heading", "°", compass, (run, place) => ((at(run.columns.heading, place) % FULL) + FULL) % FULL, "spatial"],
  ["attack", "Attack angle", "°", degrees, ofFlow("alpha", angleAt)],
  ["sideslip", "Sideslip", "°", degrees, ofFlow("beta"), "spatial"],
  ["flow", "Flow angle", "°", degrees, ofFlow("flow_angle", angleAt)],
  ["speed", "Speed", "m/s", (v) => fixed(v, 3), now("speed")],
  ["depth", "Depth", "m", metres, now("z")],
  ["distance", "Distance", "m", metres, now("x"), "planar"],
  ["north", "North", "m", metres, now("x"), "spatial"],
  ["east", "East", "m", metres, now("y"), "spatial"],
  ["turn-rate", "Turn rate", "°/s", (v) => degrees(v, 3), now("turn_rate"), "spatial"],
  ["turn-radius", "Turn radius", "m", radius, now("turn_radius"), "spatial"],
  ["net-buoyancy", "Net buoyancy", "N", (v) => fixed(v, 4), now("net_buoyancy")],
  ["energy", "Energy used", "J", energy, now("battery_energy"), "spatial"],
];

export const END = [
  ["end-time", "Time", "s", time, last("t")],
  ["end-x", "Distance x", "m", metres, last("x"), "planar"],
  ["end-north", "North", "m", metres, last("x"), "spatial"],
  ["end-east", "East", "m", metres, last("y"), "spatial"],
  ["end-depth", "Depth", "m", metres, last("z")],
  ["end-travelled", "Over ground", "m", metres, last("travelled"), "spatial"],
  ["end-pitch", "Pitch", "°", degrees, last("theta")],
  ["end-roll", "Roll", "°", degrees, last("phi"), "spatial"],
  ["end-heading", "Turned", "°", degrees, ({ run }) => run && run.columns.heading?.at(-1) - run.columns.heading?.[0], "spatial"],
];

export const NUMERICS = [
  ["energy-residual", "Energy residual", "rel.", scientific, residual, undefined, { unitOf: residualUnit }],
  ["elapsed", "Computed in", "ms", (v) => fixed(v, 1), ({ run }) => run?.elapsed_ms],
];

// What the label is too short to say.
export const TITLES = {
  pitch: "Nose above the horizon; of the run at the clock",
  flow: "Direction of motion below the horizontal, positive down",
  attack: "Angle of the flow in the vehicle's plane of symmetry: atan2(w, u)",
  sideslip: "Angle of the flow out of the vehicle's plane of symmetry: positive where it comes from starboard",
  roll: "Positive with the starboard wing down",
  heading: "From north, to the right",
  speed: "Through the water; of the run at the clock",
  depth: "Of the body origin below the surface",
  distance: "Forward of the start",
  north: "Of the start, over ground",
  east: "Of the start, over ground",
  "net-buoyancy": "Buoyancy less weight, up positive; of the run at the clock, where the glider is",
  "turn-rate": "About the vertical, positive to starboard",
  "turn-radius": "Of the turn through the water",
  energy: "Taken from the battery since the start: actuators and hotel load",
  "end-time": "How long the run lasted",
  "end-travelled": "Length of the horizontal track over ground",
  "end-heading": "Change of heading since the start, full turns counted",
  "energy-residual": "The most that was left over in the energy balance, as a share of the energy exchanged during the glide; in J where none was exchanged",
  elapsed: "Time the last run took on the server",
};
