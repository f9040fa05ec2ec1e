// The numbers under all plots: one axis of time for lanes and plots.

import { cssColor, prepare } from "./plotcanvas.js";
import { timeTicks } from "./timescale.js";

const EDGE = 2; // pixels between a number and the edge, at which it is drawn inwards

export function drawTimeAxis(canvas, scale) {
  const context = prepare(canvas, scale.width, canvas.parentElement.clientHeight);
  const times = timeTicks(scale, scale.span / 75);
  context.fillStyle = cssColor("--faint");
  context.textBaseline = "top";
  context.textAlign = "center";
  for (const t of times.values) {
    const text = times.tell(t);
    context.fillText(text, Math.min(scale.x(t), scale.width - EDGE - context.measureText(text).width / 2), 4);
  }
  context.textAlign = "right";
  context.fillText(`t (${times.symbol})`, scale.left - 16, 4);
}
