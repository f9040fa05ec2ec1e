// The units in which people read and type the document's fields: a choice for each quantity, kept in this browser.

const KEY = "glider-studio.units";
const DEGREES = 180 / Math.PI;
const HEAVY = 5; // kg

// Of each quantity the units by symbol: how many make the SI unit, decimals worth showing, and the step of an arrow key.
// The first is what people see who never chose.
const QUANTITIES = {
  length: [["mm", 1e3, 1, 1], ["cm", 1e2, 2, 0.1], ["m", 1, 4, 0.001]],
  distance: [["m", 1, 2, 0.1], ["mm", 1e3, 0, 10], ["km", 1e-3, 5, 0.001]],
  area: [["cm²", 1e4, 2, 0.1], ["mm²", 1e6, 0, 10], ["m²", 1, 6, 1e-5]],
  volume: [["cm³", 1e6, 1, 1], ["dm³", 1e3, 4, 0.001], ["m³", 1, 7, 1e-6]],
  mass: [["g", 1e3, 1, 1], ["kg", 1, 3, 0.001]],
  inertia: [["kg cm²", 1e4, 2, 0.1], ["kg m²", 1, 6, 1e-5]],
  angle: [["°", DEGREES, 1, 1], ["rad", 1, 4, 0.01]],
  turning: [["°/s", DEGREES, 2, 0.1], ["rad/s", 1, 4, 0.001]],
  pressure: [["kPa", 1e-3, 1, 1], ["Pa", 1, 0, 1000], ["MPa", 1e-6, 4, 1], ["bar", 1e-5, 2, 1]],
  rate: [["mm/s", 1e3, 2, 0.1], ["cm/s", 1e2, 3, 0.01], ["m/s", 1, 5, 1e-4]],
  speed: [["m/s", 1, 3, 0.01], ["cm/s", 1e2, 1, 1], ["kn", 1 / 0.514444, 3, 0.01]],
  time: [["s", 1, 2, 0.1], ["min", 1 / 60, 3, 0.1], ["h", 1 / 3600, 4, 0.01]],
  pause: [["ms", 1e3, 2, 1], ["s", 1, 5, 0.001]],
  share: [["%", 1e2, 1, 1], ["", 1, 3, 0.01]],
  density: [["kg/m³", 1, 2, 0.1], ["g/cm³", 1e-3, 5, 1e-4]],
  force: [["N", 1, 4, 0.01], ["mN", 1e3, 1, 1]],
  moment: [["N m", 1, 5, 0.001], ["mN m", 1e3, 2, 1]],
  power: [["W", 1, 2, 0.1], ["mW", 1e3, 0, 10]],
};

const OF_UNIT = {
  m: "length", m2: "area", m3: "volume", kg: "mass", "kg m2": "inertia", rad: "angle", "rad/s": "turning", Pa: "pressure",
  "m/s": "rate", s: "time", "kg/m3": "density", N: "force", "N m": "moment", W: "power",
};
// Outside of the vehicle lengths are distances, and velocities those of water and glider.
const OUTSIDE = { length: "distance", rate: "speed" };

const POWERS = { 2: "²", 3: "³", 4: "⁴" };
const written = (unit) => (unit === "1" ? "" : unit.replace(/([A-Za-z])([234])(?!\d)/g, (_, letter, power) => letter + POWERS[power]).replace(/^deg$/, "°").replace("degC", "°C"));

const asUnit = ([symbol, per, digits, step]) => ({ symbol, per, digits, step });

function read() {
  try {
    return JSON.parse(localStorage.getItem(KEY)) ?? {};
  } catch {
    return {}; // storage may be forbidden, or hold what another page wrote
  }
}

let chosen = read();
let usual = {}; // what suits this vehicle, for who never chose
const listeners = new Set();

// What a field of a unit measures, at a pointer of the document; null where it has one unit alone.
export function quantityOf(unit, pointer, name) {
  if (/^(efficiency|recovery|deadband)$/.test(name)) return "share";
  if (/^\/mission\/solver\/step$/.test(pointer)) return "pause";
  const quantity = OF_UNIT[unit] ?? null;
  const outside = pointer.startsWith("/mission") && !/\/(extensions|schedules)\b|extension/.test(pointer);
  return outside ? (OUTSIDE[quantity] ?? quantity) : quantity;
}

export function unitsOf(quantity, unit) {
  return quantity ? QUANTITIES[quantity].map(asUnit) : [asUnit([written(unit ?? "1"), 1, 0, 0.01])];
}

export function unitNow(quantity, unit) {
  const units = unitsOf(quantity, unit);
  return units.find(({ symbol }) => symbol === (chosen[quantity] ?? usual[quantity])) ?? units[0];
}

export function chooseUnit(quantity, symbol) {
  chosen = { ...chosen, [quantity]: symbol };
  try {
    localStorage.setItem(KEY, JSON.stringify(chosen));
  } catch {
    // It holds until the page closes.
  }
  for (const listener of listeners) listener();
}

// A heavy vehicle is read in kilograms and litres.
export function suitUnits(mass) {
  usual = mass < HEAVY ? {} : { mass: "kg", volume: "dm³" };
}

export function nextUnit(quantity, unit) {
  const units = unitsOf(quantity, unit);
  const k = units.findIndex(({ symbol }) => symbol === unitNow(quantity, unit).symbol);
  chooseUnit(quantity, units[(k + 1) % units.length].symbol);
}

export const onUnits = (listener) => listeners.add(listener);

// The number as it stands in a box: the unit's decimals, or as many more as it has itself (at most seven figures).
export function shown(value, unit) {
  if (value == null) return "";
  const there = value * unit.per;
  const near = there.toFixed(unit.digits);
  const same = Math.abs(Number(near) - there) <= 1e-9 * Math.max(Math.abs(there), 10 ** -unit.digits);
  const text = same ? near : String(Number(there.toPrecision(7)));
  return (Number(text) === 0 ? text.replace("-", "") : text).replace("-", "\u2212");
}

const plain = (symbol) => symbol.replace("²", "2").replace("³", "3").replace("°", "deg").replaceAll(" ", "").toLowerCase();

const NUMBER = /^([+-]?(?:\d+\.?\d*|\.\d+)(?:e[+-]?\d+)?)\s*(.*)$/i;

// What was typed, in SI: a number in the unit shown, or with one of its own ("1.2 cm"); null where it is neither.
export function typed(text, quantity, unit) {
  const found = NUMBER.exec(text.trim().replaceAll("\u2212", "-").replace(/^([+-]?\d+),(\d+)/, "$1.$2"));
  if (!found) return null;
  const [, number, suffix] = found;
  const units = unitsOf(quantity, unit);
  const meant = suffix === "" ? unitNow(quantity, unit) : units.find(({ symbol }) => plain(symbol) === plain(suffix));
  return meant ? Number((Number(number) / meant.per).toPrecision(12)) : null;
}
