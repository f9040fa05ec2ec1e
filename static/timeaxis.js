// The numbers under all plots: one axis of time for lanes and plots.

import { cssColor, prepare } from "./plotcanvas.js";
import { timeTicks } from "./timescale.js";

const CLOSE = 34; // pixels between a number and the edge at which it is drawn inwards

export function drawTimeAxis(canvas, scale) {
  const context = prepare(canvas, scale.width, canvas.parentElement.clientHeight);
  const times = timeTicks(scale, scale.span / 75);
  context.fillStyle = cssColor("--faint");
  context.textBaseline = "top";
  context.textAlign = "center";
  for (const t of times.values) context.fillText(times.tell(t), Math.min(scale.x(t), scale.width - CLOSE / 2), 4);
  context.textAlign = "right";
  context.fillText(`t (${times.symbol})`, scale.left - 16, 4);
}
