// The unit in which people read a column of numbers, and how many digits of it: by its unit and its largest value.

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

// Enough digits to tell a thousandth of the spread.
function digitsFor(low, high) {
  const spread = high - low > 1e-9 * Math.max(Math.abs(low), Math.abs(high)) ? high - low : Math.max(Math.abs(low), Math.abs(high));
  return spread > 0 ? Math.min(Math.max(Math.ceil(3 - Math.log10(spread) - 1e-9), 0), MOST_DIGITS) : 0;
}

export function scaleOf(unit, low, high) {
  const largest = Math.max(Math.abs(low), Math.abs(high)) || 0;
  const [, per, symbol] = (SCALES[unit] ?? [[ALWAYS, 1, written(unit)]]).find(([upTo]) => largest < upTo || upTo === ALWAYS);
  const size = largest * per;
  const odd = size > 0 && (size < 1e-4 || size >= 1e7);
  const digits = digitsFor(low * per, high * per);
  const show = (value) => (odd ? scientific(value * per, 2) : fixed(value * per, digits));
  const brief = (value) => (odd ? show(value) : fixed(value * per, Math.max(digits - 1, 0)));
  return { per, symbol, digits, show, brief, withUnit: (value) => withUnit(show(value), symbol) };
}

// A degree sign stands at its number, every other unit apart from it.
export const withUnit = (text, symbol) => (symbol === "" ? text : symbol === "°" ? text + symbol : `${text} ${symbol}`);
