// One plot of the force dialog: the data of every speed, the data chosen and the law, over the angle of attack.

import { el } from "./dom.js";
import { fixed } from "./format.js";
import { cssColor, line, prepare } from "./plotcanvas.js";
import { extent } from "./series.js";
import { ticks } from "./timescale.js";

const PAD = { left: 48, right: 12, top: 8, bottom: 36 };

const polygon = (c, x, y, corners) => {
  c.moveTo(x + corners[0][0], y + corners[0][1]);
  for (const [dx, dy] of corners.slice(1)) c.lineTo(x + dx, y + dy);
  c.closePath();
};

// Shapes before colours: who cannot tell two colours apart still tells a square from a triangle.
const SHAPES = [
  (c, x, y) => c.arc(x, y, 3.6, 0, 2 * Math.PI),
  (c, x, y) => polygon(c, x, y, [[-3.4, -3.4], [3.4, -3.4], [3.4, 3.4], [-3.4, 3.4]]),
  (c, x, y) => polygon(c, x, y, [[0, -4.4], [4.2, 3.2], [-4.2, 3.2]]),
  (c, x, y) => polygon(c, x, y, [[0, -4.8], [4.2, 0], [0, 4.8], [-4.2, 0]]),
  (c, x, y) => polygon(c, x, y, [[0, 4.4], [4.2, -3.2], [-4.2, -3.2]]),
  (c, x, y) => polygon(c, x, y, [[-4, -4], [4, 4], [0, 0], [4, -4], [-4, 4], [0, 0]]),
];
const COLORS = 6;

export function drawMarker(context, k, x, y, size = 1) {
  context.save();
  context.translate(x, y);
  context.scale(size, size);
  context.beginPath();
  SHAPES[k % SHAPES.length](context, 0, 0);
  context.strokeStyle = cssColor(`--series-${(k % COLORS) + 1}`);
  context.lineWidth = 1.5;
  context.stroke();
  context.restore();
}

export function drawDot(context, x, y) {
  context.beginPath();
  context.arc(x, y, 1.9, 0, 2 * Math.PI);
  context.fillStyle = cssColor("--ink");
  context.fill();
}

// A ring, so that the law and the data under it stay in sight.
// Told apart by their numbers, from 1.
export function drawTrim(context, number, x, y) {
  context.beginPath();
  context.arc(x, y, 6, 0, 2 * Math.PI);
  context.fillStyle = cssColor("--plot-bg");
  context.fill();
  context.strokeStyle = context.fillStyle = cssColor("--good");
  context.lineWidth = 1.5;
  context.stroke();
  context.font = "600 9px system-ui, sans-serif";
  context.textAlign = "center";
  context.textBaseline = "middle";
  context.fillText(String(number), x, y + 0.5);
}

// Every degree is given, so the value between two is read off the line that is drawn.
export function lawAt(law, quantity, degrees) {
  const place = Math.min(Math.max(degrees - law.alpha_deg[0], 0), law.alpha_deg.length - 1);
  const i = Math.min(Math.floor(place), law.alpha_deg.length - 2);
  return law[quantity][i] + (law[quantity][i + 1] - law[quantity][i]) * (place - i);
}

// What no one measured may be mirrored into the measured quarter: where an angle lies there.
export function mirrored(degrees, { folds }) {
  const size = Math.abs(degrees);
  if (!folds) return degrees;
  return size > 90 ? 180 - size : size;
}

const gridStep = (span) => [1, 2, 5, 10, 15, 30, 45].find((step) => span / step <= 6.5) ?? 90;

export class PolarPlot {
  constructor(box, quantity) {
    this.box = box;
    this.quantity = quantity;
    this.canvas = box.querySelector("canvas");
    this.mark = box.querySelector(".polar-mark");
    this.reading = el("div", { class: "polar-mark reading", hidden: true });
    box.append(this.reading);
    this.trims = []; // steady glides: their angles of attack, in degrees
  }

  setRange(document, whole) {
    this.document = document;
    this.whole = whole;
    [this.low, this.high] = whole ? [-180, 180] : document.range_deg;
  }

  // Of the law only what is in view; of the data all.
  limits() {
    const { law, data } = this.document;
    const seen = law[this.quantity].filter((_, i) => law.alpha_deg[i] >= this.low && law.alpha_deg[i] <= this.high);
    const [low, high] = extent([0, ...seen, ...data.flatMap((series) => series[this.quantity])]);
    const room = 0.07 * Math.max(high - low, 1e-9);
    return [low < 0 ? low - room : 0, high > 0 ? high + room : 0];
  }

