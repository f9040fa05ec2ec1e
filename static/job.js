// A job's page: one state, and the views that follow it. Charts and table show the same cases and share their filter.

import { $, el, setText } from "./dom.js";
import { caseDesign, caseInStudio, getHealth, getJob, getSummary } from "./jobapi.js";
import { latestWins } from "./api.js";
import { MOST_CASES, isPart, loadTable } from "./jobdata.js";
import { watchJob } from "./jobevents.js";
import { connectActions, connectDownloads, showFailures, showHead, showProblem } from "./jobhead.js";
import { Histogram } from "./jobhistogram.js";
import { Paths, tellingCases } from "./jobpaths.js";
import { MOST_SELECTED, loadPlots, slotColor } from "./jobplots.js";
import { Scatter } from "./jobscatter.js";
import { showSelected } from "./jobselected.js";
import { CaseList } from "./jobtable.js";
import { showCorrelations, showIndices } from "./jobtables.js";
import { isOver, whole } from "./jobwords.js";
import { Parallel, connectAxisMenu } from "./parallel.js";
import { createStore } from "./store.js";
import { onScheme } from "./theme.js";

const EVERY = 2000; // ms between looks at the results of a job that runs
const SHARE = 5; // of the time, at most one part in so many is spent fetching them
const REDRAW = 150; // ms of quiet after a change of size

const id = decodeURIComponent(/\/jobs\/([^/]+)\/?$/.exec(location.pathname)[1]);
const store = createStore({
  job: null, table: null, summary: null, selected: [], axes: null, metric: null, plots: false,
  status: "", group: null, brushes: new Map(), passing: null, sizes: 0,
});
const { get, set } = store;

function onBrush(name, range) {
  const brushes = new Map(get("brushes"));
  if (range) brushes.set(name, range);
  else brushes.delete(name);
  set({ brushes });
}

function onSelect(n) {
  const selected = get("selected");
  if (selected.some((s) => s.n === n)) return set({ selected: selected.filter((s) => s.n !== n) });
  const kept = selected.length < MOST_SELECTED ? selected : selected.slice(1);
  const slot = [...Array(MOST_SELECTED).keys()].find((k) => !kept.some((s) => s.slot === k));
  set({ selected: [...kept, { n, slot }] });
}

const scatter = new Scatter($("scatter"), { onSelect });
const histogram = new Histogram($("histogram"), { onBrush });
const parallel = new Parallel($("parallel"), { onBrush });
const showAxisMenu = connectAxisMenu(parallel, () => set({ sizes: get("sizes") + 1 }));
const paths = new Paths($("paths"), { id, onChange: () => set({ sizes: get("sizes") + 1 }) });
const list = new CaseList({ onSelect });
const links = { studio: (n) => caseInStudio(id, n), design: (n) => caseDesign(id, n), drop: onSelect, group: (group) => set({ group, status: "" }) };

// What is drawn first: the first parameter and the first metric, coloured by the second of either.
function chooseAxes(table) {
  const names = table.axes.map(({ name }) => name);
  const kept = get("axes");
  if (kept && [kept.x, kept.y].every((name) => names.includes(name)) && (kept.color === null || names.includes(kept.color))) return kept;
  const [parameters, metrics] = ["parameter", "metric"].map((role) => table.axes.filter((a) => a.role === role).map(({ name }) => name));
  const [x, y] = [parameters[0] ?? metrics[0], metrics.find((name) => name !== (parameters[0] ?? metrics[0])) ?? metrics[0] ?? parameters[1] ?? parameters[0]];
  return names.length < 2 ? null : { x, y, color: [...parameters, ...metrics].find((name) => name !== x && name !== y) ?? null };
}

const options = (table, names) => names.map((name) => el("option", { value: name }, table.words(name)));

function fillSelects(table) {
  const names = table.axes.map(({ name }) => name);
  const metrics = table.axes.filter(({ role }) => role === "metric").map(({ name }) => name);
  const key = names.join("\n");
  if ($("axis-x").dataset.names !== key) {
    $("axis-x").dataset.names = key;
    for (const axis of ["x", "y"]) $(`axis-${axis}`).replaceChildren(...options(table, names));
    $("axis-color").replaceChildren(el("option", { value: "" }, "one colour"), ...options(table, names));
    $("metric").replaceChildren(...options(table, metrics));
  }
  const axes = get("axes");
  if (axes) for (const axis of ["x", "y", "color"]) $(`axis-${axis}`).value = axes[axis] ?? "";
  if (get("metric")) $("metric").value = get("metric");
}

