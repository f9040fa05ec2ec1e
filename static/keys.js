// The page's keys: who wants one registers it here, with its words, so that `?` lists them all.
//
//   onKey("Ctrl+Z", actions.undo, { words: "Undo", group: "Design" });
//   onKey(["ArrowLeft", "Shift+ArrowLeft"], (event) => step(event.shiftKey ? -10 : -1));
//   describeKey(["ArrowLeft", "Shift+drag"], "One step back", "Lanes");  // for keys, and clicks, that an element handles itself
//
// Ctrl stands for Cmd too. A handler that returns false has not taken the key.

import { $, el } from "./dom.js";

export const GROUPS = ["Playback", "Time shown", "Lanes", "Events", "Plots", "Design", "Parts", "Scene", "View", "Page"]; // in the order of the list

const described = [];
const handlers = [];
const WORDS = { " ": "Space", ArrowLeft: "←", ArrowRight: "→", ArrowUp: "↑", ArrowDown: "↓", Escape: "Esc" };

const listOf = (keys) => (Array.isArray(keys) ? keys : [keys]);

// Returns what takes it away again, for parts of the page that come and go.
export function describeKey(keys, words, group = "Page") {
  const entry = { keys: listOf(keys), words, group };
  described.push(entry);
  return () => described.splice(described.indexOf(entry), 1);
}

export function onKey(keys, handler, { words = "", group = "Page" } = {}) {
  const entry = { wanted: listOf(keys).map(parse), handler };
  handlers.push(entry);
  const forget = words ? describeKey(keys, words, group) : () => {};
  return () => {
    handlers.splice(handlers.indexOf(entry), 1);
    forget();
  };
}

function parse(text) {
  const parts = text === "+" ? ["+"] : text.split("+");
  const key = parts.at(-1) === "Space" ? " " : parts.at(-1);
  return { key, ctrl: parts.includes("Ctrl"), alt: parts.includes("Alt"), shift: parts.includes("Shift") };
}

// Shift is part of what makes a sign like `?`, and on which keyboards it is differs: it counts for letters and named keys.
function matches({ key, ctrl, alt, shift }, event) {
  const same = key.length === 1 ? event.key.toLowerCase() === key.toLowerCase() : event.key === key;
  const sign = key.length === 1 && key !== " " && key.toLowerCase() === key.toUpperCase();
  if (!same || (event.ctrlKey || event.metaKey) !== ctrl) return false;
  return sign || (event.altKey === alt && event.shiftKey === shift);
}

const isText = (target) => /^(TEXTAREA|SELECT)$/.test(target.tagName) || target.isContentEditable || (target.tagName === "INPUT" && !/^(range|checkbox|radio|button|file)$/.test(target.type));

// A box whose text is the document's has nothing of its own to undo: there the document's last edit is undone.
function undoesHere({ target, key }) {
  return /^[zy]$/i.test(key) && target.matches("#parts :is(.field-box, .field-text, select):not([data-draft], [aria-invalid])");
}

// What the element with the focus does with the key itself.
function takes(target, key) {
  if (!target?.tagName) return false;
  const role = target.getAttribute("role") ?? "";
  if (key === " " || key === "Enter") return /^(BUTTON|SUMMARY|A)$/.test(target.tagName) || /^(button|checkbox|radio|option|tab|menuitem|treeitem)/.test(role) || /^(checkbox|radio)$/.test(target.type);
  if (!/^(Arrow|Home|End|Page|Delete|Backspace)/.test(key)) return false;
  if (target.tagName === "INPUT") return key !== "Home" && key !== "End";
  return /^(slider|separator|tab|radio|option|menuitem|treeitem|grid|gridcell|application|spinbutton)/.test(role);
}

// Also called with the keys pressed inside the 3D view, which are events of another document.
export function pressKey(event) {
  if (event.defaultPrevented || document.querySelector("dialog[open]")) return;
  const { target } = event;
  const modified = event.ctrlKey || event.metaKey;
  const passes = modified && target?.tagName && (event.key.toLowerCase() === "s" || undoesHere(event));
  if (target?.tagName && (isText(target) || takes(target, event.key)) && !passes) return;
  if (passes && undoesHere(event)) event.preventDefault(); // the browser's own undo would write what nobody typed now
  for (const { wanted, handler } of [...handlers]) {
    if (!wanted.some((one) => matches(one, event)) || handler(event) === false) continue;
    event.preventDefault();
    return;
  }
}

const apple = /Mac|iPhone|iPad/.test(navigator.platform);

function keyNodes(keys) {
  return keys.flatMap((text, k) => {
    const { key, ctrl, alt, shift } = parse(text);
    const signs = [ctrl && (apple ? "⌘" : "Ctrl"), alt && "Alt", shift && "Shift", WORDS[key] ?? (key.length === 1 ? key.toUpperCase() : key)].filter(Boolean);
    return [k > 0 ? " / " : null, ...signs.flatMap((sign, n) => [n > 0 ? " + " : null, el("kbd", {}, sign)])];
  });
}

function groupNode(group) {
  const rows = described.filter((entry) => entry.group === group).map(({ keys, words }) => el("div", {}, el("dt", {}, ...keyNodes(keys)), el("dd", {}, words)));
  return el("section", {}, el("h3", {}, group), el("dl", {}, ...rows));
}

export function openKeys() {
  const dialog = $("keys") ?? makeDialog();
  const others = described.map(({ group }) => group).filter((group) => !GROUPS.includes(group));
  const groups = [...GROUPS, ...new Set(others)].filter((group) => described.some((entry) => entry.group === group));
  dialog.querySelector(".body").replaceChildren(...groups.map(groupNode));
  if (!dialog.open) dialog.showModal();
}

function makeDialog() {
  const close = el("button", { class: "btn small", type: "button", "data-testid": "keys-close" }, "Close");
  const dialog = el("dialog", { id: "keys", class: "dialog keys", "aria-labelledby": "keys-title", "data-testid": "keys" },
    el("header", {}, el("h2", { id: "keys-title" }, "Keys"), el("span", { class: "spring" }), close),
    // Its text is longer than a low window: reachable by keyboard, too.
    el("div", { class: "body", tabindex: "0", role: "group", "aria-label": "All keys" }));
  close.addEventListener("click", () => dialog.close());
  dialog.addEventListener("click", (event) => event.target === dialog && dialog.close());
  document.body.append(dialog);
  return dialog;
}

document.addEventListener("keydown", pressKey);
onKey("?", openKeys, { words: "This list", group: "Page" });
describeKey(["Tab", "Shift+Tab"], "To the next thing on the page, or the one before");
describeKey(["ArrowUp", "ArrowDown"], "In a menu: another entry");
describeKey("Escape", "Close a menu or dialog");
