// Warnings of the design, of its run and of what follows from them: the worst first, each leading to its field and time.

import { $, el, setText } from "./dom.js";
import { clockText, trueMinus } from "./format.js";
import { spanText } from "./held.js";

const ORDER = ["bad", "warn", "note"];
const WORDS = { bad: "Serious", warn: "Warning", note: "Note" };
const MOST_TIMES = 4;

// Those of the state and of the consequences as one list; its order is what `focusedWarning` counts by.
export function allWarnings(state, consequences) {
  const all = [...(state?.warnings ?? []), ...(consequences?.warnings ?? [])];
  const written = all.map((warning) => ({ ...warning, message: trueMinus(warning.message), hint: trueMinus(warning.hint) }));
  return written.sort((a, b) => ORDER.indexOf(a.severity ?? "warn") - ORDER.indexOf(b.severity ?? "warn"));
}

// `untold` counts further stretches, which were not sent and are not on the timeline.
function timeLinks(times, untold, clock) {
  const links = times.slice(0, MOST_TIMES).map((span) => el("button", { class: "time-link", type: "button", title: "Go there", onclick: () => clock.seek(span[0]) },
    span[1] > span[0] ? spanText(span, clock.end) : clockText(span[0], clock.end)));
  const left = times.length - links.length + untold;
  const more = left ? ` and ${left} more${untold ? `; the timeline shows the first ${times.length}` : ""}` : "";
  return el("p", { class: "when" }, ...links.flatMap((link, k) => (k ? [" ", link] : [link])), more);
}

// One line until it is opened; the line holds the whole text, which only the eye sees cut.
function warningNode({ message, hint, pointer, severity = "warn", times = [], more_times: untold = 0 }, { link, clock, open }) {
  return el("details", { class: `box ${severity}`, open, "data-severity": severity },
    el("summary", { title: `${WORDS[severity]}: ${message}` }, message),
    hint ? el("p", {}, `${hint[0].toUpperCase()}${hint.slice(1)}.`) : null,
    times.length ? timeLinks(times, untold, clock) : null,
    pointer ? link(pointer) : null);
}

export function connectWarnings({ store, clock, link }) {
  const panel = $("warnings");
  let shown = "";

  store.watch(["state", "consequences"], ({ state, consequences }) => {
    if (!state) return;
    const warnings = allWarnings(state, consequences);
    const key = JSON.stringify([warnings, clock.end]);
    if (key === shown) return; // a rebuilt list would lose the focus
    shown = key;
    $("warnings-panel").hidden = warnings.length === 0;
    setText($("warnings-title"), warnings.length > 1 ? `Warnings · ${warnings.length}` : "Warnings");
    const open = new Set([...panel.querySelectorAll("details[open] summary")].map((node) => node.textContent));
    const focused = panel.contains(document.activeElement) ? document.activeElement.textContent : null;
    panel.replaceChildren(...warnings.map((warning) => warningNode(warning, { link, clock, open: open.has(warning.message) })));
    if (focused) [...panel.querySelectorAll("summary, button")].find((node) => node.textContent === focused)?.focus();
    store.set({ warnings });
  });

  const indexOf = (target) => [...panel.children].indexOf(target.closest("details"));
  for (const [event, found] of [["pointerover", true], ["focusin", true], ["pointerleave", false], ["focusout", false]]) {
    panel.addEventListener(event, ({ target }) => store.set({ focusedWarning: found && panel.contains(target) && target !== panel ? indexOf(target) : null }));
  }
  store.watch(["focusedWarning", "warnings"], ({ focusedWarning }) => {
    [...panel.children].forEach((node, k) => node.classList.toggle("focused", k === focusedWarning));
  });
}
