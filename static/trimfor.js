// What it would take: the extensions that give a wanted glide angle, or what keeps the cells from it and the nearest glide.

import { call } from "./api.js";
import { $, el } from "./dom.js";
import { degrees, extensionScale, fixed, trueMinus } from "./format.js";
import { heldAt, spanText } from "./held.js";
import { holdPatch } from "./holdpatch.js";
import { problemNodes } from "./problem.js";

const STEEPEST = 90; // degrees

const glide = (trim) => `${degrees(trim.glide_angle)}° at ${fixed(trim.speed, 3)} m/s, pitch ${degrees(trim.pitch)}°, ${trim.stable ? "stable" : "unstable"}`;

function extensionRows(extensions, components) {
  const units = new Map(components.map(({ name, unit }) => [name, unit]));
  return el("dl", { class: "readouts" }, ...Object.entries(extensions).map(([name, e]) => {
    const { symbol, per, digits } = extensionScale(units.get(name));
    return el("div", {}, el("dt", {}, name), el("dd", {}, el("span", { class: "value" }, fixed(e * per, digits)), el("span", { class: "unit" }, symbol)));
  }));
}

function found(trim, components) {
  return [el("p", { class: "sentence", "data-testid": "trim-for-found" }, `Glides ${glide(trim)}, with the cells at:`), extensionRows(trim.extensions, components)];
}

function failed({ message, nearest, active }, components) {
  const why = trueMinus(message.split("; ")[0]);
  const stops = active.map(({ cell, stop, extension }) => {
    const { symbol, per, digits } = extensionScale(components.find(({ name }) => name === cell)?.unit);
    return el("li", {}, `${cell} is at its ${stop} stop, ${fixed(extension * per, digits)} ${symbol}`);
  });
  return [el("div", { class: "box", "data-testid": "trim-for-failed", title: message },
    el("p", {}, el("strong", {}, "Out of reach"), `: ${why}.`),
    stops.length ? el("ul", {}, ...stops) : null,
    nearest ? el("p", {}, `Nearest: ${glide(nearest)}.`) : null), ...(nearest ? [extensionRows(nearest.extensions, components)] : [])];
}

export function connectTrimFor({ store, clock, actions }) {
  const [form, field, answer] = [$("trim-for"), $("trim-for-angle"), $("trim-for-answer")];

  // Into the schedule's hold in force at the clock, as one change; a controller would not keep to it.
  function applyButton({ extensions }) {
    const held = heldAt(store.get("consequences"), clock.t);
    if (!held || held.hold.about) return [];
    const place = spanText(held.span, clock.end);
    const apply = () => actions.edit(holdPatch(store.get("state"), held.span, extensions));
    return [el("button", { class: "btn small", type: "button", title: `Holds the cells so from ${place}; can be undone`, "data-testid": "trim-for-apply", onclick: apply }, `Apply to ${place}`)];
  }

  // The answer may be longer than what is left of the column below its question.
  function show(...nodes) {
    answer.replaceChildren(...nodes);
    answer.scrollIntoView({ block: "nearest" });
  }

  async function ask() {
    const components = store.get("state")?.components ?? [];
    const angle = Number(field.value.trim().replace("\u2212", "-").replace(",", "."));
    const good = field.value.trim() !== "" && Number.isFinite(angle) && Math.abs(angle) <= STEEPEST;
    field.setAttribute("aria-invalid", String(!good));
    if (!good) {
      show(el("p", { class: "box bad" }, `A glide angle is a number from \u2212${STEEPEST} to ${STEEPEST} degrees; climbs are positive.`));
      return;
    }
    try {
      const { trims, failure } = await call("POST", "trim-for", { targets: { glide_angle: (angle * Math.PI) / 180 } });
      show(...(failure ? failed(failure, components) : [...found(trims[0], components), ...applyButton(trims[0])]));
    } catch (error) {
      show(el("div", { class: "box bad" }, ...problemNodes(error.problem ?? { title: error.message })));
    }
  }

  let asked = null; // the run whose answer is shown
  form.addEventListener("submit", (event) => {
    event.preventDefault();
    asked = store.get("consequences")?.run ?? null;
    ask();
  });
  store.watch(["consequences"], ({ consequences }) => {
    if (asked === null || consequences?.run === asked) return;
    asked = null;
    answer.replaceChildren(); // it was about another design
  });
}
