// The header: the design's name and state, undo and redo, open, save and export.

import { readDesignFile } from "./api.js";
import { $, setText } from "./dom.js";
import { clockTime } from "./format.js";

function savedText({ saved_at: savedAt, revision }) {
  return savedAt ? `saved ${clockTime(savedAt)} · revision ${revision}` : `not saved · revision ${revision}`;
}

function show({ state, busy }) {
  if (!state) return;
  document.title = `${state.name} · Glider studio`;
  setText($("name"), state.name);
  $("name").title = state.name;
  setText($("saved"), savedText(state));
  setText($("hydrodynamics"), state.hydrodynamics ?? "");
  $("hydrodynamics").title = `Hydrodynamics: ${state.hydrodynamics}. Show the data against the law`;
  setText($("solver"), state.solver ?? "");
  $("solver").title = `Solver: ${state.solver}`;
  $("undo").disabled = !state.can_undo;
  $("redo").disabled = !state.can_redo;
  $("trim").disabled = busy > 0;
  for (const id of ["export-csv", "export-nc"]) $(id).toggleAttribute("aria-disabled", !state.run);
}

function connectMenu() {
  const menu = $("export");
  const close = () => menu.removeAttribute("open");
  document.addEventListener("pointerdown", (event) => menu.contains(event.target) || close());
  menu.addEventListener("keydown", (event) => {
    if (event.key !== "Escape") return;
    close();
    menu.querySelector("summary").focus();
  });
  for (const link of menu.querySelectorAll("a")) {
    link.addEventListener("click", (event) => (link.hasAttribute("aria-disabled") ? event.preventDefault() : close()));
  }
}

function connectKeys(actions) {
  document.addEventListener("keydown", (event) => {
    if (!(event.ctrlKey || event.metaKey) || event.key.toLowerCase() !== "z") return;
    if (/^(INPUT|TEXTAREA)$/.test(event.target.tagName) && event.target.type !== "range") return;
    event.preventDefault();
    if (event.shiftKey) actions.redo();
    else actions.undo();
  });
}

// What was said about a trim holds until the design changes again.
function connectTrim({ store, actions }) {
  let revision = Infinity;
  const say = (text) => setText($("trim-message"), text);
  $("trim").addEventListener("click", async () => {
    say("");
    revision = Infinity; // the trim's own state may come before its answer
    const answer = await actions.trim();
    revision = answer?.revision ?? store.get("state")?.revision ?? Infinity;
    say(answer?.message ?? "");
  });
  store.watch(["state"], ({ state }) => state && state.revision > revision && say(""));
}

export function connectHeader({ store, actions }) {
  store.watch(["state", "busy"], show);
  $("undo").addEventListener("click", actions.undo);
  $("redo").addEventListener("click", actions.redo);
  $("open").addEventListener("click", () => $("file").click());
  $("file").addEventListener("change", async () => {
    const [file] = $("file").files;
    $("file").value = "";
    if (file) actions.open(() => readDesignFile(file));
  });
  connectTrim({ store, actions });
  connectMenu();
  connectKeys(actions);
}
