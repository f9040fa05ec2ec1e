// The head of a job's page: its state and progress, what may be asked of it, why cases failed, its files.

import { $, el, setText } from "./dom.js";
import { NONE } from "./format.js";
import { act, showActions } from "./jobactions.js";
import { FORMATS, designInStudio, documentFile, resultsFile } from "./jobapi.js";
import { KINDS, ProgressBar, casesOf, casesText, duration, isOver, mendable, nameOf, rateText, setChip, toldOf, tookText, when, whole } from "./jobwords.js";
import { problemNodes } from "./problem.js";

const bar = new ProgressBar();

export function showProblem(problem) {
  $("problem").hidden = problem === null;
  $("problem").replaceChildren(...(problem ? problemNodes(problem) : []));
}

function facts(job) {
  const { progress, design, started, created, finished } = job;
  const left = isOver(job) ? [["Took", tookText(job)]] : [["Rate", rateText(progress.rate)], ["Time left", duration(progress.seconds_left)]];
  const name = design.id ? el("a", { href: designInStudio(design.id) }, design.name || "unnamed") : design.name || "unnamed";
  const revision = design.revision ? ` · revision ${design.revision}` : "";
  return [
    ["Kind", KINDS[job.kind] ?? job.kind], ["Design", [name, revision]], ...left, ["Created", when(created)],
    started && !finished ? ["Started", when(started)] : finished ? ["Finished", when(finished)] : null,
    ["Program", `${job.engine.version}, kernel ${job.engine.kernel.slice(0, 8)}`],
  ].filter(Boolean);
}

export function showHead(job, { ask }) {
  document.title = `${nameOf(job)} · Jobs · Glider studio`;
  setText($("name"), nameOf(job));
  $("name").title = nameOf(job);
  setChip($("state"), job.state);
  const { failed, cases, done } = job.progress;
  bar.show(job);
  if (!bar.node.parentNode) $("bar").append(bar.node);
  setText($("progress-done"), `${casesText(job.progress)} ${cases === 1 ? "case" : "cases"}`);
  setText($("progress-failed"), failed ? `${whole(failed)} failed` : "");
  setText($("progress-percent"), cases > 0 ? `${Math.floor((100 * done) / cases)} %` : NONE);
  $("facts").replaceChildren(...facts(job).map(([name, value]) => el("div", {}, el("dt", {}, name), el("dd", {}, ...[value].flat()))));
  const { tone, text } = toldOf(job);
  $("reason").hidden = text === "";
  $("reason").className = `box ${tone}`;
  $("reason-text").dataset.tone = tone;
  setText($("reason-text"), text);
  $("warnings").hidden = job.warnings.length === 0;
  setText($("warnings-text"), job.warnings.join(" "));
  showActions($("actions"), job, ask);
  for (const link of $("downloads").querySelectorAll("[data-format]")) link.toggleAttribute("aria-disabled", done === 0);
}

// What a retry could do about the failures, said where it is offered and where it is not.
function retryText(job) {
  const { failed } = job.progress;
  const broke = mendable(job);
  const rest = "Narrow the ranges or mend the design, and start a new job.";
  if (broke === 0) return `A retry is not offered: ${failed === 1 ? "this case fails" : "these cases fail"} by ${failed === 1 ? "its" : "their"} own values, and would fail again. ${rest}`;
  const mend = `A retry may mend the ${casesOf(broke)} whose computation broke off`;
  return broke < failed ? `${mend}; the others fail by their own values, and would fail again.` : `${mend}.`;
}

// The reasons of failures, each a button that shows only its cases.
export function showFailures(job, { group, pick }) {
  const { failures } = job;
  $("failures").hidden = failures.length === 0;
  setText($("retry-why"), retryText(job));
  const key = JSON.stringify([failures, group]);
  if ($("failures").dataset.key === key) return;
  $("failures").dataset.key = key;
  const focused = document.activeElement?.dataset?.reason;
  $("failure-list").replaceChildren(...failures.map(({ reason, count }) => el("li", {}, el("button", {
    type: "button", class: "failure", "aria-pressed": String(group === reason), "data-reason": reason, "data-testid": "failure", title: "Show only these cases", onclick: () => pick(group === reason ? null : reason),
  }, el("b", {}, whole(count)), el("span", {}, reason)))));
  if (focused) [...$("failure-list").querySelectorAll("button")].find((b) => b.dataset.reason === focused)?.focus();
}

export function connectActions(getJobNow, { onJob, onDeleted }) {
  return async (verb) => {
    showProblem(null);
    try {
      const answer = await act(getJobNow(), verb);
      if (answer === null) onDeleted();
      else if (answer) onJob(answer);
    } catch (error) {
      showProblem(error.problem ?? { title: error.message });
    }
  };
}

export function connectDownloads(id) {
  const menu = $("downloads");
  const close = () => menu.removeAttribute("open");
  const tables = Object.entries(FORMATS).map(([format, label]) => el("a", { href: resultsFile(id, format), download: true, "data-format": format, "data-testid": `download-${format}` }, `Case table as ${label}`));
  const batch = el("a", { href: documentFile(id), download: `job-${id}-batch.json`, "data-testid": "download-document" }, "Batch document");
  $("download-items").append(...tables, batch);
  for (const link of $("download-items").children) {
    link.addEventListener("click", (event) => (link.hasAttribute("aria-disabled") ? event.preventDefault() : close()));
  }
  document.addEventListener("pointerdown", (event) => menu.contains(event.target) || close());
  menu.addEventListener("keydown", (event) => {
    if (event.key !== "Escape") return;
    close();
    menu.querySelector("summary").focus();
  });
}
