// What the 3D scene should show at one moment, as wanted properties of the scene's nodes. Knows no viewer.
// Frames: x north or forward, y east or starboard, z down; arrows point along their own +x with unit length.

import { LEVEL, about, between, inverse, rotate, times, xAxisTo } from "./attitude.js";
import { angleAt, at, extent, locate } from "./series.js";

const ARROW_SHARE = 0.42; // of the vehicle's length, for the largest force in the run
const SMALLEST_STRETCH = 0.2;
const SHORTEST = 1e-4; // a zero scale would make the viewer's matrices singular
const UP = [0, 0, -1];
const MOMENT_SHARE = 0.17; // of the vehicle's length, for the radius of the largest moment's arrow
const FORCES = { buoyancy: "net_buoyancy", lift: "lift", drag: "drag", side: "side_force" }; // arrow: column

// Moments of the water about the body's axes, each positive in a right-handed turn: column and axis.
export const MOMENTS = { roll: ["hydro_K", [1, 0, 0]], pitch: ["moment", [0, 1, 0]], yaw: ["hydro_N", [0, 0, 1]] };

function largestOf(columns, names) {
  let largest = 0;
  for (const name of names) {
    for (const value of columns[name] ?? []) largest = Math.max(largest, Math.abs(value));
  }
  return largest;
}

export const largestForce = (columns) => largestOf(columns, Object.values(FORCES));
export const largestMoment = (columns) => largestOf(columns, Object.values(MOMENTS).map(([column]) => column));

// Body to world. A planar run has no quaternion: it only pitches.
export function attitudeAt({ columns }, place) {
  if (!columns.q0) return about([0, 1, 0], angleAt(columns.theta, place));
  const sample = (i) => [columns.q0[i], columns.q1[i], columns.q2[i], columns.q3[i]];
  return between(sample(place.i), sample(Math.min(place.i + 1, columns.q0.length - 1)), place.f);
}

// Unit directions in body axes: up in the water, and the flow frame's axes at the angle of attack and sideslip.
export function forceDirections(attitude, alpha, beta) {
  const [ca, sa, cb, sb] = [Math.cos(alpha), Math.sin(alpha), Math.cos(beta), Math.sin(beta)];
  return {
    buoyancy: rotate(inverse(attitude), UP),
    lift: [sa, 0, -ca],
    drag: [-ca * cb, -sb, -sa * cb],
    side: [-ca * sb, cb, -sa * sb],
  };
}

function setArrow(wanted, name, force, direction, longest, largest) {
  const length = Math.max(largest > 0 ? (longest * Math.abs(force)) / largest : 0, SHORTEST);
  // A small force keeps a thick shaft as long as its head still looks like one.
  const width = Math.min(longest, 2 * length);
  const wxyz = xAxisTo(force < 0 ? direction.map((c) => -c) : direction);
  wanted.set(`/glider/arrow_${name}`, { wxyz, scale: [length, width, width] });
}

function setForces(wanted, columns, place, attitude, longest, largest) {
  const beta = columns.beta ? at(columns.beta, place) : 0;
  const directions = forceDirections(attitude, angleAt(columns.alpha, place), beta);
  for (const [name, key] of Object.entries(FORCES)) {
    if (columns[key]) setArrow(wanted, name, at(columns[key], place), directions[name], longest, largest);
  }
}

function setMoments(wanted, columns, place, longest, largest) {
  for (const [name, [column, axis]] of Object.entries(MOMENTS)) {
    if (!columns[column]) continue;
    const moment = at(columns[column], place);
    const size = Math.max(largest > 0 ? (longest * Math.abs(moment)) / largest : 0, SHORTEST);
    const wxyz = xAxisTo(moment < 0 ? axis.map((c) => -c) : axis);
    wanted.set(`/glider/moment_${name}`, { wxyz, scale: [size, size, size] });
  }
}

// How much larger a cell is drawn along and across its axis. The sides of a bellows' pleats keep their length, so that
// they flatten as it stretches; a bladder swells all round; what slides only gets longer.
export function breath({ kind, drawn_length: length, pleat }, growth) {
  const stretch = Math.max(1 + growth / length, SMALLEST_STRETCH);
  if (kind === "bladder") return Array(3).fill(Math.cbrt(stretch));
  if (!pleat) return [stretch, 1, 1];
  const [half, depth, radius] = pleat;
  const left = Math.sqrt(Math.max(half ** 2 * (1 - stretch ** 2) + depth ** 2, 0));
  const wide = Math.min((radius - depth + left) / radius, 1 + (0.5 * depth) / radius);
  return [stretch, wide, wide];
}

function setCells(wanted, run, components, place, exaggeration) {
  for (const cell of run.cells) {
    const component = components[cell.component];
    if (!component?.drawn_length) continue;
    const growth = at(cell.extension, place) - component.extension_neutral;
    wanted.set(`/glider/cell${cell.component}/stack`, { scale: breath(component, exaggeration * growth) });
  }
}

// Where a mass that moves is, from where it is at its neutral extension: it slides along its axis by its true travel,
// or turns about the axis through its pivot.
export function movedTo({ position, axis, pivot, extension_neutral: neutral }, extension) {
  const travel = extension - neutral;
  if (!pivot) return { position: position.map((p, k) => p + (travel / Math.hypot(...axis)) * axis[k]), wxyz: LEVEL };
  const wxyz = about(axis, travel);
  const arm = rotate(wxyz, position.map((p, k) => p - pivot[k]));
  return { position: arm.map((p, k) => p + pivot[k]), wxyz };
}

