// How far the run can be trusted: its error, found by flying the mission once more and more carefully, and its forces.

import { call } from "./api.js";
import { $, el, setText } from "./dom.js";
import { clockText, degrees, scientific } from "./format.js";
import { problemNodes } from "./problem.js";

const NAMES = { x: "Position x", y: "Position y", z: "Depth", theta: "Pitch", phi: "Roll", speed: "Speed" };

const written = ({ unit, largest }) => (unit === "rad" ? [scientific(Math.abs(Number((largest * 180) / Math.PI))), "°"] : [scientific(Math.abs(largest)), unit]);

function rows({ differences }, end) {
  return differences.map((one) => {
    const [text, unit] = written(one);
    return el("div", { title: `Largest difference between the two runs; ${unit === "°" ? `${degrees(one.end, 6)}°` : `${scientific(one.end)} ${unit}`} at the end` },
      el("dt", {}, NAMES[one.name] ?? one.name), el("dd", {}, el("span", { class: "value", "data-testid": `error-${one.name}`, "data-value": String(Math.abs(one.largest)) }, text), el("span", { class: "unit" }, unit)),
      el("dd", { class: "note" }, `at ${clockText(one.time, end)}`));
  });
}

export function connectNumerics({ store, showForces }) {
  let number = null; // of the run that the estimate shown is about

  function clear() {
    $("errors").replaceChildren();
    $("error-problem").hidden = true;
    setText($("error-text"), "");
  }

  async function estimate() {
    const button = $("estimate");
    const run = store.get("state")?.run;
    button.disabled = true;
    clear();
    try {
      const found = await call("GET", "error-estimate");
      number = run?.number;
      setText($("error-text"), `Largest differences to the same mission flown with ${found.with}; its energy residual is ${scientific(found.finer_residual)} of the energy exchanged.`);
      $("errors").replaceChildren(...rows(found, found.end));
    } catch (error) {
      $("error-problem").hidden = false;
      $("error-problem").replaceChildren(...problemNodes(error.problem ?? { title: error.message }));
    } finally {
      button.disabled = !store.get("state")?.run;
    }
  }

  $("estimate").addEventListener("click", estimate);
  $("source-open").addEventListener("click", showForces);
  store.watch(["state", "consequences"], ({ state, consequences }) => {
    $("estimate").disabled = !state?.run;
    if (number !== null && state?.run?.number !== number) {
      number = null;
      clear();
    }
    if (consequences) setText($("source-open"), consequences.source.title);
    setText($("source-range"), state?.hydrodynamics_range ?? "");
  });
}
