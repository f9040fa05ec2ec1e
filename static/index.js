// The start page: presets as cards, each opened by a plain form; or a design file of one's own.

import { createSession, getPresets, readDesignFile } from "./api.js";
import { $, el } from "./dom.js";
import { dayAndTime } from "./format.js";
import { problemNodes } from "./problem.js";
import { forgetGone, recentSessions } from "./recent.js";
import { connectStoredList } from "./storedlist.js";

function card({ id, name, summary }) {
  const image = el("img", { src: `presets/${encodeURIComponent(id)}.svg`, alt: "", loading: "lazy" });
  image.addEventListener("error", () => image.remove());
  const form = el("form", { method: "post", action: "sessions" },
    el("input", { type: "hidden", name: "preset", value: id }),
    el("button", { class: "btn primary", type: "submit", "aria-label": `Open ${name}`, "data-testid": `open-${id}` }, "Open"));
  return el("li", { class: "card", "data-testid": `preset-${id}` },
    el("figure", {}, image),
    el("div", { class: "text" }, el("h3", {}, name), el("p", {}, summary ?? ""), form));
}

function note(text, action) {
  $("note").hidden = text === "";
  $("note").replaceChildren(text, ...(action ? [action] : []));
}

async function showPresets() {
  note("Loading presets…");
  try {
    const { items } = await getPresets();
    $("presets").replaceChildren(...items.map(card));
    note(items.length ? "" : "No presets are installed. Open a design file to start.");
  } catch (error) {
    const retry = el("button", { class: "btn", type: "button", onclick: showPresets }, "Try again");
    note(`The presets could not be loaded: ${error.problem?.detail ?? error.message}.`, retry);
  }
  $("presets").setAttribute("aria-busy", "false");
}

function recentLink({ id, name, time }) {
  const when = el("time", { datetime: new Date(time).toISOString() }, dayAndTime(time));
  return el("li", {}, el("a", { class: "btn", href: `s/${encodeURIComponent(id)}/`, title: name, "data-testid": `recent-${id}` }, el("span", {}, name), when));
}

function showRecent() {
  const items = recentSessions();
  $("recent").hidden = items.length === 0;
  $("recent-list").replaceChildren(...items.map(recentLink));
}

function showProblem(problem) {
  $("problem").hidden = problem === null;
  $("problem").replaceChildren(...(problem ? problemNodes(problem) : []));
}

async function openFile(file) {
  showProblem(null);
  $("open").disabled = true;
  try {
    const { url } = await createSession(await readDesignFile(file));
    location.assign(url);
  } catch (error) {
    showProblem(error.problem ?? { title: error.message });
  } finally {
    $("open").disabled = false;
    $("file").value = "";
  }
}

$("open").addEventListener("click", () => $("file").click());
$("file").addEventListener("change", () => $("file").files[0] && openFile($("file").files[0]));
showPresets();
showRecent();
forgetGone(showRecent);
connectStoredList();
// A page kept by the browser for its back button knows nothing of the sessions opened since.
window.addEventListener("pageshow", (event) => event.persisted && showRecent());
