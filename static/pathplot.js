// The path through the water, x against depth, at equal scales, with the glider where the clock is.

import { fixed, toDegrees } from "./format.js";
import { cssColor, line, prepare, sayEmpty } from "./plots.js";
import { angleAt, at, extent, locate } from "./series.js";
import { ticks } from "./timescale.js";

const PAD = { left: 44, right: 14, top: 8, bottom: 36 };

export class PathPlot {
  constructor(box, { onSeek }) {
    this.box = box;
    this.canvas = box.querySelector("canvas");
    this.marker = box.querySelector(".glider-marker");
    this.tip = box.querySelector(".tip");
    this.run = null;
    this.canvas.addEventListener("pointermove", (event) => this.hover(event));
    this.canvas.addEventListener("pointerleave", () => (this.tip.hidden = true));
    this.canvas.addEventListener("click", (event) => this.run && onSeek(this.nearest(event).t));
  }

  setRun(run) {
    this.run = run;
  }

  // One scale for both axes, the path in the middle of what is left over.
  fit(width, height) {
    const [x0, x1] = extent(this.run?.columns.x ?? [0, 1]);
    const [z0, z1] = extent(this.run?.columns.z ?? [0, 1]);
    const inner = [width - PAD.left - PAD.right, height - PAD.top - PAD.bottom];
    const perMetre = Math.min(inner[0] / Math.max((x1 - x0) * 1.1, 0.05), inner[1] / Math.max((z1 - z0) * 1.1, 0.05));
    const spans = [inner[0] / perMetre, inner[1] / perMetre];
    const low = [(x0 + x1 - spans[0]) / 2, (z0 + z1 - spans[1]) / 2];
    this.area = { inner, low, high: [low[0] + spans[0], low[1] + spans[1]] };
    this.px = (x) => PAD.left + (x - low[0]) * perMetre;
    this.pz = (z) => PAD.top + (z - low[1]) * perMetre;
  }

  draw() {
    const { clientWidth: width, clientHeight: height } = this.box;
    const context = prepare(this.canvas, width, height);
    this.fit(width, height);
    this.drawGrid(context, width);
    this.marker.toggleAttribute("hidden", !this.run);
    if (!this.run) return;
    const { x, z } = this.run.columns;
    context.strokeStyle = cssColor("--depth");
    context.lineWidth = 2;
    context.lineJoin = "round";
    context.beginPath();
    for (let i = 0; i < x.length; i += 1) context.lineTo(this.px(x[i]), this.pz(z[i]));
    context.stroke();
  }

  drawGrid(context, width) {
    const { inner, low, high } = this.area;
    const foot = PAD.top + inner[1];
    context.fillStyle = cssColor("--plot-bg");
    context.fillRect(PAD.left, PAD.top, ...inner);
    context.strokeStyle = cssColor("--grid");
    context.fillStyle = cssColor("--faint");
    context.lineWidth = 1;
    context.textAlign = "center";
    context.textBaseline = "top";
    if (!this.run) return sayEmpty(context, PAD.left + inner[0] / 2, PAD.top + inner[1] / 2);
    const across = ticks(low[0], high[0], inner[0] / 55);
    for (const x of across.values) {
      line(context, this.px(x), PAD.top, this.px(x), foot);
      context.fillText(fixed(x, across.digits), this.px(x), foot + 5);
    }
    context.fillText("x, forward (m)", PAD.left + inner[0] / 2, foot + 20);
    context.textAlign = "right";
    context.textBaseline = "middle";
    const down = ticks(low[1], high[1], inner[1] / 40);
    for (const z of down.values) {
      line(context, PAD.left, this.pz(z), width - PAD.right, this.pz(z));
      context.fillText(fixed(z, down.digits), PAD.left - 6, Math.min(Math.max(this.pz(z), PAD.top + 5), foot - 4));
    }
  }

  showTime(t) {
    if (!this.run || !this.px) return;
    const c = this.run.columns;
    const place = locate(c.t, t);
    const turn = -toDegrees(angleAt(c.theta, place));
    this.marker.style.transform = `translate(${this.px(at(c.x, place))}px, ${this.pz(at(c.z, place))}px) rotate(${turn}deg)`;
  }

  nearest(event) {
    const { t, x, z } = this.run.columns;
    const box = this.canvas.getBoundingClientRect();
    const [px, pz] = [event.clientX - box.left, event.clientY - box.top];
    let best = 0;
    let distance = Infinity;
    for (let i = 0; i < t.length; i += 1) {
      const d = (this.px(x[i]) - px) ** 2 + (this.pz(z[i]) - pz) ** 2;
      if (d < distance) [best, distance] = [i, d];
    }
    return { t: t[best], x: x[best], z: z[best] };
  }

  hover(event) {
    if (!this.run) return;
    const { t, x, z } = this.nearest(event);
    this.tip.hidden = false;
    this.tip.textContent = `${fixed(t, 1)} s · x ${fixed(x, 3)} m · depth ${fixed(z, 3)} m`;
    const room = this.box.clientWidth - this.tip.offsetWidth - 4;
    this.tip.style.left = `${Math.max(4, Math.min(this.px(x) - this.tip.offsetWidth / 2, room))}px`;
    this.tip.style.top = `${Math.max(2, this.pz(z) - 34)}px`;
  }
}
