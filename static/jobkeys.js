// The keys of the list: j and k or arrows from job to job, a letter for what is asked of one.

import { $ } from "./dom.js";
import { actionsOf } from "./jobwords.js";

const takesKeys = (target) => /^(INPUT|TEXTAREA|SELECT)$/.test(target?.tagName ?? "");

const STEPS = { j: 1, ArrowDown: 1, k: -1, ArrowUp: -1, Home: -Infinity, End: Infinity };
const VERBS = { c: ["cancel"], r: ["resume", "retry"], Delete: ["delete"] };

export function connectKeys({ rows, onAction }) {
  const at = (list) => list.findIndex(({ node }) => node.contains(document.activeElement));

  function step(key) {
    const list = rows();
    const now = at(list);
    const wanted = now < 0 && Number.isFinite(STEPS[key]) ? 0 : now + STEPS[key];
    list[Math.min(Math.max(wanted, 0), list.length - 1)]?.focus();
  }

  function ask(key) {
    const row = rows()[at(rows())];
    const verb = row && actionsOf(row.job).find((action) => VERBS[key].includes(action.verb))?.verb;
    if (verb) onAction(row.job, verb);
  }

  document.addEventListener("keydown", (event) => {
    if (event.ctrlKey || event.metaKey || event.altKey || document.querySelector("dialog[open]")) return;
    const { key, target } = event;
    if (target === $("search") && (key === "ArrowDown" || key === "Enter")) step("j");
    else if (takesKeys(target)) return;
    else if (key in STEPS) step(key);
    else if (key in VERBS) ask(key);
    else if (key === "/") $("search").select();
    else if (key === "n") $("new").click();
    else if (key === "?") $("keys").showModal();
    else return;
    event.preventDefault();
  });
  $("show-keys").addEventListener("click", () => $("keys").showModal());
}
