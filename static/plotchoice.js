// Which outputs each plot shows, and in what range: chosen once, remembered for planar and for spatial runs.

const KEY = "glider-studio.plots";
export const MOST_PLOTS = 8;
export const MOST_OUTPUTS = 8; // of one plot
const FIRST = {
  planar: [["z"], ["theta", "flow_angle", "alpha"]],
  spatial: [["z"], ["theta", "phi", "alpha", "heading"]],
};

export const emptyPlot = (outputs = []) => ({ outputs, ranges: { left: null, right: null } });
export const firstPlots = (model) => FIRST[model].map((outputs) => emptyPlot(outputs));

const isRange = (range) => range === null || (Array.isArray(range) && range.length === 2 && range.every(Number.isFinite) && range[0] < range[1]);
const isPlot = (plot) => Array.isArray(plot?.outputs) && plot.outputs.every((name) => typeof name === "string") && isRange(plot.ranges?.left) && isRange(plot.ranges?.right);

function readAll() {
  try {
    return JSON.parse(localStorage.getItem(KEY) ?? "{}") ?? {};
  } catch {
    return {};
  }
}

export function readPlots(model) {
  const kept = readAll()[model];
  return Array.isArray(kept) && kept.every(isPlot) ? kept.slice(0, MOST_PLOTS) : firstPlots(model);
}

export function writePlots(model, plots) {
  try {
    localStorage.setItem(KEY, JSON.stringify({ ...readAll(), [model]: plots }));
  } catch {
    // Held by this page alone where the browser keeps nothing.
  }
}

export const moved = (plots, k, by) => {
  const to = Math.min(Math.max(k + by, 0), plots.length - 1);
  const rest = plots.filter((_, each) => each !== k);
  return [...rest.slice(0, to), plots[k], ...rest.slice(to)];
};
