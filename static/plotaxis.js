// A value axis of a plot: the curves on it, their unit, the range it shows and how a value becomes a height.

import { fixed } from "./format.js";
import { extent, extentWithin } from "./series.js";
import { angleTicks, ticks } from "./timescale.js";
import { scaleOf, withUnit } from "./units.js";

const ROOM = 0.08; // of the range, above and below
const APART = 12; // pixels between two numbers, at least
const WIDE_ANGLES = 20; // degrees: from here on parts of a right angle read best

const widest = (pairs) => pairs.reduce(([low, high], [a, b]) => [Math.min(low, a), Math.max(high, b)], [Infinity, -Infinity]);

export class PlotAxis {
  constructor(series, { right = false } = {}) {
    Object.assign(this, { series, right, down: series.length > 0 && series.every((s) => s.down) });
    const whole = widest(series.map((s) => extent(s.values)));
    const known = series.find((s) => s.scale)?.scale;
    this.unit = known ?? scaleOf(series[0].unit, ...whole);
  }

  get symbol() {
    return this.unit.symbol;
  }

  show(series, value) {
    return (series.scale ?? this.unit).show(value);
  }

  // As chosen; else as far as the curves reach within the window, those of kept runs too. In the axis's unit.
  fit(chosen, { from, to, zoomed }) {
    if (chosen) return Object.assign(this, { low: chosen[0], high: chosen[1] });
    const curves = this.series.flatMap((s) => [s, ...s.kept]);
    const found = widest(curves.map(({ t, values }) => extentWithin(t, values, from, to)).filter(Boolean));
    const [a, b] = found[0] <= found[1] ? found.map((v) => v * this.unit.per) : [0, 1];
    // Angles are read against level.
    const level = this.symbol === "°" && !this.right && !zoomed;
    const [low, high] = level ? [Math.min(a, 0), Math.max(b, 0)] : [a, b];
    const pad = Math.max((high - low) * ROOM, Math.abs(high + low) * 1e-6, this.symbol === "°" ? 2 : 1e-9);
    return Object.assign(this, { low: low - pad, high: high + pad });
  }

  // Draws into `inner` pixels below `top`; depth grows downwards.
  place(top, inner) {
    const perUnit = inner / (this.high - this.low || 1);
    this.y = (value) => top + (this.down ? value * this.unit.per - this.low : this.high - value * this.unit.per) * perUnit;
    const count = this.right ? 3 : inner > 80 ? 4 : 3;
    const wide = this.symbol === "°" && this.high - this.low > WIDE_ANGLES;
    const { values, digits } = wide ? angleTicks(this.low, this.high, this.right ? 3 : 4) : ticks(this.low, this.high, count);
    const step = values.length > 1 ? values[1] - values[0] : 1;
    const every = Math.max(1, Math.ceil(APART / (step * perUnit)));
    const shown = values.filter((v) => Math.round(v / step) % every === 0);
    this.ticks = (shown.length ? shown : values.slice(0, 1)).map((v) => ({ v, y: this.y(v / this.unit.per) }));
    this.digits = digits;
  }

  // The number of a tick; at the highest one stands the unit.
  tell(v) {
    const highest = this.down ? this.ticks[0] : this.ticks.at(-1);
    const text = fixed(v, this.digits);
    return v === highest?.v ? withUnit(text, this.symbol) : text;
  }
}

// The first unit is read at the left, the second at the right. A third has no axis: the picker does not offer it.
export function axesOf(series) {
  const kinds = [...new Set(series.map((s) => s.axis))].slice(0, 2);
  return kinds.map((kind, i) => new PlotAxis(series.filter((s) => s.axis === kind), { right: i === 1 }));
}
