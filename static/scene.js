// What the 3D scene should show at one moment, as wanted properties of the scene's nodes. Knows no viewer.
// Frames: x forward, y to starboard, z down, theta nose-up; arrows point along their own +x with unit length.

import { angleAt, at, locate } from "./series.js";

const ARROW_LENGTH = 0.25; // metres, of the largest force in the run
const SHORTEST = 1e-4; // a zero scale would make the viewer's matrices singular

// Turns about +y; +x then points to (cos a, 0, -sin a).
const aboutY = (a) => [Math.cos(a / 2), 0, Math.sin(a / 2), 0];

export function largestForce(columns) {
  let largest = 0;
  for (const name of ["net_buoyancy", "lift", "drag"]) {
    for (const force of columns[name] ?? []) largest = Math.max(largest, Math.abs(force));
  }
  return largest;
}

// Unit directions in body axes. Up in the water is (0, 0, -1); the attitude's inverse turns it into the body.
export function forceDirections(theta, alpha) {
  return {
    buoyancy: [Math.sin(theta), -Math.cos(theta)],
    lift: [Math.sin(alpha), -Math.cos(alpha)],
    drag: [-Math.cos(alpha), -Math.sin(alpha)],
  };
}

function setArrow(wanted, name, force, [x, z], perNewton) {
  const sign = force < 0 ? -1 : 1;
  const length = Math.max(Math.abs(force) * perNewton, SHORTEST);
  // A small force keeps a thick shaft as long as its head still looks like one.
  const width = Math.min(ARROW_LENGTH, 2 * length);
  wanted.set(`/glider/arrow_${name}`, { wxyz: aboutY(Math.atan2(-z * sign, x * sign)), scale: [length, width, width] });
}

function setForces(wanted, columns, place, theta, largest) {
  const perNewton = largest > 0 ? ARROW_LENGTH / largest : 0;
  const directions = forceDirections(theta, angleAt(columns.alpha, place));
  setArrow(wanted, "buoyancy", at(columns.net_buoyancy, place), directions.buoyancy, perNewton);
  setArrow(wanted, "lift", at(columns.lift, place), directions.lift, perNewton);
  setArrow(wanted, "drag", at(columns.drag, place), directions.drag, perNewton);
}

function setCells(wanted, run, components, place, exaggeration) {
  for (const cell of run.cells) {
    const component = components[cell.component];
    if (!component?.drawn_length) continue;
    const growth = at(cell.extension, place) - component.extension_neutral;
    const stretch = Math.max(0.2, 1 + (exaggeration * growth) / component.drawn_length);
    wanted.set(`/glider/cell${cell.component}/stack`, { scale: [stretch, 1, 1] });
  }
}

// A movable mass slides along its axis from where it is at its neutral extension, by its true travel.
export function slidTo({ position, axis, extension_neutral: neutral }, extension) {
  const share = (extension - neutral) / Math.hypot(...axis);
  return position.map((p, k) => p + share * axis[k]);
}

function setMasses(wanted, run, components, place) {
  for (const cell of run.cells) {
    const component = components[cell.component];
    if (component?.kind !== "movable_mass" || !component.axis) continue;
    wanted.set(`/glider/part${cell.component}`, { position: slidTo(component, at(cell.extension, place)) });
  }
}

export function positionAt({ columns }, t) {
  const place = locate(columns.t, t);
  return [at(columns.x, place), 0, at(columns.z, place)];
}

// The anchor is the point of the water that the view shows at its origin.
export function sceneAt(state, t, { anchor, exaggeration, largest }) {
  const wanted = new Map();
  const { run, components } = state;
  const c = run.columns;
  const place = locate(c.t, t);
  const position = positionAt(run, t);
  const theta = angleAt(c.theta, place);
  wanted.set("/world", { position: anchor.map((p) => -p) });
  wanted.set("/glider", { position: position.map((p, k) => p - anchor[k]), wxyz: aboutY(theta) });
  setCells(wanted, run, components, place, exaggeration);
  setMasses(wanted, run, components, place);
  setForces(wanted, c, place, theta, largest);
  if (c.com_x) wanted.set("/glider/com", { position: [at(c.com_x, place), 0, at(c.com_z, place)] });
  if (c.cob_x) wanted.set("/glider/cob", { position: [at(c.cob_x, place), 0, at(c.cob_z, place)] });
  return wanted;
}

// Whether a node of this name is shown, or null where the page has no say.
export function visibility(name, { forces, centers, path }) {
  if (name === "/glider/arrow_weight") return false;
  if (/^\/glider\/arrow_(buoyancy|lift|drag)$/.test(name)) return forces;
  if (name === "/glider/com" || name === "/glider/cob") return centers;
  if (name.startsWith("/world/path") && !name.slice("/world/path".length).includes("/")) return path;
  return null;
}
