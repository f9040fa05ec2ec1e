// The chart library: loaded when first needed, dressed in the page's own variables, without controls of its own.

import { cssColor } from "./plotcanvas.js";
import { ROOT } from "./root.js";

const ADDRESS = new URL("vendor/plotly.min.js", ROOT).href;
const FONT = '-apple-system, BlinkMacSystemFont, "Segoe UI", Roboto, "Helvetica Neue", Arial, sans-serif';
const CONFIG = { displayModeBar: false, responsive: false, doubleClick: "reset", showTips: false, displaylogo: false };
// The library brings the style of maps, which no chart here is: where this element is, it believes that it has done so.
const MAP_STYLE = "9f215cf04c5486422605d13261cb87401f4e7763b6296af81e98efbc0130da53";
const touches = matchMedia("(pointer: coarse)");

let loading = null;

export function loadPlots() {
  loading ??= new Promise((resolve, reject) => {
    const script = document.createElement("script");
    document.head.append(Object.assign(document.createElement("meta"), { id: MAP_STYLE }));
    script.src = ADDRESS;
    script.addEventListener("load", () => resolve(window.Plotly));
    script.addEventListener("error", () => {
      script.remove();
      loading = null; // asked for again at the next try
      reject(new Error("the chart library could not be loaded"));
    });
    document.head.append(script);
  });
  return loading;
}

export const COLOR_SCALE = () => [0, 1, 2, 3, 4].map((k) => [k / 4, cssColor(`--scale-${k}`)]);

// Colour and dash of a selected case's place among the selected: six colours, then the same dashed.
export const MOST_SELECTED = 12;
export const slotColor = (slot) => cssColor(`--series-${(slot % 6) + 1}`);
export const slotDash = (slot) => (slot < 6 ? "solid" : "dash");

// Names come from people's documents; the library reads tags in them.
export const plain = (text) => text.replaceAll("&", "&amp;").replaceAll("<", "&lt;").replaceAll(">", "&gt;");

// Exponents as plain text: raised ones would be inline styles, which the page forbids.
function axis(more) {
  const grid = cssColor("--grid");
  return {
    gridcolor: grid, zerolinecolor: grid, linecolor: grid, tickcolor: grid, automargin: true, exponentformat: "e",
    tickfont: { color: cssColor("--dim"), size: 11 }, ...more,
    title: { text: plain(more.title ?? ""), font: { color: cssColor("--dim"), size: 12 }, standoff: 8 },
  };
}

// A chart keeps to its box: panels beside each other change height as their contents come.
const fitting = new ResizeObserver((entries) => {
  for (const { target } of entries) fit(target);
});

function fit(box) {
  const { clientWidth: width, clientHeight: height } = box;
  const drawn = box.layout;
  if (drawn && width && height && (drawn.width !== width || drawn.height !== height)) window.Plotly.relayout(box, { width, height });
}

export function draw(box, traces, { x, y, ...more }) {
  const layout = {
    width: box.clientWidth, height: box.clientHeight, margin: { l: 12, r: 12, t: 10, b: 12 }, showlegend: false,
    paper_bgcolor: "rgba(0,0,0,0)", plot_bgcolor: cssColor("--plot-bg"), font: { family: FONT, size: 11, color: cssColor("--dim") },
    hoverlabel: { bgcolor: cssColor("--panel"), bordercolor: cssColor("--line"), font: { color: cssColor("--ink"), size: 11.5, family: FONT }, align: "left" },
    dragmode: touches.matches ? false : "zoom", xaxis: axis(x), yaxis: axis(y), ...more,
  };
  const drawn = window.Plotly.react(box, traces, layout, CONFIG);
  fitting.observe(box); // tells the present size too, once the page is laid out
  return drawn;
}
