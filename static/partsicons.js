// The icons of the list of parts: one for each kind, and those of its buttons. Drawn in the text's colour.

import { svg } from "./dom.js";

const KINDS = {
  hull: "M1.5 8c2-4 11-4 13 0-2 4-11 4-13 0z",
  rigid: "M2.5 5.5 8 2.5l5.5 3v5L8 13.5l-5.5-3zM2.5 5.5 8 8.5l5.5-3M8 8.5v5",
  wing: "M1.5 10.5 6 5.5h4l4.5 5zM8 5.5v5",
  fin: "M3 13h10L10.5 3.5 7.5 3.5z",
  bellows: "M3 4v8M13 4v8M3 5l1.7-1.5 1.6 9 1.7-9 1.7 9 1.6-9L13 5",
  piston: "M2 5h8v6H2zM6.5 5v6M6.5 8H14M14 6v4",
  bladder: "M8 2.5c3 2.5 4.5 4.8 4.5 7a4.5 4.5 0 0 1-9 0c0-2.2 1.5-4.5 4.5-7z",
  movable_mass: "M5.5 5.5h5v5h-5zM1 8h4.5M10.5 8H15M2.7 6.3 1 8l1.7 1.7M13.3 6.3 15 8l-1.7 1.7",
  rolling_mass: "M12.5 5A5.3 5.3 0 1 0 13.3 8M13 2v3.2H9.8M8 8.5v3",
  ballast: "M5.5 5.5h5l2 8h-9zM8 5.5a1.6 1.6 0 1 0-.1 0",
  core_sampler: "M2 6h9v4H2zM11 6l3.5 2-3.5 2M5 6v4M8 6v4",
};

const SIGNS = {
  add: "M8 3v10M3 8h10",
  copy: "M5.5 5.5h8v8h-8zM10.5 5.5v-3h-8v8h3",
  mirror: "M8 1.5v13M5.5 4.5v7L1.5 11.5zM10.5 4.5v7l4 0z",
  up: "M8 13V3.5M4 7l4-4 4 4",
  down: "M8 3v9.5M4 9l4 4 4-4",
  remove: "M3 4.5h10M6.5 4.5v-2h3v2M4.5 4.5l.7 9h5.6l.7-9M6.8 7v4M9.2 7v4",
  lock: "M3.5 7.5h9v6h-9zM5.5 7.5v-2a2.5 2.5 0 0 1 5 0v2",
  unlock: "M3.5 7.5h9v6h-9zM5.5 7.5v-2a2.5 2.5 0 0 1 4.8-.9",
  shown: "M1.5 8c3-5.3 10-5.3 13 0-3 5.3-10 5.3-13 0zM8 10a2 2 0 1 0-.1-4 2 2 0 0 0 .1 4z",
  hidden: "M2.5 2.5l11 11M6 3.9c3.3-.9 6.6.6 8.5 4.1a9 9 0 0 1-1.9 2.4M10 12c-3.3.9-6.6-.6-8.5-4a9 9 0 0 1 1.9-2.4",
  rename: "M2.5 13.5l.8-3L10.5 3.3l2.2 2.2-7.2 7.2z",
  more: "M3.5 8h.1M8 8h.1M12.4 8h.1",
  linked: "M2 8h12M5 5 2 8l3 3M11 5l3 3-3 3",
};

const drawn = (path) => svg("svg", { viewBox: "0 0 16 16", "aria-hidden": "true", class: "part-icon" }, svg("path", { d: path }));

export const kindIcon = (kind) => drawn(KINDS[kind] ?? KINDS.rigid);
export const sign = (name) => drawn(SIGNS[name]);

// A rigid part is told by the first shape it is drawn with.
export function iconOf({ kind, shape }) {
  if (kind !== "rigid") return kind;
  return { hull: "hull", wing: "wing", fin: "fin" }[shape] ?? "rigid";
}
