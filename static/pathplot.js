// The path through the water at equal scales, from the side or from above, with the glider where the clock is.

import { $, el, setText } from "./dom.js";
import { clockText, fixed } from "./format.js";
import { columnsOf } from "./keptruns.js";
import { describeKey } from "./keys.js";
import { PATH_VIEWS } from "./pathviews.js";
import { cssColor, hatchPattern, line, prepare, sayEmpty } from "./plotcanvas.js";
import { focusByKeysOnly, sayPlace } from "./plotcursor.js";
import { outsideAt, outsideStretches } from "./plotoutside.js";
import { clamp } from "./schedule.js";
import { at, extent, locate, within } from "./series.js";
import { niceStep, ticks, timeStep } from "./timescale.js";

const PAD = { left: 44, right: 14, top: 8, bottom: 36 };
const BAND = 16; // pixels across the path
const OUTSIDE = 0.6; // how strong its hatch is
const APART = 8; // pixels from the tip to what it tells of
const FAST = 10;

// How many times larger depth is drawn where there is room for `room` times: 1, or 2, 5, 10, ... of a flat path.
function stretchOf(room) {
  if (!(room > 5)) return 1;
  return niceStep(room / 2.5, 1);
}

export class PathPlot {
  // `keptOf` answers the kept runs to lay over, in their colours.
  constructor(box, { onSeek, keptOf }) {
    Object.assign(this, { box, keptOf, ways: new Map() });
    this.canvas = box.querySelector("canvas");
    this.marker = box.querySelector(".glider-marker");
    this.tip = box.querySelector(".tip");
    this.run = null;
    this.canvas.addEventListener("pointermove", (event) => this.run && this.tell(this.nearest(event)));
    this.canvas.addEventListener("click", (event) => this.run && onSeek(this.nearest(event).t));
    this.listenToKeys(onSeek);
    for (const radio of document.querySelectorAll("[name=path-view]")) radio.addEventListener("change", () => this.look());
    this.setRun(null);
  }

  // As a slider along the path, on which the clock moves and tells where it is.
  listenToKeys(onSeek) {
    for (const [name, value] of Object.entries({ role: "slider", tabindex: 0, "aria-valuenow": 0 })) this.canvas.setAttribute(name, value);
    focusByKeysOnly(this.canvas);
    this.canvas.addEventListener("focus", () => this.showTime(this.t ?? 0));
    for (const name of ["pointerleave", "blur"]) this.canvas.addEventListener(name, () => (this.tip.hidden = true));
    this.canvas.addEventListener("keydown", (event) => this.press(event, onSeek));
    describeKey(["ArrowLeft", "ArrowRight"], `On the path: the clock back or on along it, ×${FAST} with Shift, with the place told`, "Plots");
    describeKey("click", "On the path: the clock to the place", "Plots");
  }

  press(event, onSeek) {
    if (!this.run || event.ctrlKey || event.metaKey || event.altKey) return;
    const end = this.run.columns.t.at(-1);
    const by = timeStep(end) * (event.shiftKey ? FAST : 1);
    const next = { ArrowLeft: this.t - by, ArrowRight: this.t + by, Home: 0, End: end }[event.key];
    if (next === undefined) return;
    onSeek(clamp(next, 0, end));
    event.preventDefault();
    event.stopPropagation();
  }

  setRun(run) {
    this.run = run;
    const spatial = run?.model === "spatial";
    $("path-views").hidden = !spatial;
    this.view = PATH_VIEWS[spatial ? document.querySelector("[name=path-view]:checked").value : "planar"];
  }

  // Another view of the same run.
  look() {
    this.setRun(this.run);
    this.draw();
    this.showTime(this.t ?? 0);
  }

  // Kept runs' ways as far as they have come; the others are asked for, once each and view.
  keptWays() {
    const { across, along } = this.view;
    return this.keptOf().flatMap((kept) => {
      const key = `${kept.id} ${across} ${along}`;
      if (!this.ways.has(key)) this.fetchWay(kept.id, [across, along], key);
      const columns = this.ways.get(key)?.columns;
      return columns?.[across] && columns[along] ? [{ across: columns[across], along: columns[along], color: cssColor(`--kept-${kept.place + 1}`) }] : [];
    });
  }

  async fetchWay(id, names, key) {
    this.ways.set(key, null);
    try {
      this.ways.set(key, await columnsOf(id, names));
      this.draw();
      this.showTime(this.t ?? 0);
    } catch {
      this.ways.delete(key); // forgotten meanwhile
    }
  }

  column(side) {
    return this.run.columns[this.view[side]];
  }

