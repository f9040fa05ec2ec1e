// Saving: a session's document becomes a stored design, or its next revision; and what to do where others were quicker.

import { saveDesign } from "./api.js";
import { $, setText } from "./dom.js";
import { dayAndTime } from "./format.js";
import { problemNodes } from "./problem.js";
import { ROOT } from "./root.js";

export const designLink = (id, query = {}) => {
  const given = new URLSearchParams(query).toString();
  return new URL(`d/${encodeURIComponent(id)}${given ? `?${given}` : ""}`, ROOT).href;
};

const isSaved = ({ origin }) => origin?.kind === "stored" && !origin.changed;

const GONE = {
  404: { title: "This design is no longer there", text: "It was stored once, and the store does not know it any more. Yours is kept here." },
  410: { title: "This design was deleted meanwhile", text: "Yours is kept here, and the deleted one with its history." },
};

// What the dialog says, and how its second way saves.
function conflictOf(problem, origin) {
  const { newest, status } = problem;
  if (status !== 412) return { ...GONE[status], over: status === 410 && RESTORING };
  const said = newest.comment ? `: “${newest.comment}”` : "";
  return {
    title: "A newer revision was saved",
    text: `“${newest.name}” is at revision ${newest.revision}, saved ${dayAndTime(newest.updated * 1000)}${said}. Yours began with revision ${origin.revision}. Whatever you choose, neither is lost.`,
    over: overwriting(newest.revision),
    theirs: newest,
  };
}

const overwriting = (revision) => ({
  request: { how: "over", revision },
  title: "Put yours on top",
  text: `Yours becomes revision ${revision + 1}; revision ${revision} stays in the history.`,
  label: `Save as revision ${revision + 1}`,
});

const RESTORING = {
  request: { how: "restore" },
  title: "Bring it back",
  text: "It is restored with its history, and yours is saved on top.",
  label: "Restore and save",
};

function showProblem(problem) {
  $("conflict-problem").hidden = problem === null;
  $("conflict-problem").replaceChildren(...(problem ? problemNodes(problem) : []));
}

function showConflict({ title, text, over, theirs }, name) {
  setText($("conflict-title"), title);
  setText($("conflict-text"), text);
  $("conflict-name").value = `${name} (copy)`.slice(0, 200);
  $("conflict-top").hidden = !over;
  setText($("conflict-over-title"), over ? over.title : "");
  setText($("conflict-over-text"), over ? over.text : "");
  setText($("conflict-over"), over ? over.label : "");
  $("conflict-look").hidden = !theirs;
  setText($("conflict-theirs"), theirs ? `Open revision ${theirs.revision}` : "");
  $("conflict-theirs").href = theirs ? designLink(theirs.design_id, { revision: theirs.revision }) : "";
  showProblem(null);
  if (!$("conflict").open) $("conflict").showModal();
}

export function connectSaving(store) {
  const dialog = $("conflict");
  let busy = false;
  let over = null;

  function show() {
    const state = store.get("state");
    const saved = Boolean(state && isSaved(state));
    setText($("save"), busy ? "Saving…" : saved ? "Saved" : "Save");
    $("save").disabled = busy || !state || saved || store.get("over");
    for (const id of ["conflict-new", "conflict-over"]) $(id).disabled = busy;
  }

  function refused(problem) {
    const { origin, name } = store.get("state");
    const conflict = problem.newest || GONE[problem.status] ? conflictOf(problem, origin) : null;
    if (conflict) {
      over = conflict.over || null;
      showConflict(conflict, name);
    } else if (dialog.open) showProblem(problem);
    else store.set({ rejected: problem, rejectedHere: true });
  }

  async function save(request) {
    if (busy) return;
    busy = true;
    show();
    try {
      await saveDesign(request);
      store.set({ rejected: null });
      dialog.close();
    } catch (error) {
      refused(error.problem ?? { title: error.message });
    } finally {
      busy = false;
      show();
    }
  }

  const saveNew = () => save({ how: "new", name: $("conflict-name").value.trim() });
  const saveNext = () => !$("save").disabled && save({ how: "next" });

  function press(event) {
    if (!(event.ctrlKey || event.metaKey) || event.shiftKey || event.altKey || event.key.toLowerCase() !== "s") return;
    event.preventDefault();
    if (!dialog.open) saveNext();
  }

  $("save").addEventListener("click", saveNext);
  $("conflict-new").addEventListener("click", saveNew);
  $("conflict-name").addEventListener("keydown", (event) => {
    if (event.key !== "Enter") return;
    event.preventDefault(); // else it would press the dialog's last button
    saveNew();
  });
  $("conflict-over").addEventListener("click", () => save(over.request));
  document.addEventListener("keydown", press);
  store.watch(["state", "over"], show);
  return { press };
}
