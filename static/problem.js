// Shows a problem+json object readably: what was wrong, the limit, and the way out.

import { el } from "./dom.js";
import { inUnits } from "./fieldbounds.js";
import { trueMinus } from "./format.js";

const SCALES = [1, 1e3, 180 / Math.PI]; // limits are in SI; messages also speak of millimetres and degrees

// A bound that the message gives, with its unit, is not said again without one.
function says(message, limit) {
  if (typeof limit !== "number") return message.includes(limit);
  const numbers = (message.replaceAll("\u2212", "-").match(/-?\d+(\.\d+)?(e[-+]?\d+)?/gi) ?? []).map(Number);
  return SCALES.some((scale) => numbers.some((n) => Math.abs(n - limit * scale) <= 1e-5 * Math.abs(limit * scale)));
}

function errorItem(error, link) {
  const item = el("li", {}, el("p", {}, trueMinus(error.message) ?? "Not accepted."));
  if (error.limit != null && error.limit !== "" && !says(error.message ?? "", error.limit)) item.append(el("p", {}, `Limit: ${trueMinus(String(error.limit))}`));
  if (error.hint) item.append(el("p", {}, trueMinus(error.hint)));
  const where = error.pointer && (link ? link(error.pointer) : el("span", { class: "where" }, error.pointer));
  if (where) item.append(where);
  return item;
}

export function problemNodes(problem, { note, link } = {}) {
  const nodes = [el("p", {}, el("strong", {}, problem.title ?? "This did not work"))];
  const errors = problem.errors ?? [];
  const said = problem.detail === problem.title || errors.some((e) => e.message === problem.detail || (errors.length === 1 && problem.detail?.includes(e.message)));
  if (problem.detail && !said) nodes.push(el("p", {}, trueMinus(problem.detail)));
  if (errors.length) nodes.push(el("ul", {}, ...errors.map((e) => errorItem(inUnits(e), link))));
  if (note) nodes.push(el("p", { class: "kept" }, note));
  return nodes;
}
