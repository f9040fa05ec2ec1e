// The unit in which people read a column of numbers, and how many digits of it: by its unit and its largest value. A value
// far smaller than its column has digits of its own: those of the column would leave nothing of it.

import { fixed, scientific } from "./format.js";

const DEGREES = 180 / Math.PI;
const ALWAYS = Infinity;

// Up to which size (SI), times what, and the symbol.
const SCALES = {
  1: [[ALWAYS, 1, ""]],
  m: [[0.5, 1e3, "mm"], [1e4, 1, "m"], [ALWAYS, 1e-3, "km"]],
  m3: [[0.01, 1e6, "cm³"], [ALWAYS, 1, "m³"]],
  kg: [[1, 1e3, "g"], [ALWAYS, 1, "kg"]],
  rad: [[ALWAYS, DEGREES, "°"]],
  deg: [[ALWAYS, 1, "°"]],
  "rad/s": [[ALWAYS, DEGREES, "°/s"]],
  degC: [[ALWAYS, 1, "°C"]],
  s: [[180, 1, "s"], [3 * 3600, 1 / 60, "min"], [ALWAYS, 1 / 3600, "h"]],
  "m/s": [[0.01, 1e3, "mm/s"], [ALWAYS, 1, "m/s"]],
  J: [[1e4, 1, "J"], [1e7, 1e-3, "kJ"], [ALWAYS, 1e-6, "MJ"]],
  "J/km": [[1e4, 1, "J/km"], [1e7, 1e-3, "kJ/km"], [ALWAYS, 1e-6, "MJ/km"]],
  Pa: [[1e5, 1, "Pa"], [ALWAYS, 1e-3, "kPa"]],
};

const POWERS = { 2: "²", 3: "³", 4: "⁴" };
const written = (unit) => unit.replace(/([A-Za-z])([234])(?!\d)/g, (_, letter, power) => letter + POWERS[power]);

const MOST_DIGITS = 6;
const LEAST = 1e-4; // below this, and from MOST on, a number is written with a power of ten
const MOST = 1e7;
const ROUNDING = 1e-12;
const FEWEST = 2; // significant digits that are left of any value

// Enough digits to tell a thousandth of the spread.
function digitsFor(low, high) {
  const spread = high - low > 1e-9 * Math.max(Math.abs(low), Math.abs(high)) ? high - low : Math.max(Math.abs(low), Math.abs(high));
  return spread > 0 ? Math.min(Math.max(Math.ceil(3 - Math.log10(spread) - 1e-9), 0), MOST_DIGITS) : 0;
}

// How many digits after the point show so many significant ones.
const decimals = (size, significant) => Math.max(significant - 1 - Math.floor(Math.log10(size) + 1e-12), 0);

function readable(value, digits, { powers, noise }) {
  const size = Math.abs(value);
  if (!(size > noise && size < Infinity)) return fixed(value, digits);
  if (size < LEAST || size >= MOST) return scientific(value, powers);
  const shown = Number(size.toFixed(digits));
  const few = shown !== size && shown * 10 ** digits < 10 ** (FEWEST - 1);
  return fixed(value, few ? decimals(size, FEWEST) : digits);
}

// Digits of a mantissa that tell a hundredth of the spread.
function powersFor(low, high) {
  const largest = Math.max(Math.abs(low), Math.abs(high));
  return high > low ? Math.min(Math.max(Math.ceil(2 + Math.log10(largest / (high - low)) - 1e-9), 2), MOST_DIGITS) : 2;
}

// `noise`, a part of the largest value, is what counts as nothing: what is left over of sums, and where a solver found a
// root, by how much that misses zero.
export function scaleOf(unit, low, high, { noise = ROUNDING } = {}) {
  const largest = Math.max(Math.abs(low), Math.abs(high)) || 0;
  const [, per, symbol] = (SCALES[unit] ?? [[ALWAYS, 1, written(unit)]]).find(([upTo]) => largest < upTo || upTo === ALWAYS);
  const size = largest * per;
  const odd = size > 0 && (size < LEAST || size >= MOST);
  const digits = odd ? 0 : digitsFor(low * per, high * per);
  const how = { powers: odd ? powersFor(low, high) : 1, noise: noise * size };
  const show = (value) => readable(value * per, digits, how);
  const brief = (value) => readable(value * per, Math.max(digits - 1, 0), how);
  return { per, symbol, digits, show, brief, withUnit: (value) => withUnit(show(value), symbol) };
}

// A degree sign stands at its number, every other unit apart from it.
export const withUnit = (text, symbol) => (symbol === "" ? text : symbol === "°" ? text + symbol : `${text} ${symbol}`);
