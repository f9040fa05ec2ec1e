// What the scene's marks stand for, with their numbers: forces, moments, centres, and the colours of the path.

import { showInScene } from "./api.js";
import { $, el, setText } from "./dom.js";
import { NONE, fixed } from "./format.js";
import { centerOffset } from "./scene.js";
import { at, extent, locate } from "./series.js";
import { scaleOf } from "./units.js";

const FORCES = { "net_buoyancy": "N", lift: "N", drag: "N", side_force: "N" };
const MOMENTS = ["hydro_K", "moment", "hydro_N"];
const MOMENT_UNIT = "N m";

// A column in one unit and with as many digits as its range asks for, while the run lasts.
const scales = (columns) => Object.fromEntries([...Object.keys(FORCES), ...MOMENTS].filter((key) => columns[key])
  .map((key) => [key, scaleOf(FORCES[key] ?? MOMENT_UNIT, ...extent(columns[key]))]));

const millimetres = (v) => fixed(1e3 * v, 2);

function showNumbers(run, view, clock, scaleOfColumn) {
  const place = locate(run.columns.t, clock.t);
  for (const [keys, on] of [[Object.keys(FORCES), view.forces], [MOMENTS, view.moments]]) {
    for (const key of keys) {
      const row = $(`legend-${key}`);
      row.hidden = !on || !scaleOfColumn[key];
      if (!row.hidden) setText($(`force-${key}`), scaleOfColumn[key].withUnit(at(run.columns[key], place)));
    }
  }
  $("legend-centers").hidden = !view.centers || !run.columns.com_x;
  if ($("legend-centers").hidden) return;
  const { offset } = centerOffset(run.columns, place);
  setText($("center-offset"), `${millimetres(Math.hypot(...offset))} mm`);
  setText($("center-scale"), view.offset === 1 ? "" : `drawn ×${view.offset}`);
  $("legend-centers").title = `Centre of mass from that of buoyancy: x ${millimetres(offset[0])}, y ${millimetres(offset[1])}, z ${millimetres(offset[2])} mm (z down)`;
}

// The bar from low to high. What lies beyond the scale has the colour of its end, and the end's number says so.
function showColors({ path, path_colors: colors, quantities, color_by: chosen }, shown) {
  $("path-legend").hidden = !shown || quantities.length === 0;
  const options = [{ name: "none", label: "one colour" }, ...quantities];
  const select = $("color-by");
  if (select.dataset.names !== options.map(({ name }) => name).join()) {
    select.dataset.names = options.map(({ name }) => name).join();
    select.replaceChildren(...options.map(({ name, label }) => el("option", { value: name }, `Path: ${label.toLowerCase()}`)));
  }
  if (document.activeElement !== select) select.value = chosen;
  $("path-scale").hidden = path === null;
  if (path === null) return;
  const scale = scaleOf(path.unit, path.low, path.high);
  $("path-bar").style.background = `linear-gradient(90deg, ${colors.join(", ")})`;
  setText($("path-low"), `${path.below ? "≤ " : ""}${scale.brief(path.low)}`);
  setText($("path-high"), `${path.above ? "≥ " : ""}${scale.brief(path.high)}`);
  setText($("path-unit"), scale.symbol || (path.unit === "1" ? "" : NONE));
}

export function connectLegend({ store, clock, actions }) {
  let scaleOfColumn = {};
  const numbers = () => {
    const run = store.get("state")?.run;
    $("forces").hidden = !run || !["forces", "moments", "centers"].some((key) => store.get("view")[key]);
    if (!$("forces").hidden) showNumbers(run, store.get("view"), clock, scaleOfColumn);
  };
  $("color-by").addEventListener("change", () => {
    actions.act(() => showInScene({ color_by: $("color-by").value }));
    $("color-by").blur();
  });
  store.watch(["state"], ({ state }) => {
    scaleOfColumn = state?.run ? scales(state.run.columns) : {};
  });
  store.watch(["state", "view"], ({ state, view }) => {
    if (state) showColors(state.scene, view.path && Boolean(state.run));
    numbers();
  });
  clock.watch(numbers);
}