function takeTable(table) {
  const axes = chooseAxes(table);
  const metrics = table.axes.filter(({ role }) => role === "metric").map(({ name }) => name);
  const metric = metrics.includes(get("metric")) ? get("metric") : (axes && metrics.includes(axes.y) ? axes.y : metrics[0]) ?? null;
  const selected = table.size === 1 && get("selected").length === 0 ? [{ n: table.cases[0], slot: 0 }] : get("selected");
  set({ table, axes, metric, selected, passing: table.passing({ status: get("status"), group: get("group"), brushes: get("brushes") }) });
}

let fetchedAt = null; // cases done, and state, when the results were last fetched
let lost = false; // whether the page says that the results could not be fetched
let pause = EVERY;
let timer = null;

const load = latestWins(async () => {
  const job = get("job");
  const key = `${job.progress.done} ${job.state}`;
  if (key === fetchedAt || job.progress.done === 0) return;
  fetchedAt = key;
  const began = performance.now();
  try {
    await loadTable(job, takeTable);
    set({ summary: await getSummary(id) });
    if (lost) showProblem(null);
    lost = false;
  } catch (error) {
    fetchedAt = null;
    lost = true;
    showProblem(error.problem ?? { title: error.message });
    if (error.problem?.unreachable) loadLater();
  }
  pause = Math.max(EVERY, SHARE * (performance.now() - began));
});

// A job beyond what is shown whole does not change in its first cases: they are fetched while they come, then no more.
function loadSoon() {
  const { progress } = get("job");
  const full = get("table")?.size >= MOST_CASES && progress.cases > MOST_CASES;
  if (!full) loadLater();
}

function loadLater() {
  timer ??= setTimeout(() => {
    timer = null;
    load();
  }, pause);
}

let stop = null;

function onJob(job) {
  const before = get("job");
  set({ job });
  if (!before || (isOver(job) && !isOver(before))) load();
  else if (!isOver(job)) loadSoon();
}

function follow() {
  stop?.();
  stop = watchJob(id, { onJob, onGone: showGone, onLinked });
}

function onLinked(linked) {
  const over = get("job") && isOver(get("job"));
  $("status").hidden = Boolean(over);
  $("status").dataset.state = linked ? "ready" : "offline";
  setText($("status"), linked ? "Live" : "Connection lost, retrying…");
}

function showGone() {
  for (const part of ["content", "opening", "status", "state", "downloads", "actions"]) $(part).hidden = true;
  $("gone").hidden = false;
  document.title = "No such job · Glider studio";
  setText($("name"), "No such job");
  setText($("gone-id"), id);
}

const ask = connectActions(() => get("job"), {
  onJob(job) {
    paths.forget();
    fetchedAt = null;
    onJob(job);
    follow(); // one that was over moves again
  },
  onDeleted: () => location.assign("../jobs"),
});

function showCounts({ table, job, passing }) {
  const shown = passing.reduce((sum, v) => sum + v, 0);
  const all = isPart(table, job) ? `the first ${whole(table.size)} of ${whole(job.progress.done)} cases; the files hold all` : `${whole(table.size)} ${table.size === 1 ? "case" : "cases"}`;
  setText($("shown"), shown === table.size ? all : `${whole(shown)} of ${all}`);
  $("unfilter").hidden = shown === table.size && !get("group") && !get("status") && get("brushes").size === 0;
}

// In a grid the first cases are a corner of the study: every panel that shows them alone must not look like all.
function showPart({ table, job }) {
  const some = isPart(table, job);
  $("part-of-all").hidden = !some;
  if (some) setText($("part-of-all"), `Charts and table show the first ${whole(table.size)} of ${whole(job.progress.done)} cases, which in a grid are one corner of it. Correlations and indices are of all, as are the files.`);
}

function showSections({ table, axes }) {
  $("results").hidden = false;
  $("many").hidden = table.size < 2 || axes === null;
  $("parallel-panel").hidden = table.size < 2 || table.axes.length < 2;
  document.body.dataset.cases = table.size;
}

async function tellWaiting(job) {
  if (isOver(job)) return setText($("waiting"), "No case was computed.");
  setText($("waiting"), "No case is done yet: the first results come here by themselves.");
  const compiling = (await getHealth().catch(() => null))?.kernel === "compiling";
  if (compiling && get("job").progress.done === 0) setText($("waiting"), "The physics is being compiled, which a machine's first start takes a few minutes for; the cases are computed after that.");
}

