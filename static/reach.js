// How near each cell comes to its stops in the run: the share of the stroke left, and when it is least.

import { $, el, setText, swatch } from "./dom.js";
import { clockText, fixed } from "./format.js";
import { openGroup } from "./groups.js";

function row(cell, color, end, seek) {
  const { near } = cell;
  const words = cell.at ? `at its ${cell.side} stop` : `${fixed(100 * cell.nearest, 1)} % of the stroke from its ${cell.side} stop`;
  const time = el("button", { class: "time-link", type: "button", title: "Go there", onclick: () => seek(cell.time) }, clockText(cell.time, end));
  return el("div", { class: near ? "low" : "", title: `${cell.name} comes within ${fixed(100 * cell.nearest, 2)} % of its stroke of its ${cell.side} stop`, "data-testid": `reach-${cell.name}` },
    el("dt", {}, swatch(color), cell.name), el("dd", {}, el("span", { class: "value" }, fixed(100 * cell.nearest, 1)), el("span", { class: "unit" }, "%")),
    el("dd", { class: near ? "note low" : "note" }, `${words}, `, time));
}

export function showReach(consequences, state, seek) {
  const cells = consequences?.cells ?? [];
  const colors = new Map(state.components.map(({ name, color }) => [name, color]));
  const end = state.run?.columns.t.at(-1) ?? 0;
  $("reach-group").hidden = cells.length === 0;
  const near = cells.filter((cell) => cell.near).length;
  if (near) openGroup($("reach-group"));
  if (consequences) $("reach-group").firstElementChild.title = `How near each cell comes to its stops in the run; within ${fixed(100 * consequences.near_stop, 0)} % of its stroke is near`;
  setText($("reach-title"), near ? `Stops, ${near} near` : "Stops");
  $("reach").replaceChildren(...cells.map((cell) => row(cell, colors.get(cell.name) ?? "transparent", end, seek)));
}