function setMasses(wanted, run, components, place) {
  for (const cell of run.cells) {
    const component = components[cell.component];
    if (component?.cell !== false || !component.axis) continue;
    wanted.set(`/glider/part${cell.component}`, movedTo(component, at(cell.extension, place)));
  }
}

// From the centre of buoyancy to that of mass, in body axes.
export function centerOffset(columns, place) {
  const center = (name) => ["x", "y", "z"].map((axis) => (columns[`${name}_${axis}`] ? at(columns[`${name}_${axis}`], place) : 0));
  const [mass, buoyancy] = [center("com"), center("cob")];
  return { buoyancy, offset: mass.map((c, k) => c - buoyancy[k]) };
}

// The centre of mass is drawn so many times as far from that of buoyancy, at the end of a line.
function setCenters(wanted, columns, place, times) {
  if (!columns.com_x) return;
  const { buoyancy, offset } = centerOffset(columns, place);
  wanted.set("/glider/cob", { position: buoyancy });
  wanted.set("/glider/com", { position: buoyancy.map((c, k) => c + times * offset[k]) });
  const line = { wxyz: xAxisTo(offset), scale: [Math.max(times * Math.hypot(...offset), SHORTEST), 1, 1] };
  for (const side of ["port", "starboard"]) wanted.set(`/glider/cob/offset_${side}`, line);
}

export function positionAt({ columns }, t) {
  const place = locate(columns.t, t);
  return [at(columns.x, place), columns.y ? at(columns.y, place) : 0, at(columns.z, place)];
}

// Another run's glider at the same time of its own; at its end it stays.
function setGhost(wanted, columns, t, seen, turn) {
  const run = { columns };
  const attitude = attitudeAt(run, locate(columns.t, t));
  wanted.set("/ghost", { position: seen(positionAt(run, t)), wxyz: times(turn, attitude) });
}

// The middle of the path and the diagonal of the box around it.
export function pathBox({ columns: { x, y, z } }) {
  const spans = [x, y ?? [0], z].map(extent);
  return { middle: spans.map(([a, b]) => (a + b) / 2), size: Math.hypot(...spans.map(([a, b]) => b - a)) };
}

// The anchor is the point of the water that the view shows at its origin. Where the view turns with the glider, the
// water turns the other way about that point, so that the camera need not move.
export function sceneAt(state, t, { anchor, exaggeration, largest, largestTurn = 0, offset = 1, turning, beacon, ghost }) {
  const wanted = new Map();
  const { run, components } = state;
  const place = locate(run.columns.t, t);
  const attitude = attitudeAt(run, place);
  const turn = turning && run.columns.heading ? about([0, 0, 1], -at(run.columns.heading, place)) : LEVEL;
  const seen = (point) => rotate(turn, point.map((p, k) => p - anchor[k]));
  wanted.set("/world", { position: seen([0, 0, 0]), wxyz: turn });
  wanted.set("/glider", { position: seen(positionAt(run, t)), wxyz: times(turn, attitude) });
  setCells(wanted, run, components, place, exaggeration);
  setMasses(wanted, run, components, place);
  setForces(wanted, run.columns, place, attitude, ARROW_SHARE * state.length, largest);
  setMoments(wanted, run.columns, place, MOMENT_SHARE * state.length, largestTurn);
  setCenters(wanted, run.columns, place, offset);
  if (ghost) setGhost(wanted, ghost, t, seen, turn);
  if (beacon) wanted.set("/glider/beacon", { scale: [beacon, beacon, beacon] });
  return wanted;
}

const SIGHT = 12; // metres through lake water: a bed further down would look as if it were near

// Whether the bed can be seen from where the glider is.
export function bedInSight(state, t) {
  if (!state?.run) return true;
  return state.bed_depth - positionAt(state.run, t)[2] < SIGHT;
}

// Whether a node of this name is shown, or null where the page has no say.
export function visibility(name, { forces, moments = false, centers, path, spatial, camera, bed, ghost = null }) {
  if (name === "/world/bed") return bed || camera === "overview"; // from afar it is seen how far down it is
  if (name === "/glider/beacon") return camera === "overview";
  // From afar the labels beside the path would hide it.
  if (name === "/world/rungs" || name === "/world/surface_grid") return camera !== "overview";
  // From above, depths beside a plane on its edge would lie over each other; from afar a room has place for its own.
  if (name.startsWith("/world/grid/") && (camera === "overview" || camera === "top")) return false;
  if (name.startsWith("/world/room/") && camera === "overview") return true;
  if (name === "/glider/arrow_side") return forces && spatial;
  if (/^\/glider\/arrow_(buoyancy|lift|drag)$/.test(name)) return forces;
  if (name === "/glider/moment_pitch") return moments;
  if (name.startsWith("/glider/moment_")) return moments && spatial;
  if (name === "/glider/com" || name.startsWith("/glider/cob")) return centers;
  if (name === "/ghost" || name === "/world/ghost_path") return ghost !== null;
  if (name.startsWith("/world/path") && !name.slice("/world/path".length).includes("/")) return path;
  return null;
}
