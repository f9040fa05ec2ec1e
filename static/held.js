// The holds of the schedule: which one is in force at a moment, and how its times are written.

import { clockText } from "./format.js";

// The hold whose stretch began last before t; the first one before any has begun. {hold, index, span} or null.
export function heldAt(consequences, t) {
  let found = null;
  for (const [index, hold] of (consequences?.holds ?? []).entries()) {
    for (const span of hold.spans) {
      if (!hold.reached) continue;
      const begun = span[0] <= t + 1e-9;
      const better = !found || (begun ? found.span[0] > t || span[0] > found.span[0] : found.span[0] > t && span[0] < found.span[0]);
      if (better) found = { hold, index, span };
    }
  }
  return found;
}

// Whether a moment lies in a hold that is left out; `found` is the one shown in its place.
export function isLeftOut(consequences, t, found) {
  const from = found && found.span[0] <= t + 1e-9 ? found.span[0] : -Infinity;
  return (consequences?.left_out_spans ?? []).some(([begin, end]) => begin > from && begin <= t + 1e-9 && t <= end + 1e-9);
}

const digitsOf = (t) => (Number.isInteger(t) ? 0 : 1);

export const spanText = ([from, to], end) => `${clockText(from, end, { unit: false, digits: digitsOf(from) })}–${clockText(to, end, { digits: digitsOf(to) })}`;

export function spansText(spans, end) {
  const [first] = spans;
  return spans.length > 1 ? `${spanText(first, end)} and ${spans.length - 1} more` : spanText(first, end);
}
