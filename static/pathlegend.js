// What the legend of a path's colours says: the same words beside the scene, in a picture of it and in a replay.

import { scaleOf, withUnit } from "./units.js";

// What lies beyond the scale has the colour of its end, and the end's number says so. A scale whose ends read alike has
// one number instead, with its unit, and at the other end how much of the path it holds for.
export function pathLegend({ path, path_colors: colors }) {
  if (!path) return null;
  const { below, above, label } = path;
  const scale = scaleOf(path.unit, path.low, path.high);
  const [low, high] = [path.low, path.high].map(scale.brief);
  if (low !== high) return { label, colors, unit: scale.symbol, low: `${below ? "≤ " : ""}${low}`, high: `${above ? "≥ " : ""}${high}` };
  const one = scaleOf(path.unit, path.low, path.low);
  return { label, colors, unit: "", low: withUnit(one.brief(path.low), one.symbol), high: below || above ? "but for outliers" : "all along" };
}

export const gradientOf = (colors) => `linear-gradient(90deg, ${colors.join(", ")})`;
