// Reading the force polars by keys: arrows move the angle of attack at which all three tell their values.

import { describeKey } from "./keys.js";
import { sayPlace } from "./plotcursor.js";
import { clamp } from "./schedule.js";

const FAST = 10; // degrees at once with Shift

// start() answers the angle to begin at, in degrees; onRead(angle or null) shows the values; told(plot, angle) words them.
export function readByKeys(plot, { start, onRead, told }) {
  const { canvas } = plot;
  let degrees = 0;
  const put = (angle) => {
    degrees = clamp(angle, plot.low, plot.high);
    onRead(degrees);
    sayPlace(canvas, { low: plot.low, high: plot.high, now: degrees, text: told(plot, degrees) });
  };
  for (const [name, value] of Object.entries({ role: "slider", tabindex: 0, "aria-valuenow": 0 })) canvas.setAttribute(name, value);
  canvas.addEventListener("focus", () => plot.document && put(Math.round(start())));
  canvas.addEventListener("blur", () => onRead(null));
  canvas.addEventListener("keydown", (event) => {
    const by = event.shiftKey ? FAST : 1;
    const next = { ArrowLeft: degrees - by, ArrowRight: degrees + by, Home: plot.low, End: plot.high }[event.key];
    if (next === undefined || !plot.document) return;
    put(next);
    event.preventDefault();
  });
}

export function describePolarKeys() {
  describeKey(["ArrowLeft", "ArrowRight"], `On a force polar: read it a degree before or after, ${FAST} with Shift`, "View");
}
