// The help beside a field: its sentence, symbol, limits and its value in SI, on hover and on focus.

import { el } from "./dom.js";
import { shown, unitNow } from "./unitchoice.js";

const PATIENCE = 450; // ms of a pointer at rest

let box = null;
let timer = null;

function made() {
  if (!box) {
    box = el("div", { id: "field-help", class: "field-help", role: "tooltip", "data-testid": "field-help", hidden: true });
    document.body.append(box);
  }
  return box;
}

const told = (value) => (typeof value === "number" ? String(Number(value.toPrecision(7))) : Array.isArray(value) && value.every((v) => typeof v === "number") ? `[${value.map(told).join(", ")}]` : null);

function limits({ low, high, aboveLow, quantity, unit }) {
  const { symbol } = unitNow(quantity, unit);
  const say = (value) => `${shown(value, unitNow(quantity, unit))} ${symbol}`.trim();
  const parts = [low != null && `${aboveLow ? "above" : "from"} ${say(low)}`, high != null && `up to ${say(high)}`].filter(Boolean);
  return parts.length ? parts.join(" ") : null;
}

function lines(spec) {
  const si = spec.unit && spec.unit !== "1" ? spec.unit : "";
  const value = told(spec.value);
  return [
    ["Symbol", spec.symbol || null],
    ["Limits", limits(spec)],
    ["Value", value === null ? null : `${value} ${si}`.trim()],
    ["In the file", spec.pointer || null],
  ].filter(([, text]) => text);
}

function show(spec, anchor) {
  const node = made();
  const { left, right, top } = anchor.getBoundingClientRect();
  node.replaceChildren(el("p", {}, spec.about), el("dl", {}, ...lines(spec).map(([name, text]) => el("div", {}, el("dt", {}, name), el("dd", {}, text)))));
  node.hidden = false;
  node.style.left = `${right + node.offsetWidth + 24 < innerWidth ? right + 18 : Math.max(left - node.offsetWidth - 12, 4)}px`;
  node.style.top = `${Math.max(Math.min(top - 4, innerHeight - node.offsetHeight - 8), 4)}px`;
}

export function hideHelp() {
  clearTimeout(timer);
  if (box) box.hidden = true;
}

// specOf answers the row's present spec; nothing is told of a row without a sentence.
export function helpOn(root, specOf) {
  const open = () => specOf().about && root.isConnected && show(specOf(), root);
  root.addEventListener("pointerenter", () => {
    clearTimeout(timer);
    timer = setTimeout(open, PATIENCE);
  });
  root.addEventListener("pointerleave", hideHelp);
  root.addEventListener("pointerdown", hideHelp);
  root.addEventListener("focusin", (event) => {
    if (!event.target.matches(":focus-visible")) return;
    open();
    event.target.setAttribute("aria-describedby", "field-help");
  });
  root.addEventListener("focusout", hideHelp);
  root.addEventListener("keydown", (event) => event.key === "Escape" && hideHelp());
}
