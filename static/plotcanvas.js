// Drawing on canvas: in the screen's pixels, with the colours of the page.

const FONT = '11px -apple-system, BlinkMacSystemFont, "Segoe UI", Roboto, "Helvetica Neue", Arial, sans-serif';

// Sizes the backing store to the screen's pixels; returns a context that draws in CSS pixels. `options` are those of the
// context, of which the first to ask for it decides.
export function prepare(canvas, width, height, options = {}) {
  const ratio = window.devicePixelRatio || 1;
  canvas.width = Math.round(width * ratio);
  canvas.height = Math.round(height * ratio);
  canvas.style.width = `${width}px`;
  canvas.style.height = `${height}px`;
  const context = canvas.getContext("2d", options);
  context.setTransform(ratio, 0, 0, ratio, 0, 0);
  context.clearRect(0, 0, width, height);
  context.font = FONT;
  return context;
}

// Reading a variable makes the browser settle all styles first: once a scheme is enough.
const colors = new Map();
document.addEventListener("scheme", () => colors.clear());

export function cssColor(name) {
  if (!colors.has(name)) colors.set(name, getComputedStyle(document.documentElement).getPropertyValue(name).trim());
  return colors.get(name);
}

export function line(context, x1, y1, x2, y2) {
  context.beginPath();
  context.moveTo(x1, y1);
  context.lineTo(x2, y2);
  context.stroke();
}

// A plot without a run says so: an empty frame could be a fault.
export function sayEmpty(context, x, y, words = "No glide yet") {
  context.fillStyle = cssColor("--faint");
  context.textAlign = "center";
  context.textBaseline = "middle";
  context.fillText(words, x, y);
}

const APART = 8; // pixels between two lines of a hatch

// The same hatch to draw lines with, for what is no rectangle.
export function hatchPattern(context, color) {
  const ratio = window.devicePixelRatio || 1;
  const side = Math.round(APART * ratio);
  const tile = Object.assign(document.createElement("canvas"), { width: side, height: side });
  const drawn = tile.getContext("2d");
  drawn.strokeStyle = color;
  drawn.lineWidth = 1.5 * ratio;
  for (const at of [-side, 0, side]) line(drawn, at - side, 2 * side, at + 2 * side, -side); // its neighbours' corners, too
  const pattern = context.createPattern(tile, "repeat");
  pattern.setTransform(new DOMMatrix().scale(APART / side));
  return pattern;
}

// Slanting lines over a stretch: seen in black and white too.
export function hatch(context, { x, y, width, height, color }) {
  context.save();
  context.beginPath();
  context.rect(x, y, width, height);
  context.clip();
  context.strokeStyle = color;
  context.lineWidth = 1;
  context.beginPath();
  // Counted from the page's edge, so that neighbouring stretches have one hatch.
  for (let at = Math.floor((x - height) / APART) * APART; at < x + width; at += APART) {
    context.moveTo(at, y + height);
    context.lineTo(at + height, y);
  }
  context.stroke();
  context.restore();
}
