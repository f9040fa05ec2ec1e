// How an output looks in a plot: its short name, colour, dash, unit and digits; known ones as everywhere on the page.

import { compass, fixed, toDegrees } from "./format.js";
import { angleAt, at } from "./series.js";

const DEGREES = { per: toDegrees(1), symbol: "°", show: (v) => fixed(toDegrees(v), 1) };
const angle = (id, label, dash, more = {}) => ({ id, label, color: `--${id}`, dash, width: dash.length ? 1.8 : 2, scale: DEGREES, wraps: true, ...more });

const KNOWN = {
  z: { id: "depth", label: "Depth", color: "--depth", dash: [], width: 2, scale: { per: 1, symbol: "m", show: (v) => fixed(v, 3) }, down: true },
  theta: angle("pitch", "Pitch", []),
  phi: angle("roll", "Roll", [7, 4]),
  alpha: angle("attack", "Attack", [2, 3]),
  flow_angle: angle("flow", "Flow", [7, 4]),
  // It goes round and round: without jumps it would dwarf the others, so it has an axis of its own; its value is told
  // as on the compass, as everywhere else.
  heading: angle("heading", "Heading", [], { axis: "heading", wraps: false, scale: { ...DEGREES, show: compass } }),
};

const COLORS = ["--series-1", "--series-2", "--series-3", "--series-4", "--series-5", "--series-6"];
const DASHES = [[], [7, 4], [2, 3], [10, 3, 2, 3], [14, 5], [7, 3, 2, 3, 2, 3], [4, 2], [1, 5]]; // as many as a plot has outputs
const SHORT = {
  x: "North", y: "East", beta: "Sideslip", psi: "Yaw", q: "Pitch rate", p: "Roll rate", r: "Yaw rate", u: "Surge", v: "Sway", w: "Heave",
  net_buoyancy: "Net buoyancy", travelled: "Over ground", turn_rate: "Turn rate", turn_radius: "Turn radius",
};

export function shortName(name) {
  const [variable, cell] = name.split("@");
  const words = KNOWN[variable]?.label ?? SHORT[variable] ?? variable.replaceAll("_", " ");
  const text = words[0].toUpperCase() + words.slice(1);
  return cell ? `${cell}: ${text.toLowerCase()}` : text;
}

export const axisOf = (name, unit) => KNOWN[name]?.axis ?? unit;

// `place` is the output's place in its plot, `cellColors` the palette of the components.
export function seriesOf(name, unit, { place, cellColors }) {
  const cell = name.split("@")[1];
  const own = { id: name, label: shortName(name), color: COLORS[place % COLORS.length], dash: DASHES[Math.floor(place / COLORS.length) % DASHES.length], width: 1.8, wraps: unit === "rad" && !cell };
  const color = cellColors.get(cell);
  const look = { ...own, ...(color && { color, dash: DASHES[place % DASHES.length] }), ...KNOWN[name] };
  return { ...look, name, unit, axis: axisOf(name, unit), read: look.wraps ? angleAt : at };
}

// Where runs lie over each other the colour says which run, the present one too, and the dash which output: the one it
// has anyway unless another has it already.
export function runsByColor(series) {
  if (!series.some(({ kept }) => kept.length)) return series;
  const taken = new Set();
  return series.map((each) => {
    const dash = [each.dash, ...DASHES].find((one) => !taken.has(String(one))) ?? each.dash;
    taken.add(String(dash));
    return { ...each, dash, color: "--present" };
  });
}
