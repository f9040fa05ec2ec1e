// The horizontal scale that lanes, plots, scrub bar and the red line share, and nice tick values.

import { longerThan } from "./format.js";

export const GUTTER = 62; // pixels left of t = 0, for the value axes' numbers and the lanes' unit
export const MARGIN = 14; // pixels right of the end

export class TimeScale {
  constructor() {
    this.width = 600;
    this.end = 1;
  }

  get span() {
    return Math.max(this.width - GUTTER - MARGIN, 1);
  }

  x(t) {
    return GUTTER + (t / this.end) * this.span;
  }

  t(x) {
    return Math.min(Math.max(((x - GUTTER) / this.span) * this.end, 0), this.end);
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

// Ticks of a time axis, in seconds, with the numbers to write in the unit that suits its length.
export function timeTicks(end, count) {
  const { per, symbol } = longerThan(end);
  const { values, digits } = ticks(0, end / per, count);
  return { values: values.map((v) => v * per), per, digits, symbol };
}

// What a drag or an arrow key moves a time by: tenths of a second, more where a pixel is more than that.
export const timeStep = (end) => Math.max(0.1, niceStep(end, 1000));

// Angles read best in parts of a right angle.
export function angleTicks(low, high) {
  const step = [5, 10, 15, 30, 45, 90].find((s) => (high - low) / s <= 4.2) ?? 180;
  const values = [];
  for (let v = Math.ceil(low / step) * step; v <= high; v += step) values.push(v);
  return { values, digits: 0 };
}
