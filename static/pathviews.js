// From where the path plot looks: which columns run across and along the page, and how the glider lies in it.

import { fixed, toDegrees } from "./format.js";
import { angleAt, at } from "./series.js";

const pitched = (columns, place) => -toDegrees(angleAt(columns.theta, place));

// `sign` -1 draws what grows upwards, as north does.
export const PATH_VIEWS = {
  planar: {
    title: "Path, side view", across: "x", along: "z", sign: 1, label: "x, forward (m)", turn: pitched,
    tip: (x, z) => `x ${fixed(x, 3)} m · depth ${fixed(z, 3)} m`,
  },
  side: {
    title: "Path, side view", across: "travelled", along: "z", sign: 1, label: "track over ground (m)", turn: pitched,
    tip: (s, z) => `track ${fixed(s, 2)} m · depth ${fixed(z, 2)} m`,
  },
  plan: {
    title: "Path, north up", across: "y", along: "x", sign: -1, label: "east (m)",
    turn: (columns, place) => toDegrees(at(columns.heading, place)) - 90,
    tip: (east, north) => `north ${fixed(north, 2)} m · east ${fixed(east, 2)} m`,
  },
};
