// Cancel, resume, retry and delete: the buttons, and the question before what cannot be undone.

import { $, el } from "./dom.js";
import { changeJob, deleteJob } from "./jobapi.js";
import { actionsOf, casesText, nameOf } from "./jobwords.js";

// Anew only where others are possible now: a rebuilt button would lose the focus.
export function showActions(root, job, ask) {
  const actions = actionsOf(job);
  const key = actions.map(({ verb, label }) => verb + label).join();
  if (root.dataset.actions === key) return;
  const focused = root.contains(document.activeElement);
  root.dataset.actions = key;
  root.replaceChildren(...actions.map(({ verb, label, title }) => el("button", {
    class: "btn small", type: "button", title, "aria-label": `${label}: ${nameOf(job)}`, "data-testid": verb, onclick: () => ask(verb),
  }, label)));
  if (focused) root.querySelector("button")?.focus();
}

// Asks in a dialog; answers whether the person agreed.
export function confirmDelete(job) {
  const dialog = $("confirm");
  $("confirm-text").textContent = `“${nameOf(job)}” and the results of ${casesText(job.progress)} cases are deleted for good.`;
  dialog.returnValue = "";
  dialog.showModal();
  return new Promise((resolve) => {
    dialog.addEventListener("close", () => resolve(dialog.returnValue === "delete"), { once: true });
  });
}

// Does what was asked; answers the job as it is now, null where it is deleted, undefined where nothing was done.
export async function act(job, verb) {
  if (verb !== "delete") return changeJob(job.id, verb);
  if (!(await confirmDelete(job))) return undefined;
  await deleteJob(job.id);
  return null;
}
