// Numbers for people: SI in, the unit of the label out, with a true minus sign.

export const NONE = "–";
const DEGREES = 180 / Math.PI;

export function fixed(value, digits) {
  if (value == null || !Number.isFinite(value)) return NONE;
  const text = Math.abs(value).toFixed(digits);
  // "−0.0" would claim a sign that the digits do not show.
  return value < 0 && Number(text) !== 0 ? `\u2212${text}` : text;
}

export const degrees = (radians, digits = 1) => fixed(radians * DEGREES, digits);
export const millimetres = (metres, digits = 2) => fixed(metres * 1e3, digits);
export const grams = (kilograms, digits = 1) => fixed(kilograms * 1e3, digits);
export const cubicCentimetres = (cubicMetres, digits = 1) => fixed(cubicMetres * 1e6, digits);
// A heading on the compass card, 0 to 360 however often it went round.
export const compass = (radians) => fixed((((Math.round(radians * DEGREES * 10) % 3600) + 3600) % 3600) / 10, 1);
export const toDegrees = (radians) => radians * DEGREES;

// The server writes numbers in its sentences with a hyphen; a range from one to another keeps its own.
export const trueMinus = (text) => text?.replace(/(^|[\s([{:,±])-(?=[\d.])/g, "$1\u2212");

const SUPERSCRIPT = { "-": "\u207b", 0: "\u2070", 1: "\u00b9", 2: "\u00b2", 3: "\u00b3", 4: "\u2074", 5: "\u2075", 6: "\u2076", 7: "\u2077", 8: "\u2078", 9: "\u2079" };

export function scientific(value, digits = 1) {
  if (value == null || !Number.isFinite(value)) return NONE;
  if (value === 0) return "0";
  const [mantissa, exponent] = value.toExponential(digits).split("e");
  const power = [...String(Number(exponent))].map((c) => SUPERSCRIPT[c]).join("");
  return `${mantissa.replace("-", "\u2212")}\u00d710${power}`;
}

const pad = (n) => String(n).padStart(2, "0");

// A moment of a run that ends at `end`, on a clock of minutes or hours; `tenths` where a second is too long.
function moment(t, end, tenths) {
  const unit = tenths ? 10 : 1;
  const size = tenths ? Math.round(Math.abs(t) * unit) : Math.floor(Math.abs(t) + 1e-9);
  const whole = Math.floor(size / unit);
  const [hours, minutes, seconds] = [Math.floor(whole / 3600), Math.floor((whole % 3600) / 60), whole % 60];
  const clock = longerThan(end).symbol === "h" ? `${hours}:${pad(minutes)}:${pad(seconds)}` : `${60 * hours + minutes}:${pad(seconds)}`;
  return `${t < 0 && size > 0 ? "\u2212" : ""}${clock}${tenths ? `.${size % unit}` : ""}`;
}

// The unit of a time axis that ends at `end` seconds.
export function longerThan(end) {
  if (end > 3 * 3600) return { symbol: "h", per: 3600 };
  return end > 180 ? { symbol: "min", per: 60 } : { symbol: "s", per: 1 };
}

// Every moment on the page is told by this rule, and by models/moments.py where the server tells it; durations are in s.
export function clockText(t, end, { digits = 1, unit = true, tenths = false } = {}) {
  const { symbol } = longerThan(end);
  return `${symbol === "s" ? fixed(t, digits) : moment(t, end, tenths)}${unit ? ` ${symbol}` : ""}`;
}

// How people read an extension: millimetres, or degrees of what rolls. `snap` is the step of a drag, in SI.
export function extensionScale(unit) {
  return unit === "rad" ? { symbol: "°", per: DEGREES, digits: 1, snap: 1 / DEGREES } : { symbol: "mm", per: 1e3, digits: 2, snap: 1e-4 };
}

// When something was done, short enough for a list; the year only where it is another one.
export function dayAndTime(time) {
  const date = new Date(time);
  const year = date.getFullYear() === new Date().getFullYear() ? undefined : "numeric";
  return date.toLocaleString(undefined, { year, month: "short", day: "numeric", hour: "2-digit", minute: "2-digit" });
}

export function clockTime(iso) {
  const date = new Date(iso);
  if (Number.isNaN(date.getTime())) return "";
  return date.toLocaleTimeString([], { hour: "2-digit", minute: "2-digit" });
}
