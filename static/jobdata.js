// The case table of a job as the page holds it: columns of numbers in SI, with their names and scales for people.

import { getCases, getResults } from "./jobapi.js";
import { scaleOf } from "./units.js";

export const MOST_CASES = 20_000;
const FINE = ["completed", "surface", "bed"];
const NAMED = ["crashed", "refused"]; // failures whose reason says more than their status
const PAGES_A_PART = 4;
const NOISE = 1e-8; // of a metric's largest value: about a solver's tolerance
const WIDE = 1e4;

// Whether a table holds but the first cases of a job.
export const isPart = (table, { progress }) => table.size < progress.done && progress.cases > MOST_CASES;

export const isFine = (status) => FINE.includes(status);

// As the server groups them: the reason without its numbers.
function groupOf(status, reason) {
  if (isFine(status)) return null;
  return NAMED.includes(status) ? `${status}: ${(reason ?? "").replace(/-?\d+(\.\d+)?([eE][-+]?\d+)?/g, "…")}`.slice(0, 400) : status;
}

const inWords = (name) => (/^[a-z0-9_]+$/.test(name) ? `${name[0].toUpperCase()}${name.slice(1).replaceAll("_", " ")}` : name);

export class CaseTable {
  constructor(job, columns) {
    this.cases = columns.case;
    this.status = columns.status;
    this.reason = columns.reason;
    this.group = this.status.map((status, i) => groupOf(status, this.reason[i]));
    this.rows = new Map(this.cases.map((n, i) => [n, i]));
    const parameters = job.parameters.map((p) => ({ ...p, role: "parameter", meaning: p.pointer }));
    this.infos = [...parameters, ...job.metrics.map((m) => ({ ...m, role: "metric" }))].filter(({ name }) => columns[name]);
    this.info = new Map(this.infos.map((info) => [info.name, info]));
    this.values = new Map();
    this.texts = new Map();
    for (const info of this.infos) this.keep(info, columns[info.name]);
    this.scales = new Map();
  }

  // A parameter whose values are no numbers is shown, but has no axis.
  keep(info, column) {
    info.numeric = info.role === "metric" || column.every((v) => v === null || typeof v === "number");
    if (info.numeric) this.values.set(info.name, Float64Array.from(column, (v) => (v === null ? NaN : v)));
    else this.texts.set(info.name, column);
  }

  get size() {
    return this.cases.length;
  }

  // Columns with an axis: those that have a number at all.
  get axes() {
    return this.infos.filter(({ name, numeric }) => numeric && this.bounds(name) !== null);
  }

  bounds(name) {
    let [low, high] = [Infinity, -Infinity];
    for (const v of this.values.get(name)) {
      if (v < low) low = v;
      if (v > high) high = v;
    }
    return low <= high ? [low, high] : null;
  }

  scale(name) {
    const { unit, role } = this.info.get(name);
    if (!this.scales.has(name)) this.scales.set(name, scaleOf(unit, ...(this.bounds(name) ?? [1, 1]), { noise: role === "metric" ? NOISE : 0 }));
    return this.scales.get(name);
  }

  // Whether a column goes over so many powers of ten that an axis in proportion would put most of it into one place.
  isWide(name) {
    const [low, high] = this.bounds(name);
    return low > 0 && high / low >= WIDE;
  }

  words(name) {
    return inWords(name);
  }

  // Name and unit, as an axis says them.
  label(name) {
    const { symbol } = this.scale(name);
    return symbol ? `${inWords(name)}, ${symbol}` : inWords(name);
  }

  text(name, row) {
    const info = this.info.get(name);
    return info.numeric ? this.scale(name).show(this.values.get(name)[row]) : JSON.stringify(this.texts.get(name)[row]);
  }

  textWithUnit(name, row) {
    return this.info.get(name).numeric ? this.scale(name).withUnit(this.values.get(name)[row]) : this.text(name, row);
  }

  // Whether a case was simulated at all, so that it may have a path.
  ran(n) {
    return this.rows.has(n) && !NAMED.includes(this.status[this.rows.get(n)]);
  }

  // The case that went well whose parameters are nearest to a row's, each measured by its range; null where none did.
  nearestFine(row) {
    const spans = this.infos.filter(({ role, numeric }) => role === "parameter" && numeric).map(({ name }) => [this.values.get(name), this.bounds(name)]);
    let [nearest, least] = [null, Infinity];
    for (let i = 0; i < this.size; i += 1) {
      if (this.group[i] !== null) continue;
      const away = spans.reduce((sum, [values, bounds]) => sum + (bounds && bounds[1] > bounds[0] ? ((values[i] - values[row]) / (bounds[1] - bounds[0])) ** 2 : 0), 0);
      if (away < least) [nearest, least] = [this.cases[i], away];
    }
    return nearest;
  }

  // Which rows pass: by status, by the failure's reason, and by the brushes on the axes.
  passing({ status, group, brushes }) {
    const found = new Uint8Array(this.size);
    const ranges = [...brushes].filter(([name]) => this.values.has(name)).map(([name, range]) => [this.values.get(name), ...range]);
    for (let i = 0; i < this.size; i += 1) {
      const fine = this.group[i] === null;
      const wanted = (!group || this.group[i] === group) && (status === "" || fine === (status === "fine"));
      found[i] = wanted && ranges.every(([values, low, high]) => values[i] >= low && values[i] <= high) ? 1 : 0;
    }
    return found;
  }
}

function columnsOf(items, job) {
  const columns = { case: items.map((c) => c.case), status: items.map((c) => c.status), reason: items.map((c) => c.reason) };
  for (const { name } of job.parameters) columns[name] = items.map((c) => c.parameters[name] ?? null);
  for (const { name } of job.metrics) columns[name] = items.map((c) => c.metrics[name] ?? null);
  return columns;
}

// The whole table where it is small; else its first cases, page by page, with what has come so far in between.
export async function loadTable(job, onPart) {
  if (job.progress.cases <= MOST_CASES) return onPart(new CaseTable(job, (await getResults(job.id)).columns));
  const items = [];
  let cursor = null;
  for (let pages = 1; items.length < MOST_CASES; pages += 1) {
    const page = await getCases(job.id, cursor);
    items.push(...page.items);
    cursor = page.next;
    if (cursor === null) break;
    if (pages % PAGES_A_PART === 0) onPart(new CaseTable(job, columnsOf(items, job)));
  }
  onPart(new CaseTable(job, columnsOf(items.slice(0, MOST_CASES), job)));
}
