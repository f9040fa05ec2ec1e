// A table of readouts: label, number, unit, and what changed; numbers that an edit changed light up for a moment.

import { el, setText } from "./dom.js";
import { NONE, clockText } from "./format.js";

const FLASH = { duration: 900, easing: "ease-out" };
const calm = matchMedia("(prefers-reduced-motion: reduce)");

// [id, label, unit, show, read, title, more]
export function fillTable(table, rows, { onTime = null } = {}) {
  return rows.map(([id, label, unit, show, read, title, more = {}]) => {
    const node = el("span", { class: "value", id: `readout-${id}`, "data-testid": `readout-${id}` }, NONE);
    const unitNode = el("span", { class: "unit" }, unit);
    const change = el("span", { class: "change", "data-testid": `change-${id}` });
    const note = more.note ? el("dd", { class: "note", "data-testid": `note-${id}` }) : null;
    const root = el("div", { title }, el("dt", {}, label), el("dd", {}, change, node, unitNode), note);
    table.append(root);
    return { id, unit, show, read, ...more, root, node, unitNode, change, noteNode: note, readNote: more.note, onTime };
  });
}

const isKnown = (value) => value != null && (Number.isFinite(value) || value === Infinity);

// `own` is a unit that this value alone has.
export function write(item, value, { flash = false, own } = {}) {
  const known = isKnown(value) && (item.endless || Number.isFinite(value));
  const [text, unit] = [known ? item.show(value) : NONE].flat();
  const changed = item.node.textContent !== text;
  setText(item.node, text);
  setText(item.unitNode, unit ?? own ?? item.unit);
  // The plain SI number beside the rounded text, for scripts that read the page.
  if (known) item.node.dataset.value = String(value);
  else delete item.node.dataset.value;
  if (item.warn) item.root.classList.toggle("low", known && value < 0);
  if (flash && changed && !calm.matches) item.root.animate([{ backgroundColor: "color-mix(in srgb, var(--accent) 30%, transparent)" }, { backgroundColor: "transparent" }], FLASH);
}

// The difference to the reference, in the number's own unit; none where either has no number.
export function writeChange(item, value, before) {
  const known = Number.isFinite(value) && Number.isFinite(before);
  const [text, unit] = [known ? item.show(value - before) : ""].flat();
  const own = [item.show(Number.isFinite(value) ? value : 0)].flat();
  const still = !known || Number(text.replace("\u2212", "-")) === 0;
  const shown = still ? "" : `${text.startsWith("\u2212") ? "" : "+"}${text}${unit && unit !== own[1] ? ` ${unit}` : ""}`;
  setText(item.change, shown);
}

export function writeNote(item, note, end) {
  if (!item.noteNode) return;
  const key = note ? `${note.text} ${note.time ?? ""}` : "";
  if (item.noteKey === key) return;
  item.noteKey = key;
  item.noteNode.hidden = !note;
  if (!note) return;
  item.noteNode.classList.toggle("low", Boolean(note.bad));
  const time = note.time === undefined ? null
    : el("button", { class: "time-link", type: "button", title: "Go there", onclick: () => item.onTime?.(note.time) }, clockText(note.time, end));
  item.noteNode.replaceChildren(note.text, time ? " " : "", time ?? "");
}