  // One scale for both axes if it can be, the path in the middle of what is left over.
  fit(width, height) {
    const { sign } = this.view;
    const [x0, x1] = extent(this.run ? [this.column("across"), ...this.kept.map((way) => way.across)].flatMap(extent) : [0, 1]);
    const [z0, z1] = extent(this.run ? [this.column("along"), ...this.kept.map((way) => way.along)].flatMap(extent) : [0, 1]);
    const inner = [width - PAD.left - PAD.right, height - PAD.top - PAD.bottom];
    const most = [inner[0] / Math.max((x1 - x0) * 1.1, 0.05), inner[1] / Math.max((z1 - z0) * 1.1, 0.05)];
    const perMetre = Math.min(...most);
    // A long way at little depth would be a flat line: its depth is drawn larger, and the title says so.
    this.stretch = sign > 0 ? stretchOf(most[1] / perMetre) : 1;
    setText($("path-title"), this.stretch > 1 ? `Path, depth ×${this.stretch}` : this.view.title);
    const down = perMetre * this.stretch;
    const spans = [inner[0] / perMetre, inner[1] / down];
    const low = [(x0 + x1 - spans[0]) / 2, (z0 + z1 - spans[1]) / 2];
    this.area = { inner, low, high: [low[0] + spans[0], low[1] + spans[1]] };
    this.px = (x) => PAD.left + (x - low[0]) * perMetre;
    this.pz = (z) => PAD.top + (sign > 0 ? z - low[1] : this.area.high[1] - z) * down;
  }

  draw() {
    const { clientWidth: width, clientHeight: height } = this.box;
    const context = prepare(this.canvas, width, height);
    this.kept = this.run ? this.keptWays() : [];
    this.fit(width, height);
    this.drawGrid(context, width);
    this.marker.toggleAttribute("hidden", !this.run);
    if (!this.run) return;
    context.lineJoin = "round";
    this.drawOutside(context);
    for (const way of this.kept) this.drawWay(context, { ...way, width: 1.4, dash: [6, 3] });
    this.drawWay(context, { across: this.column("across"), along: this.column("along"), color: cssColor(this.kept.length ? "--present" : "--depth"), width: 2, dash: [] });
  }

  // Where samples left the data which the forces come from: a hatched band under the path, as the plots' hatched ground.
  drawOutside(context) {
    const { t } = this.run.columns;
    const [across, along] = [this.column("across"), this.column("along")];
    context.save();
    Object.assign(context, { strokeStyle: hatchPattern(context, cssColor("--warn")), lineWidth: BAND, lineCap: "round", globalAlpha: OUTSIDE });
    for (const [a, b] of outsideStretches(this.run)) {
      const [first, last] = within(t, a, b);
      const times = [a, ...t.slice(first, last + 1).filter((time) => time > a && time < b), b];
      context.beginPath();
      for (const place of times.map((time) => locate(t, time))) context.lineTo(this.px(at(across, place)), this.pz(at(along, place)));
      context.stroke();
    }
    context.restore();
  }

  drawWay(context, { across, along, color, width, dash }) {
    context.strokeStyle = color;
    context.lineWidth = width;
    context.setLineDash(dash);
    context.beginPath();
    for (let i = 0; i < across.length; i += 1) context.lineTo(this.px(across[i]), this.pz(along[i]));
    context.stroke();
    context.setLineDash([]);
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
    context.fillText(this.view.label, PAD.left + inner[0] / 2, foot + 20);
    context.textAlign = "right";
    context.textBaseline = "middle";
    const down = ticks(low[1], high[1], inner[1] / 40);
    for (const z of down.values) {
      if (this.view.sign > 0 && z < 0) continue; // there is no depth above the surface
      line(context, PAD.left, this.pz(z), width - PAD.right, this.pz(z));
      context.fillText(fixed(z, down.digits), PAD.left - 6, Math.min(Math.max(this.pz(z), PAD.top + 5), foot - 4));
    }
  }

  showTime(t) {
    this.t = t;
    if (!this.run || !this.px) return;
    const place = locate(this.run.columns.t, t);
    const [x, z] = [at(this.column("across"), place), at(this.column("along"), place)];
    this.marker.style.transform = `translate(${this.px(x)}px, ${this.pz(z)}px) rotate(${this.view.turn(this.run.columns, place)}deg)`;
    if (document.activeElement !== this.canvas) return;
    const text = this.tell({ t, x, z });
    sayPlace(this.canvas, { low: 0, high: this.run.columns.t.at(-1), now: t, text });
  }

  nearest(event) {
    const { t } = this.run.columns;
    const [across, along] = [this.column("across"), this.column("along")];
    const box = this.canvas.getBoundingClientRect();
    const [px, pz] = [event.clientX - box.left, event.clientY - box.top];
    let best = 0;
    let distance = Infinity;
    for (let i = 0; i < t.length; i += 1) {
      const d = (this.px(across[i]) - px) ** 2 + (this.pz(along[i]) - pz) ** 2;
      if (d < distance) [best, distance] = [i, d];
    }
    return { t: t[best], x: across[best], z: along[best] };
  }

  // Beside a place: when the glider is there, and what is outside the data then. Returns the words.
  tell({ t, x, z }) {
    const place = `${clockText(t, this.run.columns.t.at(-1))} · ${this.view.tip(x, z)}`;
    const notes = outsideAt(this.run, t).slice(0, 1);
    this.tip.replaceChildren(place, ...notes.map((words) => el("p", {}, words)));
    this.tip.hidden = false;
    this.tip.style.left = "0"; // where it has room for its lines
    const room = this.box.clientWidth - this.tip.offsetWidth - 4;
    this.tip.style.left = `${Math.max(4, Math.min(this.px(x) - this.tip.offsetWidth / 2, room))}px`;
    const above = this.pz(z) - this.tip.offsetHeight - APART;
    this.tip.style.top = `${above < 2 && notes.length ? this.pz(z) + APART : Math.max(2, above)}px`;
    return [place, ...notes].join(" · ");
  }
}
