// What the time plots show: which columns, in which colour and unit, and which of them on an axis of its own at the right.

import { compass, degrees, fixed, toDegrees } from "./format.js";
import { angleAt, at } from "./series.js";
import { angleTicks, ticks } from "./timescale.js";

const depth = { key: "z", name: "depth", label: "Depth", unit: "m", width: 2, dash: [], convert: (v) => v, show: (v) => fixed(v, 3), read: at };

const angle = (key, label, width, dash, more = {}) => ({
  key, name: label.toLowerCase(), label, unit: "°", width, dash, convert: toDegrees, show: degrees, read: angleAt, wraps: true, ...more,
});

const pitch = angle("theta", "Pitch", 2, []);
const attack = angle("alpha", "Attack", 1.8, [2, 3]);

export const PLOTS = {
  depth: {
    down: true,
    ticks,
    planar: { title: "Depth (m)", series: [depth] },
    spatial: { title: "Depth (m)", series: [depth] },
  },
  angles: {
    ticks: angleTicks,
    planar: { title: "Pitch · flow · attack (°)", series: [pitch, angle("flow_angle", "Flow", 1.6, [7, 4]), attack] },
    // The heading goes round and round: without jumps it would dwarf the others, so it has the axis at the right;
    // its value is told as on the compass, as everywhere else.
    spatial: {
      title: "Angles (°), heading at right",
      series: [pitch, angle("phi", "Roll", 1.8, [7, 4]), attack, angle("heading", "Heading", 1.6, [], { read: at, wraps: false, right: true, show: compass })],
    },
  },
};
