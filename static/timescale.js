// The horizontal scale that lanes, plots, scrub bar and the red line share, the window of time it shows, and nice ticks.

import { clockText, fixed, longerThan } from "./format.js";

export const GUTTER = 78; // pixels left of the window, for the value axes' numbers and the lanes' unit
export const MARGIN = 14; // pixels right of it
const CLOSEST = 500; // times: how near a look may come

// `end` is the whole axis; the window [from, to] is all of it unless someone looks closer.
export class TimeScale {
  constructor() {
    this.width = 600;
    this.end = 1;
    this.window = null;
  }

  get span() {
    return Math.max(this.width - GUTTER - MARGIN, 1);
  }

  get from() {
    return this.window ? this.window[0] : 0;
  }

  get to() {
    return this.window ? this.window[1] : this.end;
  }

  get seconds() {
    return this.to - this.from;
  }

  get zoomed() {
    return this.window !== null;
  }

  get left() {
    return GUTTER;
  }

  get right() {
    return GUTTER + this.span;
  }

  x(t) {
    return GUTTER + ((t - this.from) / this.seconds) * this.span;
  }

  // Always within the axis: what is typed and dragged must not leave it.
  t(x) {
    return Math.min(Math.max(this.from + ((x - GUTTER) / this.span) * this.seconds, 0), this.end);
  }

  shows(t) {
    return t >= this.from && t <= this.to;
  }

  // Another axis keeps the window as far as it reaches.
  setEnd(end) {
    this.end = end;
    if (this.window) this.setWindow(...this.window);
  }

  setWindow(from, to) {
    const length = Math.min(Math.max(to - from, this.end / CLOSEST), this.end);
    const start = Math.min(Math.max(from, 0), this.end - length);
    this.window = length >= this.end * (1 - 1e-9) ? null : [start, start + length];
  }

  // `around` stays where it is on the screen.
  zoom(factor, around) {
    const length = this.seconds / factor;
    const share = (around - this.from) / this.seconds;
    this.setWindow(around - share * length, around + (1 - share) * length);
  }

  pan(seconds) {
    if (this.window) this.setWindow(this.from + seconds, this.to + seconds);
  }
}

const ROOM = 1.05; // of the last moment: an end at the very edge would look cut off

// A run may end early (surface, bed): the axis then shows what happened and the whole schedule, not an empty rest.
// A point after the mission's end still gets its place.
export function axisEnd({ duration, runEnd, lastPoint }) {
  const whole = Math.max(duration, lastPoint);
  if (runEnd === null || runEnd >= duration * (1 - 1e-9)) return whole;
  return Math.min(whole, Math.max(runEnd, lastPoint) * ROOM) || whole;
}

// A step of 1, 2 or 5 times a power of ten that gives about `count` ticks.
export function niceStep(span, count) {
  const raw = span / Math.max(count, 1);
  const power = 10 ** Math.floor(Math.log10(raw));
  const lead = raw / power;
  return (lead <= 1 ? 1 : lead <= 2 ? 2 : lead <= 5 ? 5 : 10) * power;
}

export function ticks(low, high, count) {
  if (!(high > low)) return { values: [low], digits: 0 };
  const step = niceStep(high - low, count);
  const values = [];
  for (let k = Math.ceil(low / step - 1e-9); k * step <= high + step * 1e-9; k += 1) values.push(k * step);
  return { values, digits: Math.max(0, -Math.floor(Math.log10(step) + 1e-9)) };
}

// Steps that read well on a clock of minutes and hours, s; shorter and longer ones as of any number.
const CLOCK_STEPS = [1, 2, 5, 10, 15, 30, 60, 120, 300, 600, 900, 1200, 1800, 2400, 3600];

function clockStep(seconds, count) {
  const step = niceStep(seconds, count);
  if (step < 1) return step;
  return CLOCK_STEPS.find((each) => seconds / each <= count) ?? 3600 * Math.ceil(seconds / count / 3600);
}

// Ticks of a time axis, in seconds, and how each is written: as every moment on the page.
export function timeTicks({ from, to, end }, count) {
  const { symbol } = longerThan(end);
  if (symbol === "s") {
    const { values, digits } = ticks(from, to, count);
    return { values, symbol, tell: (t) => fixed(t, digits) };
  }
  const step = clockStep(to - from, count);
  const values = [];
  for (let k = Math.ceil(from / step - 1e-9); k * step <= to + step * 1e-9; k += 1) values.push(k * step);
  return { values, symbol, tell: (t) => clockText(t, end, { unit: false, tenths: step < 1 }) };
}

// What a drag or an arrow key moves a time by: tenths of a second, more where a pixel is more than that.
export const timeStep = (end) => Math.max(0.1, niceStep(end, 1000));

// Angles read best in parts of a right angle.
export function angleTicks(low, high, count = 4) {
  const step = [5, 10, 15, 30, 45, 90, 180].find((s) => (high - low) / s <= count + 0.2) ?? 360 * Math.ceil((high - low) / (360 * count));
  const values = [];
  for (let v = Math.ceil(low / step) * step; v <= high; v += step) values.push(v);
  return { values, digits: 0 };
}
