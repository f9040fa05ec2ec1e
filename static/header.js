// The header: the design's name and state, undo and redo, open and export.

import { readDesignFile } from "./api.js";
import { $, setText } from "./dom.js";
import { clockTime } from "./format.js";

function savedText(origin) {
  if (origin?.kind !== "stored") return "Not saved";
  return origin.changed ? `Revision ${origin.revision} · unsaved changes` : `Revision ${origin.revision}`;
}

function savedTitle({ origin, saved_at: savedAt }) {
  const kept = savedAt ? `This work is kept for this browser alone, since ${clockTime(savedAt)}. ` : "";
  return origin?.kind === "stored" && !origin.changed ? "All is saved" : `${kept}Save stores it as a design with a link of its own`;
}

function showOrigin(state) {
  const { origin } = state;
  setText($("saved"), savedText(origin));
  $("saved").title = savedTitle(state);
  $("saved").toggleAttribute("data-changed", Boolean(origin?.changed));
  const ofCase = origin?.kind === "case";
  const name = ofCase ? `Case ${origin.case}${origin.changed ? ", edited" : ""} · ${origin.job_name}` : "";
  $("case").hidden = !ofCase;
  $("case").href = ofCase ? `../../jobs/${encodeURIComponent(origin.job_id)}` : "";
  $("case").title = ofCase ? `${name}. Show the job` : "";
  setText($("case"), name);
  const mark = origin?.kind === "stored" && origin.changed ? "● " : "";
  document.title = `${mark}${ofCase ? `${name} · ` : ""}${state.name} · Glider studio`;
}

function show({ state, busy }) {
  if (!state) return;
  setText($("name"), state.name);
  $("name").title = state.name;
  showOrigin(state);
  setText($("hydrodynamics"), state.hydrodynamics ?? "");
  $("hydrodynamics").title = `Hydrodynamics: ${state.hydrodynamics}. Show the data against the law`;
  setText($("solver"), state.solver ?? "");
  $("solver").title = `Solver: ${state.solver}`;
  $("undo").disabled = !state.can_undo;
  $("redo").disabled = !state.can_redo;
  $("trim").disabled = busy > 0;
  for (const id of ["export-csv", "export-nc"]) $(id).toggleAttribute("aria-disabled", !state.run);
}

function connectMenu(menu) {
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
  connectMenu($("export"));
  connectMenu($("link"));
  connectKeys(actions);
}
