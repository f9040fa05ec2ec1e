// The dialog "New job": a batch document is pasted, opened or started from an example, and sent; what is wrong is shown.

import { $, el } from "./dom.js";
import { createJob, jobPage } from "./jobapi.js";
import { exampleDocument } from "./jobexamples.js";
import { placeOf } from "./jsonplace.js";
import { problemNodes } from "./problem.js";

function notJson(error) {
  return { title: "This is not JSON", errors: [{ message: error.message, hint: "A batch document is JSON text, as in the example." }] };
}

// A pointer leads to its place in the text.
function pointerLink(pointer) {
  const place = placeOf($("document").value, pointer);
  if (!place) return el("span", { class: "where" }, pointer);
  return el("button", { type: "button", class: "link", onclick: () => show(place) }, pointer);
}

function show([begin, end]) {
  const area = $("document");
  const line = area.value.slice(0, begin).split("\n").length - 1;
  area.focus();
  area.setSelectionRange(begin, end);
  area.scrollTop = Math.max(0, (line - 4) * parseFloat(getComputedStyle(area).lineHeight));
  area.scrollLeft = 0;
}

function showProblem(problem) {
  $("new-problem").hidden = problem === null;
  $("new-problem").replaceChildren(...(problem ? problemNodes(problem, { link: pointerLink }) : []));
  $("document").toggleAttribute("aria-invalid", problem !== null);
}

async function submit() {
  const text = $("document").value;
  showProblem(null);
  try {
    JSON.parse(text);
  } catch (error) {
    return showProblem(notJson(error));
  }
  $("submit").disabled = true;
  try {
    const { id } = await createJob(text, { fresh: $("fresh").checked });
    location.assign(jobPage(id));
  } catch (error) {
    showProblem(error.problem ?? { title: error.message });
  } finally {
    $("submit").disabled = false;
  }
}

async function fill(read) {
  showProblem(null);
  try {
    $("document").value = await read();
  } catch (error) {
    return showProblem(error.problem ?? { title: error.message });
  }
  $("document").focus();
  $("document").setSelectionRange(0, 0);
  $("document").scrollTop = 0;
}

export function connectNewJob() {
  $("new").addEventListener("click", () => {
    $("new-job").showModal();
    $("document").focus();
  });
  $("new-close").addEventListener("click", () => $("new-job").close());
  $("document-open").addEventListener("click", () => $("document-file").click());
  $("document-file").addEventListener("change", () => {
    const [file] = $("document-file").files;
    $("document-file").value = "";
    if (file) fill(() => file.text());
  });
  $("document-example").addEventListener("click", () => fill(exampleDocument));
  $("new-form").addEventListener("submit", (event) => {
    event.preventDefault();
    submit();
  });
  $("document").addEventListener("keydown", (event) => (event.ctrlKey || event.metaKey) && event.key === "Enter" && submit());
}
