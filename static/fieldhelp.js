// The help beside a field: its sentence, symbol, limits and its value in SI as it is now. It opens on hover, on F1, and
// where the focus rests; beside the panel over the 3D view, so that it covers neither fields nor the timeline.

import { $, el } from "./dom.js";
import { trueMinus } from "./format.js";
import { shown, typed, unitNow } from "./unitchoice.js";

const PATIENCE = 450; // ms of a pointer at rest
const PAUSE = 1500; // ms without a key in a box
const GAP = 8;
const MANY = 1e6; // of the unit of the box: so far away a limit is said in SI

let box = null;
let timer = null;
let told = null; // the row that the help is about: {spec(), root}

function made() {
  if (!box) {
    box = el("div", { id: "field-help", class: "field-help", role: "tooltip", "data-testid": "field-help", hidden: true });
    document.body.append(box);
  }
  return box;
}

const figures = (value) => (typeof value === "number" ? trueMinus(String(Number(value.toPrecision(7)))) : Array.isArray(value) && value.every((v) => typeof v === "number") ? `[${value.map(figures).join(", ")}]` : null);

function limits({ low, high, aboveLow, quantity, unit }) {
  const { symbol, per } = unitNow(quantity, unit);
  const say = (value) => (Math.abs(value * per) < MANY ? `${shown(value, unitNow(quantity, unit))} ${symbol}` : `${figures(value)} ${unit}`).trim();
  const parts = [low != null && `${aboveLow ? "above" : "from"} ${say(low)}`, high != null && `up to ${say(high)}`].filter(Boolean);
  return parts.length ? parts.join(" ") : null;
}

// What stands in the boxes, where it is not the document's yet; what is no number has no value.
function valueNow(spec, root) {
  const { quantity, unit, value, row } = spec;
  const standing = (input, given) => (input?.matches("[data-draft], [aria-invalid]") ? typed(input.value, quantity, unit) : given);
  if (row === "number") return standing(root.querySelector(".field-box"), value);
  if (row === "vector" && Array.isArray(value)) return value.map((given, k) => standing(root.querySelectorAll(".field-box")[k], given));
  return value;
}

function lines(spec, root) {
  const si = spec.unit && spec.unit !== "1" ? spec.unit : "";
  const value = figures(valueNow(spec, root));
  return [
    ["Symbol", spec.symbol || null],
    ["Limits", limits(spec)],
    ["In SI now", value === null ? null : `${value} ${si}`.trim()],
    ["In the file", spec.pointer || null],
  ].filter(([, text]) => text);
}

function write() {
  const spec = told.spec();
  box.replaceChildren(el("p", {}, spec.about), el("dl", {}, ...lines(spec, told.root).map(([name, text]) => el("div", {}, el("dt", {}, name), el("dd", {}, text)))));
}

function show(spec, root) {
  const node = made();
  told = { spec, root };
  timer = null;
  write();
  node.hidden = false;
  const scene = document.querySelector("main.scene").getBoundingClientRect();
  node.style.maxHeight = `${scene.height - 2 * GAP}px`;
  node.style.left = `${Math.max(Math.min($("parts").getBoundingClientRect().right + GAP, innerWidth - node.offsetWidth - GAP), GAP)}px`;
  node.style.top = `${Math.max(Math.min(root.getBoundingClientRect().top - 4, scene.bottom - node.offsetHeight - GAP), scene.top + GAP)}px`;
}

export function hideHelp() {
  clearTimeout(timer);
  timer = told = null;
  if (box) box.hidden = true;
}

// After the values or the units changed.
export function refreshHelp() {
  if (told && !told.root.isConnected) hideHelp();
  else if (told) write();
}

// specOf answers the row's present spec; nothing is told of a row without a sentence.
export function helpOn(root, specOf) {
  const open = () => specOf().about && root.isConnected && show(specOf, root);
  const openAfter = (wait) => {
    clearTimeout(timer);
    timer = setTimeout(open, wait);
  };
  root.addEventListener("pointerenter", () => openAfter(PATIENCE));
  root.addEventListener("pointerleave", hideHelp);
  root.addEventListener("pointerdown", hideHelp);
  root.addEventListener("focusin", (event) => {
    if (!event.target.matches(":focus-visible")) return;
    openAfter(PAUSE);
    event.target.setAttribute("aria-describedby", "field-help");
  });
  root.addEventListener("focusout", hideHelp);
  root.addEventListener("input", refreshHelp);
  root.addEventListener("keydown", (event) => key(event, open, openAfter), true); // before the box takes Escape
}

function key(event, open, openAfter) {
  if (event.key === "Escape" || event.key === "Enter") hideHelp(); // what follows is to be looked at
  else if (event.key === "F1") {
    event.preventDefault();
    hideHelp();
    open();
  } else if (timer !== null) openAfter(PAUSE);
}
