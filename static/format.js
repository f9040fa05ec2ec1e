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
export const toDegrees = (radians) => radians * DEGREES;

const SUPERSCRIPT = { "-": "\u207b", 0: "\u2070", 1: "\u00b9", 2: "\u00b2", 3: "\u00b3", 4: "\u2074", 5: "\u2075", 6: "\u2076", 7: "\u2077", 8: "\u2078", 9: "\u2079" };

export function scientific(value, digits = 1) {
  if (value == null || !Number.isFinite(value)) return NONE;
  if (value === 0) return "0";
  const [mantissa, exponent] = value.toExponential(digits).split("e");
  const power = [...String(Number(exponent))].map((c) => SUPERSCRIPT[c]).join("");
  return `${mantissa.replace("-", "\u2212")}\u00d710${power}`;
}

export function clockTime(iso) {
  const date = new Date(iso);
  if (Number.isNaN(date.getTime())) return "";
  return date.toLocaleTimeString([], { hour: "2-digit", minute: "2-digit" });
}
