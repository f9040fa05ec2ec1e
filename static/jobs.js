// The list of jobs: the newest first, live, filtered by the server; older ones a page at a time.

import { $, el, setText } from "./dom.js";
import { act } from "./jobactions.js";
import { listJobs } from "./jobapi.js";
import { Streams } from "./jobevents.js";
import { showExamples } from "./jobexamples.js";
import { connectKeys } from "./jobkeys.js";
import { JobRow } from "./jobrow.js";
import { KINDS, STATES, isMoving, nameOf, whole } from "./jobwords.js";
import { connectNewJob } from "./newjob.js";
import { problemNodes } from "./problem.js";

const A_PAGE = 50;
const STREAMS = 3; // of the six connections that a browser opens to one host
const SOON = 3000; // ms between looks while something moves that no stream tells of
const LATER = 10_000;
const TYPING = 250; // ms after the last key

const rows = new Map();
const filters = { search: "", state: "", kind: "" };
const streams = new Streams(STREAMS, { onJob: take, onGone: (id) => remove(id) });
let next = null; // cursor of the older ones
let asked = 0; // of several answers only that to the last question counts
let timer = null;

const isFiltered = () => Object.values(filters).some(Boolean);
const ordered = () => [...rows.values()].sort((a, b) => b.job.created.localeCompare(a.job.created) || b.job.id.localeCompare(a.job.id));

function showProblem(problem) {
  $("problem").hidden = problem === null;
  $("problem").replaceChildren(...(problem ? problemNodes(problem) : []));
}

// Rows move only where the order has changed.
function place() {
  let before = $("rows").firstElementChild;
  for (const { node } of ordered()) {
    if (node === before) before = before.nextElementSibling;
    else $("rows").insertBefore(node, before);
  }
}

function take(job) {
  const row = rows.get(job.id);
  if (row) row.show(job);
  else rows.set(job.id, new JobRow(job, { onAction }));
  if (!row) place();
  follow();
}

function remove(id) {
  const row = rows.get(id);
  if (!row) return;
  const held = row.node.contains(document.activeElement);
  const neighbour = row.node.nextElementSibling ?? row.node.previousElementSibling;
  row.node.remove();
  rows.delete(id);
  if (held && neighbour) rows.get(neighbour.dataset.id)?.focus();
  follow();
  showCount();
}

function follow() {
  const moving = ordered().filter(({ job }) => isMoving(job));
  const running = [...moving.filter(({ job }) => job.state !== "queued"), ...moving.filter(({ job }) => job.state === "queued")];
  streams.follow(running.map(({ job }) => job.id));
}

function showCount() {
  const [count, none] = [rows.size, rows.size === 0];
  $("jobs").hidden = none;
  $("jobs").setAttribute("aria-busy", "false");
  $("older").hidden = next === null;
  $("empty").hidden = !none || isFiltered();
  $("clear").hidden = !isFiltered();
  setText($("count"), none ? "" : `${whole(count)}${next ? " newest" : ""} ${count === 1 ? "job" : "jobs"}${isFiltered() ? " found" : ""}`);
  $("note").hidden = !none || !isFiltered();
  if (none && isFiltered()) $("note").replaceChildren("No job is like that.", el("button", { class: "btn", type: "button", onclick: clear }, "Show all jobs"));
}

// What the first page should hold and does not is gone.
function dropGone({ items, next: following }) {
  const kept = new Set(items.map(({ id }) => id));
  const last = items.at(-1)?.created ?? "";
  for (const { job } of [...rows.values()]) {
    if (!kept.has(job.id) && (!following || job.created >= last)) remove(job.id);
  }
}

async function load({ anew = false } = {}) {
  const mine = (asked += 1);
  clearTimeout(timer);
  try {
    const page = await listJobs({ ...filters, limit: A_PAGE });
    if (mine !== asked) return;
    if (anew) clearRows();
    dropGone(page);
    page.items.forEach(take);
    if (anew || rows.size <= page.items.length) next = page.next;
    setStatus("ready");
    showCount();
  } catch (error) {
    if (mine !== asked) return;
    setStatus("offline", error.problem?.status ? "The server has a problem, retrying…" : "Connection lost, retrying…");
    if (rows.size === 0) showLoadProblem(error.problem ?? { title: error.message });
  }
  later();
}

function showLoadProblem(problem) {
  const retry = el("button", { class: "btn", type: "button", onclick: () => load({ anew: true }) }, "Try again");
  $("note").hidden = false;
  $("note").replaceChildren(`The jobs could not be loaded: ${problem.detail ?? problem.title}`, retry);
}

function clearRows() {
  for (const { node } of rows.values()) node.remove();
  rows.clear();
}

function later() {
  clearTimeout(timer);
  if (document.visibilityState === "hidden") return;
  const unheard = [...rows.values()].filter(({ job }) => isMoving(job)).length > STREAMS;
  timer = setTimeout(load, unheard || $("status").dataset.state === "offline" ? SOON : LATER);
}

async function loadOlder() {
  $("older").disabled = true;
  const mine = asked;
  try {
    const page = await listJobs({ ...filters, limit: A_PAGE, cursor: next });
    if (mine !== asked) return;
    next = page.next;
    page.items.forEach(take);
    rows.get(page.items[0]?.id)?.focus();
    showCount();
  } catch (error) {
    showProblem(error.problem ?? { title: error.message });
  } finally {
    $("older").disabled = false;
  }
}

function setStatus(state, text = "Live") {
  $("status").dataset.state = state;
  setText($("status"), text);
}

async function onAction(job, verb) {
  showProblem(null);
  try {
    const answer = await act(job, verb);
    if (answer === null) remove(job.id);
    else if (answer) take(answer);
    if (answer) later();
  } catch (error) {
    showProblem({ ...(error.problem ?? {}), title: `${nameOf(job)}: ${error.message}` });
    load();
  }
}

function applyFilters() {
  const given = Object.entries(filters).filter(([, value]) => value);
  history.replaceState(null, "", given.length ? `?${new URLSearchParams(given)}` : location.pathname);
  load({ anew: true });
}

function clear() {
  for (const name of Object.keys(filters)) $(name).value = filters[name] = "";
  applyFilters();
  $("search").focus();
}

function connectFilters() {
  for (const [id, names] of [["state", STATES], ["kind", KINDS]]) {
    $(id).append(...Object.entries(names).map(([value, name]) => el("option", { value }, name)));
    $(id).addEventListener("change", () => ((filters[id] = $(id).value), applyFilters()));
  }
  for (const [name, value] of new URLSearchParams(location.search)) {
    if (!(name in filters)) continue;
    $(name).value = value;
    filters[name] = $(name).value;
  }
  let typing = null;
  $("search").addEventListener("input", () => {
    clearTimeout(typing);
    typing = setTimeout(() => ((filters.search = $("search").value.trim()), applyFilters()), TYPING);
  });
  $("filters").addEventListener("submit", (event) => event.preventDefault());
  $("clear").addEventListener("click", clear);
}

connectFilters();
connectNewJob();
showExamples();
connectKeys({ rows: () => ordered(), onAction });
$("older").addEventListener("click", loadOlder);
document.addEventListener("visibilitychange", () => (document.visibilityState === "hidden" ? clearTimeout(timer) : load()));
load({ anew: true });
