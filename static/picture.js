// The picture of the view that is saved: what the 3D view shows, and over it what a reader needs to understand it.

import { $ } from "./dom.js";
import { clockText } from "./format.js";
import { pathLegend } from "./pathlegend.js";

const INK = "#e8f2fa";
const GLASS = "#0b1a28d9";
const FONT = "system-ui, sans-serif";
const EDGE = 14; // px, as all below
const LINE = 18;
const BAR = 168;

function words(context, text, x, y, { size = 13, weight = 400, align = "left" } = {}) {
  context.font = `${weight} ${size}px ${FONT}`;
  context.textAlign = align;
  context.fillText(text, x, y);
}

// Dark glass under words, as over the view on the page.
function glass(context, x, y, width, height) {
  context.fillStyle = GLASS;
  context.beginPath();
  context.roundRect(x, y, width, height, 8);
  context.fill();
  context.fillStyle = INK;
}

function drawTitle(context, { name, moment }, width) {
  const most = width - 2 * EDGE;
  context.font = `650 15px ${FONT}`;
  const wide = Math.max(context.measureText(name).width, context.measureText(moment).width);
  glass(context, EDGE, EDGE, Math.min(wide + 24, most), 3 * LINE);
  context.save();
  context.beginPath();
  context.rect(EDGE, EDGE, most, 3 * LINE);
  context.clip();
  words(context, name, EDGE + 12, EDGE + 22, { size: 15, weight: 650 });
  words(context, moment, EDGE + 12, EDGE + 42);
  context.restore();
}

function drawLegend(context, { label, low, high, unit, colors }, { width, height }) {
  const [x, y] = [width - EDGE - BAR - 20, height - EDGE - 58];
  glass(context, x, y, BAR + 20, 58);
  words(context, unit ? `${label}, ${unit}` : label, x + 10, y + 18, { size: 12 });
  const shades = context.createLinearGradient(x + 10, 0, x + 10 + BAR, 0);
  colors.forEach((color, k) => shades.addColorStop(k / Math.max(colors.length - 1, 1), color));
  context.fillStyle = shades;
  context.fillRect(x + 10, y + 26, BAR, 8);
  context.fillStyle = INK;
  words(context, low, x + 10, y + 49, { size: 11 });
  words(context, high, x + 10 + BAR, y + 49, { size: 11, align: "right" });
}

function drawScale(context, { width, text }, height) {
  glass(context, EDGE, height - EDGE - 40, Math.max(width, 40) + 24, 40);
  words(context, text, EDGE + 12, height - EDGE - 22, { size: 12 });
  context.strokeStyle = INK;
  context.lineWidth = 1.5;
  const [x, y] = [EDGE + 12, height - EDGE - 9];
  context.beginPath();
  context.moveTo(x, y - 6);
  context.lineTo(x, y);
  context.lineTo(x + width, y);
  context.lineTo(x + width, y - 6);
  context.stroke();
}

// What the page says of the view now.
export function notesOf(state, clock, view) {
  const depth = $("scene-depth").textContent;
  const known = $("scene-corner").dataset.known === "true" && $("scale-length").textContent;
  return {
    name: state.name,
    moment: [`t = ${clockText(clock.t, clock.end)}`, depth].filter(Boolean).join(" · "),
    legend: view.path && state.run ? pathLegend(state.scene) : null,
    scale: known ? { width: parseFloat($("scale-bar").style.width), text: $("scale-length").textContent } : null,
  };
}

// The client's canvas with the notes over it, as a PNG. `size` is how large the page shows the canvas, px.
export function annotated(canvas, size, notes) {
  const drawn = document.createElement("canvas");
  const times = Math.max(1, canvas.width / size.width);
  [drawn.width, drawn.height] = [size.width, size.height].map((side) => Math.round(times * side));
  const context = drawn.getContext("2d");
  context.drawImage(canvas, 0, 0, drawn.width, drawn.height);
  context.scale(times, times);
  context.fillStyle = INK;
  drawTitle(context, notes, size.width);
  if (notes.legend) drawLegend(context, notes.legend, size);
  if (notes.scale) drawScale(context, notes.scale, size.height);
  return new Promise((resolve) => drawn.toBlob(resolve, "image/png"));
}
