// What the export menu makes beside plain downloads: a picture of the view, and the glide as one HTML file.

import { $, el } from "./dom.js";
import { notesOf } from "./picture.js";

const RELEASE_AFTER = 10_000; // ms; a browser has long begun to save by then

function save(blob, name) {
  const address = URL.createObjectURL(blob);
  el("a", { href: address, download: name }).click();
  setTimeout(() => URL.revokeObjectURL(address), RELEASE_AFTER);
}

const fileName = (name, ending) => `${name.toLowerCase().replace(/[^a-z0-9]+/g, "-").replace(/^-|-$/g, "").slice(0, 60) || "design"}.${ending}`;

async function readProblem(response) {
  try {
    return { status: response.status, ...(await response.json()) };
  } catch {
    return { title: `The studio answered ${response.status}`, status: response.status };
  }
}

// A note that something is being made, with a way to stop it.
function working(text, stop) {
  const note = el("div", { class: "working", role: "status", "data-testid": "working" }, el("i", { class: "pulse", "aria-hidden": "true" }), text,
    el("button", { class: "btn small", type: "button", "data-testid": "working-cancel", onclick: stop }, "Cancel"));
  document.body.append(note);
  return () => note.remove();
}

async function fetchReplay(signal) {
  const answer = await fetch("replay.html", { signal });
  if (!answer.ok) throw Object.assign(new Error("refused"), { problem: await readProblem(answer) });
  return answer.blob();
}

export function connectExports({ store, clock, viewer }) {
  const nameOf = (ending) => fileName(store.get("state").name, ending);
  const refuse = (problem) => store.set({ rejected: problem, rejectedHere: true });
  let making = false;

  async function replay() {
    if (making) return;
    making = true;
    const stopper = new AbortController();
    const done = working("Making the replay…", () => stopper.abort());
    try {
      save(await fetchReplay(stopper.signal), nameOf("html"));
    } catch (error) {
      const lost = { title: "The studio cannot be reached", detail: "Check that it is still running, then export again.", status: 0 };
      if (error.name !== "AbortError") refuse(error.problem ?? lost);
    } finally {
      done();
      making = false;
    }
  }

  async function picture() {
    const blob = await viewer.picture(notesOf(store.get("state"), clock, store.get("view")));
    if (blob) save(blob, nameOf("png"));
    else refuse({ title: "The view has no picture yet", detail: "It is still loading: export again when the glider is seen." });
  }

  for (const [id, make] of [["export-replay", replay], ["export-png", picture]]) {
    $(id).addEventListener("click", (event) => {
      event.preventDefault();
      if (!$(id).hasAttribute("aria-disabled")) make();
    });
  }
}
