// What both pages of jobs say in words: states, kinds, progress, times; and what may be asked of a job.

import { el } from "./dom.js";
import { NONE, fixed } from "./format.js";

export const STATES = {
  queued: "Queued", running: "Running", paused: "Paused", cancelling: "Cancelling",
  cancelled: "Cancelled", succeeded: "Succeeded", partial: "Partial", failed: "Failed",
};
export const KINDS = { simulate: "Simulation", sweep: "Sweep", monte_carlo: "Monte Carlo", sensitivity: "Sensitivity" };
const OVER = ["cancelled", "succeeded", "partial", "failed"];

export const isOver = ({ state }) => OVER.includes(state);
export const isMoving = ({ state }) => ["running", "cancelling", "queued"].includes(state);

export const nameOf = ({ name, kind, design }) => name || `${KINDS[kind] ?? kind} of ${design.name || "a design"}`;

// A case's numbers depend on its values alone: what was refused, or ran away, does so each time. Only a computation that
// broke off, as by a lack of memory, may end otherwise.
export const mayMend = (reason) => /^(crashed|cancelled)\b/.test(reason);

// How many failed cases a retry may mend; of the rarest kinds of failures a record does not tell, which may be such.
export function mendable({ failures, progress }) {
  const told = failures.reduce((sum, { count }) => sum + count, 0);
  return failures.reduce((sum, { reason, count }) => sum + (mayMend(reason) ? count : 0), Math.max(0, progress.failed - told));
}

function again(job) {
  if (job.state === "cancelled") return { label: "Continue", title: "Compute what is missing" };
  const broke = OVER.includes(job.state) ? mendable(job) : 0;
  return broke > 0 ? { label: "Retry failed", title: `Compute again the ${casesOf(broke)} whose computation broke off` } : null;
}

// What may be asked of a job in its state, each with the word for it.
export function actionsOf(job) {
  const actions = [];
  if (job.state === "paused") actions.push({ verb: "resume", label: "Resume", title: "Go on where it paused" });
  if (!isOver(job) && job.state !== "cancelling") actions.push({ verb: "cancel", label: "Cancel", title: "Stop; what is done is kept" });
  const more = again(job);
  if (more) actions.push({ verb: "retry", ...more });
  if (isOver(job)) actions.push({ verb: "delete", label: "Delete", title: "Delete the job and its results" });
  return actions;
}

export const whole = (n) => String(n).replace(/\B(?=(\d{3})+$)/g, "\u2009");

export const casesOf = (n) => `${whole(n)} ${n === 1 ? "case" : "cases"}`;

export const casesText = ({ done, cases }) => `${whole(done)} of ${whole(cases)}`;

// The reason of a refused case names fields by their pointers, "; " between several: message and pointer, apart.
export function reasonParts(reason) {
  return (reason ?? "").split(/; (?=\/)/).filter(Boolean).map((part) => {
    const [, pointer, text] = /^(\/[^\s:]*): (.*)$/s.exec(part) ?? [null, null, part];
    return { pointer, text: capital(text) };
  });
}

const capital = (text) => text && text[0].toUpperCase() + text.slice(1);

// Why a job is as it is, with what that means: good, calm (it needs nothing), warn or bad.
export function toldOf({ state, reason, stopped_early: early }) {
  if (early) return { tone: "good", text: capital(reason ?? "stopped before all cases: the wanted width was reached") };
  if (reason) return { tone: { failed: "bad", paused: "warn" }[state] ?? "calm", text: capital(reason) };
  return { tone: "calm", text: state === "queued" ? "It waits for its turn." : "" };
}

export function rateText(rate) {
  if (rate == null || !(rate > 0)) return NONE;
  if (rate < 1) return `${fixed(60 * rate, rate < 0.1 ? 1 : 0)} cases/min`;
  return `${rate < 10 ? fixed(rate, 1) : whole(Math.round(rate))} cases/s`;
}

export function duration(seconds) {
  if (seconds == null || !Number.isFinite(seconds)) return NONE;
  const s = Math.max(0, Math.round(seconds));
  if (s < 1) return "under 1 s";
  if (s < 100) return `${s} s`;
  if (s < 100 * 60) return `${Math.round(s / 60)} min`;
  if (s < 48 * 3600) return `${Math.floor(s / 3600)} h ${Math.round((s % 3600) / 60)} min`;
  return `${Math.round(s / 86400)} days`;
}

export function when(iso) {
  if (!iso) return NONE;
  const time = new Date(iso);
  const today = time.toDateString() === new Date().toDateString();
  const clock = { hour: "2-digit", minute: "2-digit" };
  return today ? time.toLocaleTimeString([], clock) : time.toLocaleString(undefined, { month: "short", day: "numeric", ...clock });
}

// How long it took, or takes so far.
export function tookText({ started, finished }) {
  if (!started) return NONE;
  return duration(((finished ? Date.parse(finished) : Date.now()) - Date.parse(started)) / 1000);
}

export function chip(state) {
  return el("span", { class: "chip", "data-state": state, "data-testid": "state" }, STATES[state] ?? state);
}

export function setChip(node, state) {
  if (node.dataset.state === state) return;
  node.dataset.state = state;
  node.textContent = STATES[state] ?? state;
}

// A bar of what is done, the failed part of it marked.
export class ProgressBar {
  constructor() {
    this.well = el("i", { class: "well" });
    this.bad = el("i", { class: "failed" });
    this.node = el("div", { class: "bar", role: "progressbar", "aria-valuemin": "0", "aria-valuemax": "100" }, this.well, this.bad);
  }

  show(job) {
    const { cases, done, failed } = job.progress;
    const part = (n) => `${cases > 0 ? (100 * n) / cases : 0}%`;
    this.well.style.width = part(done - failed);
    this.bad.style.width = part(failed);
    this.node.dataset.state = job.state;
    this.node.setAttribute("aria-label", `Progress of ${nameOf(job)}`);
    this.node.setAttribute("aria-valuenow", String(cases > 0 ? Math.floor((100 * done) / cases) : 0));
    this.node.setAttribute("aria-valuetext", `${done} of ${cases} cases done, ${failed} failed`);
  }
}
