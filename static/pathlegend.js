// What the legend of a path's colours says: the same words beside the scene, in a picture of it and in a replay.

import { scaleOf } from "./units.js";

// What lies beyond the scale has the colour of its end, and the end's number says so.
export function pathLegend({ path, path_colors: colors }) {
  if (!path) return null;
  const scale = scaleOf(path.unit, path.low, path.high);
  return {
    label: path.label, colors, unit: scale.symbol,
    low: `${path.below ? "≤ " : ""}${scale.brief(path.low)}`,
    high: `${path.above ? "≥ " : ""}${scale.brief(path.high)}`,
  };
}

export const gradientOf = (colors) => `linear-gradient(90deg, ${colors.join(", ")})`;
