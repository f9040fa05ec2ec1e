// The glide polar: vertical over horizontal speed at some common strokes of the cells, the best points, and the trims of the
// schedule. A path angle is a ray from the corner, so what glides farthest lies on the flattest ray.

import { call } from "./api.js";
import { $, el, setText, svg } from "./dom.js";
import { degrees, fixed } from "./format.js";
import { heldAt, spansText } from "./held.js";
import { problemNodes } from "./problem.js";
import { ticks } from "./timescale.js";

const [WIDTH, HEIGHT] = [820, 420];
const PAD = { left: 46, right: 12, top: 10, bottom: 34 };
const RAYS = [10, 20, 30, 45, 60]; // degrees
const MARKS = ["M0-6 5 4H-5z", "M0 6 5-4H-5z", "M-4-4H4V4H-4z", "M0-6 6 0 0 6-6 0z"];

function frame({ curves, best }, trims) {
  const points = [...curves.flatMap((curve) => curve.points), ...[...best, ...trims].map((trim) => [trim.horizontal_speed, trim.sink_rate])];
  const width = 1.06 * Math.max(...points.map(([x]) => x), 1e-3);
  const [low, high] = [Math.min(...points.map(([, z]) => z), 0) * 1.08, Math.max(...points.map(([, z]) => z), 0) * 1.08];
  const inner = [WIDTH - PAD.left - PAD.right, HEIGHT - PAD.top - PAD.bottom];
  return { width, low, high, x: (v) => PAD.left + (v / width) * inner[0], y: (z) => PAD.top + ((z - low) / (high - low || 1)) * inner[1] };
}

const text = (x, y, words, anchor = "middle") => svg("text", { x, y, "text-anchor": anchor }, words);

function axes({ width, low, high, x, y }) {
  const across = ticks(0, width, 6);
  const down = ticks(low, high, 6);
  return [
    ...across.values.flatMap((v) => [svg("line", { class: "grid", x1: x(v), x2: x(v), y1: PAD.top, y2: HEIGHT - PAD.bottom }), text(x(v), HEIGHT - PAD.bottom + 13, fixed(v, across.digits))]),
    ...down.values.flatMap((v) => [svg("line", { class: Math.abs(v) < 1e-9 ? "axis" : "grid", x1: PAD.left, x2: WIDTH - PAD.right, y1: y(v), y2: y(v) }), text(PAD.left - 6, y(v) + 3, fixed(v, down.digits), "end")]),
    text((PAD.left + WIDTH) / 2, HEIGHT - 4, "horizontal speed (m/s)"),
    text(PAD.left + 6, PAD.top + 10, "sink rate (m/s), down", "start"),
  ];
}

function rays({ width, low, high, x, y }) {
  return RAYS.flatMap((angle) => [angle, -angle]).map((angle) => {
    const slope = Math.tan((angle * Math.PI) / 180);
    const end = Math.min(width, (angle > 0 ? high : low) / slope);
    if (end <= 0) return null;
    return svg("g", {}, svg("line", { class: "ray", x1: x(0), y1: y(0), x2: x(end), y2: y(end * slope) }), text(x(end) - 3, y(end * slope) + (angle > 0 ? -4 : 10), `${fixed(-angle, 0)}°`, "end"));
  });
}

const GAP = 4; // times the usual step: further apart, two points are not on one branch

// One line for each stretch of stable or of unstable trims; the points lie evenly, so a far one begins another branch.
function curveNodes({ points }, { x, y }) {
  const at = ([u, z]) => [x(u), y(z)];
  if (points.length === 1) return [svg("circle", { class: points[0][3] === 1 ? "curve only" : "curve only loose", cx: x(points[0][0]), cy: y(points[0][1]), r: 2.5 })];
  const steps = points.slice(1).map((point, k) => Math.hypot(...at(point).map((v, i) => v - at(points[k])[i])));
  const usual = [...steps].sort((a, b) => a - b)[steps.length >> 1] ?? 0;
  const stretches = [];
  for (const [k, step] of steps.entries()) {
    if (step > GAP * usual) continue;
    const firm = points[k][3] === 1 && points[k + 1][3] === 1;
    const last = stretches.at(-1);
    if (last?.firm === firm && last.to === k) last.to = k + 1;
    else stretches.push({ firm, from: k, to: k + 1 });
  }
  return stretches.map(({ firm, from, to }) => svg("polyline", { class: firm ? "curve" : "curve loose", points: points.slice(from, to + 1).map((point) => at(point).map((v) => v.toFixed(1)).join(",")).join(" ") }));
}