  draw() {
    const { clientWidth: width, clientHeight: height } = this.box;
    if (!this.document || !width) return;
    const context = prepare(this.canvas, width, height);
    const [low, high] = this.limits();
    this.inner = [width - PAD.left - PAD.right, height - PAD.top - PAD.bottom];
    this.x = (degrees) => PAD.left + ((degrees - this.low) / (this.high - this.low)) * this.inner[0];
    this.y = (value) => PAD.top + ((high - value) / (high - low)) * this.inner[1];
    this.drawGrid(context, low, high);
    context.save();
    context.beginPath();
    context.rect(PAD.left, PAD.top - 1, this.inner[0], this.inner[1] + 2);
    context.clip();
    this.drawLaw(context);
    context.restore();
    this.drawData(context);
    this.trims.forEach(({ attack }, k) => this.markTrim(context, k + 1, attack));
  }

  drawGrid(context, low, high) {
    const foot = PAD.top + this.inner[1];
    const end = PAD.left + this.inner[0];
    context.fillStyle = cssColor("--plot-bg");
    context.fillRect(PAD.left, PAD.top, ...this.inner);
    if (this.whole) {
      context.fillStyle = cssColor("--measured");
      const [from, to] = this.document.range_deg;
      context.fillRect(this.x(from), PAD.top, this.x(to) - this.x(from), this.inner[1]);
    }
    context.lineWidth = 1;
    context.strokeStyle = cssColor("--grid");
    context.fillStyle = cssColor("--faint");
    context.textAlign = "center";
    context.textBaseline = "top";
    const step = gridStep(this.high - this.low);
    for (let a = Math.ceil(this.low / step) * step; a <= this.high; a += step) {
      line(context, this.x(a), PAD.top, this.x(a), foot);
      context.fillText(fixed(a, 0), this.x(a), foot + 5);
    }
    context.fillText("angle of attack (°)", PAD.left + this.inner[0] / 2, foot + 20);
    context.textAlign = "right";
    context.textBaseline = "middle";
    const vertical = ticks(low, high, this.inner[1] / 38);
    for (const v of vertical.values) {
      context.strokeStyle = cssColor(Math.abs(v) < 1e-9 ? "--faint" : "--grid");
      line(context, PAD.left, this.y(v), end, this.y(v));
      context.fillText(fixed(v, vertical.digits), PAD.left - 9, this.y(v));
    }
  }

  drawLaw(context) {
    const { law } = this.document;
    context.strokeStyle = cssColor("--accent");
    context.lineWidth = 2;
    context.lineJoin = "round";
    context.beginPath();
    law.alpha_deg.forEach((a, i) => context.lineTo(this.x(a), this.y(law[this.quantity][i])));
    context.stroke();
  }

  drawData(context) {
    const { data, chosen } = this.document;
    const size = this.whole ? 0.7 : 1;
    data.forEach((series, k) => series.alpha_deg.forEach((a, i) => drawMarker(context, k, this.x(a), this.y(series[this.quantity][i]), size)));
    if (this.whole || !chosen) return; // a quarter of the width: dots would hide the markers
    chosen.alpha_deg.forEach((a, i) => drawDot(context, this.x(a), this.y(chosen[this.quantity][i])));
  }

  markTrim(context, number, attack) {
    const there = this.whole ? attack : mirrored(attack, this.document);
    if (there < this.low || there > this.high) return;
    drawTrim(context, number, this.x(there), this.y(lawAt(this.document.law, this.quantity, there)));
  }

  // The angle under the pointer, or null beside the axes.
  angleUnder(event) {
    const box = this.canvas.getBoundingClientRect();
    const share = (event.clientX - box.left - PAD.left) / this.inner[0];
    return share < -0.02 || share > 1.02 ? null : this.low + Math.min(Math.max(share, 0), 1) * (this.high - this.low);
  }

  // A thin line where values are read instead.
  showRead(degrees) {
    this.reading.hidden = degrees === null || !this.x;
    if (!this.reading.hidden) this.reading.style.transform = `translateX(${this.x(degrees)}px)`;
  }

  // The vertical line at an angle of attack, in degrees; null where there is none.
  showAngle(degrees) {
    this.mark.hidden = degrees === null || !this.x;
    if (this.mark.hidden) return;
    const there = this.whole ? degrees : mirrored(degrees, this.document);
    if (there < this.low || there > this.high) return (this.mark.hidden = true);
    this.mark.classList.toggle("mirrored", !this.whole && there !== degrees);
    this.mark.style.transform = `translateX(${this.x(there)}px)`;
  }
}
