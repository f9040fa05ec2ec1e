// What rows of the left panel have in common: their frame, the column of units, and the place where a refusal is told.

import { el, setText } from "./dom.js";
import { inUnits } from "./fieldbounds.js";
import { chooseUnit, unitNow, unitsOf } from "./unitchoice.js";

let count = 0;

export const newId = () => `field-${(count += 1)}`;

// The unit in a column of its own; where there are several, a choice that all fields of the quantity follow.
export function unitNode({ quantity, unit, label }) {
  const units = unitsOf(quantity, unit);
  if (units.length < 2) return el("span", { class: "field-unit" }, units[0].symbol);
  // Out of the way of Tab, which goes from number to number: in a box Alt+U does the same.
  const choice = el("select", { class: "field-unit", "aria-label": `Unit of ${label}`, tabindex: "-1", title: "Unit (Alt+U in the box)" }, ...units.map(({ symbol }) => el("option", { value: symbol }, symbol || "1")));
  choice.value = unitNow(quantity, unit).symbol;
  choice.addEventListener("change", () => chooseUnit(quantity, choice.value));
  return choice;
}

export function reshowUnit(node, { quantity, unit }) {
  if (node.tagName === "SELECT") node.value = unitNow(quantity, unit).symbol;
}

export function problemNode() {
  const node = el("p", { class: "field-problem", role: "alert", "data-testid": "field-problem", hidden: true });
  const tell = (problem) => {
    node.hidden = !problem;
    const [error] = (problem?.errors ?? []).map(inUnits);
    // Below the edge of a short panel nobody would see it.
    if (problem) requestAnimationFrame(() => node.scrollIntoView({ block: "nearest" }));
    setText(node, problem ? [error?.message ?? problem.detail ?? problem.title, error?.hint].filter(Boolean).join(". ") : "");
  };
  return { node, tell };
}

export function frame(spec, name, ...children) {
  return el("div", { class: `part-field ${name}`, "data-pointer": spec.pointer ?? "", "data-testid": `field-${spec.key}` }, ...children);
}
