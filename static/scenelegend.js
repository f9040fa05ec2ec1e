// What the scene's marks stand for, with their numbers: forces, moments, centres, and the colours of the path.

import { showInScene } from "./api.js";
import { $, el, setText } from "./dom.js";
import { fixed } from "./format.js";
import { gradientOf, pathLegend } from "./pathlegend.js";
import { centerOffset } from "./scene.js";
import { at, extent, locate } from "./series.js";
import { scaleOf } from "./units.js";

const FORCES = { "net_buoyancy": "N", lift: "N", drag: "N", side_force: "N" };
const MOMENTS = ["hydro_K", "moment", "hydro_N"];
const MOMENT_UNIT = "N m";
const NOTHING = 1e-9; // N or N m: a force that small is a rounding error
const FOLDED = "glider-studio.legend-folded";
const LOW_SCENE = 420; // px: below, a row for each mark would reach down to the glider

// A column in one unit and with as many digits as its range asks for, while the run lasts.
const scales = (columns) => Object.fromEntries([...Object.keys(FORCES), ...MOMENTS].filter((key) => columns[key])
  .map((key) => [key, scaleOf(FORCES[key] ?? MOMENT_UNIT, ...extent(columns[key]), { noise: noiseOf(extent(columns[key])) })]));
const noiseOf = ([low, high]) => NOTHING / Math.max(Math.abs(low), Math.abs(high), NOTHING);

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

// The bar from low to high.
function showColors(scene, shown) {
  const { path, quantities, color_by: chosen } = scene;
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
  const { low, high, unit, colors } = pathLegend(scene);
  $("path-bar").style.background = gradientOf(colors);
  setText($("path-low"), low);
  setText($("path-high"), high);
  setText($("path-unit"), unit);
}

function remembered() {
  const kept = localStorage.getItem(FOLDED);
  return kept === null ? null : kept === "true";
}

// Folded, the legend is one row of names. It begins so where it would cover the glider, until somebody chooses.
function connectFold() {
  const fold = (folded) => {
    $("forces").dataset.folded = String(folded);
    $("legend-fold").setAttribute("aria-expanded", String(!folded));
    $("legend-fold").title = folded ? "Show the numbers" : "Show the names alone, in one row";
  };
  const scene = document.querySelector(".scene");
  new ResizeObserver(() => fold(remembered() ?? scene.clientHeight < LOW_SCENE)).observe(scene);
  $("legend-fold").addEventListener("click", () => {
    const folded = $("forces").dataset.folded !== "true";
    localStorage.setItem(FOLDED, String(folded));
    fold(folded);
  });
}

export function connectLegend({ store, clock, actions }) {
  let scaleOfColumn = {};
  connectFold();
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
