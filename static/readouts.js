// The right column: what the design and its glide amount to, in numbers.

import { $, el, setText } from "./dom.js";
import { NONE, cubicCentimetres, degrees, fixed, grams, millimetres, scientific } from "./format.js";
import { angleAt, at, locate } from "./series.js";

const now = (key, read) => (run, place) => read(run.columns[key], place);

// [id, label, unit, how to write it, where it comes from]
const NOW = [
  ["pitch", "Pitch", "°", degrees, now("theta", angleAt)],
  ["attack", "Attack angle", "°", degrees, now("alpha", angleAt)],
  ["flow", "Flow angle", "°", degrees, now("flow_angle", angleAt)],
  ["speed", "Speed", "m/s", (v) => fixed(v, 3), now("speed", at)],
  ["depth", "Depth", "m", (v) => fixed(v, 3), now("z", at)],
  ["distance", "Distance", "m", (v) => fixed(v, 3), now("x", at)],
  ["net-buoyancy", "Net buoyancy", "N", (v) => fixed(v, 4), now("net_buoyancy", at)],
];

const BALANCE = [
  ["mass", "Mass", "g", grams, ({ mass }) => mass.mass],
  ["displaced-volume", "Displaced volume", "cm³", cubicCentimetres, ({ mass }) => mass.displaced_volume],
  ["start-net-buoyancy", "Net buoyancy, no command", "N", (v) => fixed(v, 4), ({ mass }) => mass.net_buoyancy],
  ["com-below-cob", "CoM below CoB", "mm", millimetres, ({ mass }) => mass.com_below_cob],
  ["com-x", "CoM x", "mm", millimetres, ({ mass }) => mass.center_of_mass?.[0]],
  ["cob-x", "CoB x", "mm", millimetres, ({ mass }) => mass.center_of_buoyancy?.[0]],
];

const last = (key) => ({ run }) => run?.columns[key]?.at(-1);

const END = [
  ["end-time", "Time", "s", (v) => fixed(v, 2), last("t")],
  ["end-x", "Distance x", "m", (v) => fixed(v, 3), last("x")],
  ["end-depth", "Depth", "m", (v) => fixed(v, 3), last("z")],
  ["end-pitch", "Pitch", "°", degrees, last("theta")],
];

const NUMERICS = [
  ["energy-residual", "Energy residual", "rel.", scientific, relativeResidual],
  ["elapsed", "Computed in", "ms", (v) => fixed(v, 1), ({ run }) => run?.elapsed_ms],
];

// What the label is too short to say.
const TITLES = {
  flow: "Direction of motion below the horizontal: atan2(ż, ẋ), positive down",
  attack: "Angle from the flow to the nose: flow angle + pitch",
  "start-net-buoyancy": "With every cell at its extension at start, before the first command",
  "energy-residual": "Left over in the energy balance at the end, as a share of the energy exchanged during the glide",
};

// Joules mean little on their own: the residual counts against the energy that went back and forth.
function relativeResidual({ run }) {
  if (!run) return undefined;
  return run.energy_exchanged > 0 ? run.energy_residual / run.energy_exchanged : run.energy_residual;
}

function fillTable(table, rows) {
  for (const [id, label, unit] of rows) {
    table.append(el("div", { title: TITLES[id] }, el("dt", {}, label),
      el("dd", {}, el("span", { class: "value", id: `readout-${id}`, "data-testid": `readout-${id}` }, NONE), el("span", { class: "unit" }, unit))));
  }
  return rows.map((row) => ({ row, node: $(`readout-${row[0]}`), table }));
}

function write({ row, node }, value) {
  const known = value != null && Number.isFinite(value);
  setText(node, known ? row[3](value) : NONE);
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
    setText($("now-title"), `Now, at ${fixed(clock.t, 1)} s`);
    for (const item of nowRows) write(item, run ? item.row[4](run, place) : undefined);
    setText($("scene-depth"), run ? `depth ${fixed(at(run.columns.z, place), 3)} m` : "");
  };
  store.watch(["state"], ({ state }) => {
    if (!state) return;
    for (const item of others) write(item, item.row[4](state));
    setText($("end-message"), state.run?.message ?? "");
    showNow();
  });
  clock.watch(showNow);
}
