// Says a bound, and the number that broke it, in the unit of the field's box: documents and their refusals are in SI.

import { unitNow } from "./unitchoice.js";

const BROKEN = /^a number (of at least|above|of at most|below) (\S+) is wanted, not (\S+)$/;
const FIGURES = 7;

const units = new Map(); // of the fields shown so far, by pointer

export function rememberUnit({ pointer, quantity, unit }) {
  if (pointer && quantity) units.set(pointer, { quantity, unit });
}

// The same problem of a field that the page has shown, in the unit shown there; any other as it is.
export function inUnits(error) {
  const [, how, bound, value] = BROKEN.exec(error.message ?? "") ?? [];
  const known = units.get(error.pointer);
  if (!how || !known) return error;
  const { per, symbol } = unitNow(known.quantity, known.unit);
  const say = (given) => `${Number((Number(given) * per).toPrecision(FIGURES))} ${symbol}`.trim().replace("-", "\u2212");
  return { ...error, message: `${say(value)}: ${how.replace("of ", "")} ${say(error.limit ?? bound)} is wanted`, limit: null };
}