function connectViews() {
  store.watch(["job", "group"], ({ job, group }) => {
    if (!job) return;
    $("opening").hidden = true;
    $("content").hidden = false;
    showHead(job, { ask });
    showFailures(job, { group, pick: (reason) => set({ group: reason, status: "" }) });
    $("waiting").hidden = job.progress.done > 0;
    if (job.progress.done === 0) tellWaiting(job);
  });
  store.watch(["status", "group", "brushes"], ({ table, status, group, brushes }) => {
    if (table) set({ passing: table.passing({ status, group, brushes }) });
    $("filter-status").value = group ? "failed" : status;
  });
  store.watch(["table", "passing", "selected", "axes"], (values) => {
    if (!values.table) return;
    showSections(values);
    fillSelects(values.table);
    showCounts(values);
    showPart(values);
    list.show({ ...values, filterKey: `${values.status}|${values.group}|${JSON.stringify([...values.brushes])}` });
  });
  store.watch(["table", "passing", "selected", "axes", "sizes"], (values) => {
    if (!values.table || $("parallel-panel").hidden || !values.axes) return;
    parallel.show({ ...values, slotColor });
    showAxisMenu(values.table, values.axes);
  });
  store.watch(["table", "summary", "axes"], (values) => {
    if (!values.table) return;
    showCorrelations({ ...values, axes: values.axes ?? {}, onPick: (x, y) => set({ axes: { ...values.axes, x, y } }) });
    showIndices(values);
  });
  store.watch(["table", "selected", "sizes"], (values) => values.table && showSelected({ ...values, paths, links }));
  connectPlots();
}

function connectPlots() {
  const ready = ({ plots, table }) => plots && table !== null;
  store.watch(["plots", "table", "passing", "selected", "axes", "sizes"], (values) => ready(values) && values.axes && !$("many").hidden && scatter.show(values));
  store.watch(["plots", "table", "passing", "summary", "metric", "sizes"], (values) => ready(values) && values.metric && !$("many").hidden && histogram.show(values));
  store.watch(["plots", "table", "selected", "sizes"], (values) => ready(values) && paths.show(values));
  let asked = false;
  store.watch(["table"], async ({ table }) => {
    if (!table || asked) return;
    asked = true;
    try {
      await loadPlots();
      set({ plots: true });
    } catch (error) {
      asked = false;
      showProblem({ title: "The charts cannot be drawn", detail: `${error.message}; the tables hold the same numbers.` });
    }
  });
}

function connectControls() {
  for (const axis of ["x", "y", "color"]) $(`axis-${axis}`).addEventListener("change", () => set({ axes: { ...get("axes"), [axis]: $(`axis-${axis}`).value || null } }));
  $("metric").addEventListener("change", () => set({ metric: $("metric").value }));
  $("filter-status").addEventListener("change", () => set({ status: $("filter-status").value, group: null }));
  $("unfilter").addEventListener("click", () => set({ status: "", group: null, brushes: new Map() }));
  $("clear-selected").addEventListener("click", () => set({ selected: [] }));
  $("index-metric").addEventListener("change", () => showIndices({ table: get("table"), summary: get("summary") }));
  for (const radio of document.querySelectorAll("[name=correlation]")) radio.addEventListener("change", () => set({ axes: get("axes") && { ...get("axes") } }));
  for (const radio of document.querySelectorAll("[name=path-view]")) radio.addEventListener("change", () => set({ sizes: get("sizes") + 1 }));
  $("show-telling").addEventListener("click", () => tellingCases({ table: get("table"), passing: get("passing"), metric: get("metric") }).forEach(onSelect));
  let quiet = null;
  const redraw = () => {
    clearTimeout(quiet);
    quiet = setTimeout(() => set({ sizes: get("sizes") + 1 }), REDRAW);
  };
  addEventListener("resize", redraw);
  onScheme(redraw);
}

async function start() {
  connectDownloads(id);
  connectControls();
  connectViews();
  try {
    onJob(await getJob(id));
  } catch (error) {
    if (error.problem?.status === 404) return showGone();
    showProblem(error.problem ?? { title: error.message });
  }
  if (!get("job") || !isOver(get("job"))) follow();
  else $("status").hidden = true;
}

// What the page shows, for tests.
window.__job = { get, pointAt: (n) => scatter.pointAt(n) };
start();
