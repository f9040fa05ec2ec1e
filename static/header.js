// The header: the design's name and state, undo and redo, open and export.

import { readDesignFile } from "./api.js";
import { $, setText } from "./dom.js";
import { clockTime } from "./format.js";
import { describeKey, onKey, openKeys } from "./keys.js";
import { connectMenu } from "./menu.js";
import { focusField } from "./parts.js";
import { connectTheme } from "./theme.js";

const SOLVER = "/mission/solver/model"; // where the solver's fields begin

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

// In the header and beside the readouts of now: cut names are whole in the title.
function showSource({ hydrodynamics: source, hydrodynamics_range: range }) {
  for (const id of ["hydrodynamics-source", "source-title"]) setText($(id), source ?? "");
  setText($("hydrodynamics-range"), range ?? "");
  $("source-title").title = source ?? "";
  $("hydrodynamics").title = `Forces: ${source}, with data for ${range}. Show the data against the law`;
}

function show({ state, busy }) {
  if (!state) return;
  setText($("rename"), state.name);
  $("rename").title = `${state.name}. Click to rename`;
  showOrigin(state);
  showSource(state);
  const [model, ...method] = (state.solver ?? "").split(" · ");
  setText($("solver-model"), model);
  setText($("solver-method"), method.join(" · "));
  $("solver").title = `Solver: ${state.solver}. Show its settings`;
  $("undo").disabled = !state.can_undo;
  $("redo").disabled = !state.can_redo;
  $("trim").disabled = busy > 0;
  for (const id of ["export-csv", "export-nc", "export-replay", "export-png"]) $(id).toggleAttribute("aria-disabled", !state.run);
}

// The name turns into a field where it stands; Enter or leaving it renames, Escape does not.
function connectName({ store, actions }) {
  const [button, field] = [$("rename"), $("rename-field")];
  function edit() {
    field.value = store.get("state")?.name ?? "";
    button.hidden = true;
    field.hidden = false;
    field.select();
  }
  function leave(keep) {
    if (field.hidden) return;
    const name = field.value.trim();
    const hadFocus = document.activeElement === field;
    field.hidden = true;
    button.hidden = false;
    if (hadFocus) button.focus();
    if (keep && name && name !== store.get("state")?.name) actions.edit([{ op: "replace", path: "/name", value: name }]);
  }
  button.addEventListener("click", edit);
  field.addEventListener("blur", () => leave(true));
  field.addEventListener("keydown", (event) => {
    if (event.key === "Enter") leave(true);
    else if (event.key === "Escape") leave(false);
  });
}

function connectKeys(actions) {
  const group = "Design";
  onKey("Ctrl+z", actions.undo, { words: "Undo", group });
  onKey(["Ctrl+Shift+z", "Ctrl+y"], actions.redo, { words: "Redo", group });
  describeKey("Ctrl+S", "Save", group); // handled by stored.js, in fields too
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
  $("solver").addEventListener("click", () => focusField(SOLVER));
  connectName({ store, actions });
  connectTrim({ store, actions });
  connectMenu($("export"));
  connectMenu($("link"));
  connectTheme($("theme"));
  $("show-keys").addEventListener("click", openKeys);
  connectKeys(actions);
}
