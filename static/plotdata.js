// Where plots find their curves: in the State, else asked of the server, of the present run and of kept ones.

import { latestWins } from "./api.js";
import { CURRENT, columnsOf, getOutputs, isReady } from "./keptruns.js";
import { ofFlow } from "./series.js";

const FLOW = ["alpha", "beta", "flow_angle"]; // angles that a glider at rest has not

export class PlotData {
  // `onLoad` is called when curves have come that were not there.
  constructor(onLoad) {
    Object.assign(this, { onLoad, run: null, number: 0, fetched: null, kept: [], ofKept: new Map(), flow: new WeakMap(), outputs: null, outputsOf: null });
    this.fetch = latestWins((names, number) => this.load(names, number));
  }

  setState({ run, model, components, kept }) {
    Object.assign(this, { run, number: run?.number ?? 0, kept: (kept ?? []).filter(isReady) });
    // Other parts, other outputs.
    const parts = [model, ...components.map(({ name }) => name)].join("\n");
    if (parts !== this.outputsOf) Object.assign(this, { outputs: null, outputsOf: parts });
    for (const id of this.ofKept.keys()) if (!this.kept.some((each) => each.id === id)) this.ofKept.delete(id);
  }

  // {t, values, unit} of the present run, or null where it is not known (yet). What is asked for anew stays meanwhile.
  curve(name) {
    const own = this.run?.columns[name];
    if (own) return { t: this.run.columns.t, values: this.moving(name, this.run.columns), unit: this.run.units[name] };
    const [variable, cell] = name.split("@");
    const found = cell && this.run?.cells.find((each) => each.name === cell);
    if (found?.[variable]) return { t: this.run.columns.t, values: found[variable], unit: found.unit };
    const { answer } = this.fetched ?? {};
    return answer?.columns[name] ? { t: answer.t, values: answer.columns[name], unit: answer.units[name] } : null;
  }

  keptCurve(id, name) {
    const answer = this.ofKept.get(id);
    return answer?.columns[name] ? { t: answer.t, values: this.moving(name, answer.columns) } : null;
  }

  // Without the angles of the flow where there is none; worked out once for each column.
  moving(name, columns) {
    const values = columns[name];
    if (!FLOW.includes(name) || !columns.speed) return values;
    if (!this.flow.has(values)) this.flow.set(values, ofFlow(values, columns.speed));
    return this.flow.get(values);
  }

  // Asks for what is not in the State, once a run; and for kept runs all that is shown.
  need(names) {
    if (!this.run) return;
    const missing = names.filter((name) => !this.inState(name));
    const key = [this.number, ...missing].join("\n");
    if (missing.length && this.fetched?.key !== key && this.asked !== key) {
      this.asked = key;
      this.fetch(missing, this.number).catch(() => (this.asked = null));
    }
    for (const { id } of this.kept) this.needKept(id, names);
  }

  inState(name) {
    const [variable, cell] = name.split("@");
    return Boolean(cell ? this.run.cells.find((each) => each.name === cell)?.[variable] : this.run.columns[name]);
  }

  async load(names, number) {
    const answer = await columnsOf(CURRENT, names, number);
    this.fetched = { key: [number, ...names].join("\n"), answer };
    this.onLoad();
  }

  async needKept(id, names) {
    const held = this.ofKept.get(id);
    if (!names.length || names.every((name) => held?.asked.includes(name))) return;
    const asked = [...new Set([...(held?.asked ?? []), ...names, ...(names.some((name) => FLOW.includes(name)) ? ["speed"] : [])])];
    this.ofKept.set(id, { columns: {}, ...held, asked });
    try {
      const answer = await columnsOf(id, asked);
      if (this.ofKept.get(id)?.asked === asked) this.ofKept.set(id, { ...answer, asked });
      this.onLoad();
    } catch {
      this.ofKept.delete(id); // forgotten meanwhile: the next State says so
    }
  }

  async list() {
    this.outputs ??= (await getOutputs()).items;
    return this.outputs;
  }
}
