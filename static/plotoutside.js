// Samples that left the data which forces and water come from: when they did, for the ground of plots and for words.

import { trueMinus } from "./format.js";

// Stretches of time from first to last; one where several things are outside at once.
export function outsideStretches(run) {
  const spans = (run?.outside ?? []).flatMap((o) => o.spans).sort((a, b) => a[0] - b[0]);
  const joined = [];
  for (const [a, b] of spans) {
    const last = joined.at(-1);
    if (last && a <= last[1]) last[1] = Math.max(last[1], b);
    else joined.push([a, b]);
  }
  return joined;
}

// What is outside at a moment, in words.
export const outsideAt = (run, t) => (run?.outside ?? []).filter(({ spans }) => spans.some(([a, b]) => t >= a && t <= b)).map(({ what }) => trueMinus(what));