function pointNode(trim, words, shape, name, { x, y }) {
  return svg("path", { class: name, d: shape, transform: `translate(${x(trim.horizontal_speed).toFixed(1)} ${y(trim.sink_rate).toFixed(1)})`, "data-testid": name === "best" ? null : "glide-polar-trim" }, svg("title", {}, words));
}

const told = (trim) => `path ${degrees(trim.glide_angle)}°, ${fixed(trim.speed, 3)} m/s, ${trim.sink_rate < 0 ? "climbs" : "sinks"} ${fixed(Math.abs(trim.sink_rate), 4)} m/s`;

function legendRow(shape, name, trim, words) {
  const key = svg("svg", { class: `${name} key-mark`, viewBox: "-8 -8 16 16", width: 16, height: 16, "aria-hidden": "true" }, svg("path", { class: name, d: shape }));
  return el("li", {}, key, el("strong", {}, words), ` ${told(trim)}`);
}

const CIRCLE = "M-4.5 0a4.5 4.5 0 1 0 9 0a4.5 4.5 0 1 0-9 0z";

const NEAR = 8; // of the drawing: closer, two of the best points are one to the eye

// The names at the best points; of those that lie on one another, both.
function bestNames(best, { x, y }) {
  const places = [];
  for (const { name, horizontal_speed: u, sink_rate: z } of best) {
    const there = places.find((place) => Math.hypot(place.x - x(u), place.y - y(z)) < NEAR);
    if (there) there.names.push(name);
    else places.push({ x: x(u), y: y(z), names: [name] });
  }
  return places.map((place) => {
    const left = place.x > WIDTH / 2;
    return text(place.x + (left ? -9 : 9), place.y - 7, place.names.join(" · "), left ? "end" : "start");
  });
}

const counted = (n, what) => `${n} ${what}${n === 1 ? "" : "s"}`;

// At the stops all cells together may leave one glide: that is a point, and no line.
function countInWords(curves) {
  const single = curves.filter(({ points }) => points.length === 1).length;
  return [counted(curves.length - single, "line"), single ? counted(single, "single point") : ""].filter(Boolean).join(" and ");
}

export class GlidePolarView {
  constructor({ store, clock }) {
    Object.assign(this, { store, clock, found: null, asked: null });
  }

  // Asked for when shown, and again for another revision.
  async load() {
    const revision = this.store.get("state")?.revision;
    if (revision === undefined || revision === this.asked) return this.draw();
    this.asked = revision;
    setText($("glide-polar-words"), "Seeking trims over the strokes…");
    try {
      const found = await call("GET", "glide-polar");
      if (this.asked !== revision) return undefined;
      this.found = found;
      $("glide-polar-problem").hidden = true;
      this.draw();
    } catch (error) {
      this.asked = null;
      this.found = null;
      setText($("glide-polar-words"), "");
      $("glide-polar-plot").replaceChildren();
      $("glide-polar-problem").hidden = false;
      $("glide-polar-problem").replaceChildren(...problemNodes(error.problem ?? { title: error.message }));
    }
    return undefined;
  }

  draw() {
    if (!this.found) return;
    const consequences = this.store.get("consequences");
    const holds = (consequences?.holds ?? []).filter(({ trim }) => trim);
    const scale = frame(this.found, holds.map(({ trim }) => trim));
    const now = heldAt(consequences, this.clock.t)?.hold;
    const { best, curves } = this.found;
    const marks = [
      ...best.map((trim, k) => pointNode(trim, `${trim.name}: ${told(trim)}`, MARKS[k % MARKS.length], "best", scale)),
      ...holds.map((hold) => pointNode(hold.trim, `Trim held ${spansText(hold.spans, this.clock.end)}: ${told(hold.trim)}`, CIRCLE, hold === now ? "trim-mark now" : "trim-mark", scale)),
    ];
    $("glide-polar-plot").replaceChildren(svg("svg", { viewBox: `0 0 ${WIDTH} ${HEIGHT}`, role: "img", "aria-label": "Sink rate over horizontal speed, at some volumes that the cells add or take together" },
      ...axes(scale), ...rays(scale).filter(Boolean), ...curves.flatMap((curve) => curveNodes(curve, scale)), ...marks, ...bestNames(best, scale)));
    $("glide-polar-legend").replaceChildren(
      ...holds.map((hold) => legendRow(CIRCLE, hold === now ? "trim-mark now" : "trim-mark", hold.trim, `Trim ${spansText(hold.spans, this.clock.end)}`)),
      ...best.map((trim, k) => legendRow(MARKS[k % MARKS.length], "best", trim, trim.name)));
    setText($("glide-polar-words"), `${countInWords(curves)}, one for each amount by which all cells swell or shrink together, from a quarter of the stroke to the stops; dashed where the glide is unstable. Energy is ${this.found.energy}.`);
  }
}
