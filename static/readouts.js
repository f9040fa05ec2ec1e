// The right column: what the design and its glide amount to, in numbers.

import { $, el, setText } from "./dom.js";
import { NONE, clockText, fixed } from "./format.js";
import { BALANCE, END, NOW, NUMERICS, TITLES } from "./readoutrows.js";
import { at, locate } from "./series.js";

function fillTable(table, rows) {
  return rows.map(([id, label, unit, show, read, model]) => {
    const node = el("span", { class: "value", id: `readout-${id}`, "data-testid": `readout-${id}` }, NONE);
    const unitNode = el("span", { class: "unit" }, unit);
    const root = el("div", { title: TITLES[id] }, el("dt", {}, label), el("dd", {}, node, unitNode));
    table.append(root);
    return { unit, show, read, model, node, unitNode, root };
  });
}

function write({ node, unitNode, show, unit }, value) {
  const known = value != null && Number.isFinite(value);
  const [text, itsUnit] = [known ? show(value) : NONE].flat();
  setText(node, text);
  setText(unitNode, itsUnit ?? unit);
  // The plain SI number beside the rounded text, for scripts that read the page.
  if (known) node.dataset.value = String(value);
  else delete node.dataset.value;
}

export function connectReadouts({ store, clock }) {
  const nowRows = fillTable($("now"), NOW);
  const others = [...fillTable($("balance"), BALANCE), ...fillTable($("end"), END), ...fillTable($("numerics"), NUMERICS)];
  const showNow = () => {
    const run = store.get("state")?.run;
    const place = run ? locate(run.columns.t, clock.t) : null;
    setText($("now-title"), `Now, at ${clockText(clock.t, clock.end)}`);
    for (const item of nowRows) if (!item.root.hidden) write(item, run ? item.read(run, place) : undefined);
    setText($("scene-depth"), run ? `depth ${fixed(at(run.columns.z, place), 3)} m` : "");
  };
  store.watch(["state"], ({ state }) => {
    if (!state) return;
    const model = state.run?.model ?? state.model;
    document.querySelector(".results").classList.toggle("dense", model === "spatial");
    for (const item of [...nowRows, ...others]) item.root.hidden = Boolean(item.model) && item.model !== model;
    for (const item of others) if (!item.root.hidden) write(item, item.read(state));
    setText($("end-message"), state.run?.message ?? "");
    showNow();
  });
  clock.watch(showNow);
}
