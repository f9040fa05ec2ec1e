// Panels that float over the page beside what opened them; the browser closes them by Escape and a click elsewhere.

import { el } from "./dom.js";

const GAP = 4;
const EDGE = 8;

// `attributes` and `children` are the panel's; `onClose` is called however it goes. Returns the panel.
export function openFloating(anchor, attributes, children, { onClose } = {}) {
  const panel = el("div", { popover: "auto", ...attributes }, ...children);
  document.body.append(panel);
  panel.addEventListener("toggle", ({ newState }) => {
    if (newState !== "closed") return;
    const held = panel.contains(document.activeElement) || document.activeElement === document.body;
    panel.remove();
    if (held && anchor.isConnected) anchor.focus();
    onClose?.();
  });
  panel.showPopover();
  place(panel, anchor);
  return panel;
}

export function place(panel, anchor) {
  const at = anchor.getBoundingClientRect();
  const { offsetWidth: width, offsetHeight: height } = panel;
  const below = at.bottom + GAP;
  const top = below + height < innerHeight - EDGE ? below : at.top - GAP - height;
  panel.style.left = `${Math.max(EDGE, Math.min(at.left, innerWidth - width - EDGE))}px`;
  panel.style.top = `${Math.max(EDGE, Math.min(top, innerHeight - height - EDGE))}px`;
}

// `items` are [words, act, {disabled, keys, testid}] or null for a line between two groups.
export function openMenu(anchor, label, items) {
  const close = (act) => () => {
    panel.hidePopover();
    act();
  };
  const nodes = items.map((item) => {
    if (!item) return el("hr", {});
    const [words, act, { disabled = false, keys = "", testid } = {}] = item;
    return el("button", { type: "button", role: "menuitem", tabindex: -1, disabled, "data-testid": testid, onclick: close(act) }, el("span", {}, words), keys ? el("kbd", {}, keys) : null);
  });
  const panel = openFloating(anchor, { class: "floating menu-list", role: "menu", "aria-label": label }, nodes);
  const choices = () => [...panel.querySelectorAll("button:enabled")];
  panel.addEventListener("keydown", (event) => {
    const step = { ArrowDown: 1, ArrowUp: -1 }[event.key];
    event.stopPropagation();
    if (!step) return;
    event.preventDefault();
    const all = choices();
    all[(all.indexOf(document.activeElement) + step + all.length) % all.length]?.focus();
  });
  choices()[0]?.focus();
  return panel;
}
