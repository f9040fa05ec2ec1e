// A small menu at a button or under the pointer: arrows, letters, Enter and Escape; the focus goes back where it was.

import { el } from "./dom.js";

let open = null;

export function closeMenu(giveFocusBack = false) {
  if (!open) return;
  const { root, back, anchor } = open;
  open = null;
  root.remove();
  anchor?.setAttribute("aria-expanded", "false");
  if (giveFocusBack) back?.focus?.();
}

// items: {label, icon, keys, about, checked, disabled, run}, or null for a line between.
export function openMenu(at, items, { label, anchor = null } = {}) {
  if (open?.anchor && open.anchor === anchor) return closeMenu(true);
  closeMenu();
  const root = el("div", { class: "parts-menu", role: "menu", "aria-label": label, "data-testid": "parts-menu" }, ...items.map(itemNode));
  document.body.append(root);
  open = { root, anchor, back: anchor ?? document.activeElement };
  anchor?.setAttribute("aria-expanded", "true");
  root.style.left = `${Math.max(Math.min(at.x, innerWidth - root.offsetWidth - 8), 8)}px`;
  root.style.top = `${Math.max(Math.min(at.y, innerHeight - root.offsetHeight - 8), 8)}px`;
  root.addEventListener("keydown", key);
  root.querySelector("button:not(:disabled)")?.focus();
  return root;
}

function itemNode(item) {
  if (!item) return el("div", { role: "separator" });
  const { label, icon, keys, about, checked, disabled, run } = item;
  const words = el("span", { class: "menu-words" }, el("span", {}, label), about ? el("small", {}, about) : null);
  return el("button", {
    type: "button", role: checked === undefined ? "menuitem" : "menuitemcheckbox", "aria-checked": checked === undefined ? null : String(checked), disabled, tabindex: "-1", "aria-label": label,
    onclick: () => {
      closeMenu(true);
      run();
    },
  }, icon, words, keys ? el("kbd", {}, keys) : null);
}

function key(event) {
  const buttons = [...open.root.querySelectorAll("button:not(:disabled)")];
  const k = buttons.indexOf(document.activeElement);
  const to = { ArrowDown: k + 1, ArrowUp: k - 1, Home: 0, End: buttons.length - 1 }[event.key];
  if (to !== undefined) buttons.at(to % buttons.length).focus();
  else if (event.key === "Escape" || event.key === "Tab") closeMenu(true);
  else if (event.key.length === 1 && event.key !== " ") buttons.find(({ textContent }) => textContent.trim().toLowerCase().startsWith(event.key.toLowerCase()))?.focus();
  else return;
  event.preventDefault();
  event.stopPropagation();
}

document.addEventListener("pointerdown", (event) => open && !open.root.contains(event.target) && !open.anchor?.contains(event.target) && closeMenu());
window.addEventListener("blur", () => closeMenu());
