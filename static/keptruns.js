// The runs that are kept to compare with, and any output of them or of the present run as a curve.

import { call } from "./api.js";
import { clockText } from "./format.js";

export const CURRENT = "current";
const MOST_CACHED = 24;

export const keepRun = (name) => call("POST", "runs", name ? { name } : {});
export const renameRun = (id, name) => call("PATCH", `runs/${encodeURIComponent(id)}`, { name });
export const forgetRun = (id) => call("DELETE", `runs/${encodeURIComponent(id)}`);
export const getOutputs = () => call("GET", "outputs");
export const isReady = ({ state }) => state === "ready"; // after a restart of the server it is computed anew
export const colorOf = (kept) => `var(--kept-${kept.place + 1})`;

// What its row says beside its name.
export function aboutKept(kept) {
  if (isReady(kept)) return `${kept.model} · ${clockText(kept.end, kept.end)}`;
  return kept.state === "failed" ? "not computable" : "computed anew…";
}

const cache = new Map(); // key: run, its revision where it is the present one, and names

// {t, columns, units, missing} of a run; a kept run never changes, the present one with its number.
export async function columnsOf(id, names, number = 0) {
  const key = [id, id === CURRENT ? number : 0, ...names].join("\n");
  if (!cache.has(key)) {
    if (cache.size >= MOST_CACHED) cache.delete(cache.keys().next().value);
    const asked = call("GET", `runs/${encodeURIComponent(id)}/columns?${new URLSearchParams(names.map((name) => ["name", name]))}`);
    cache.set(key, asked);
    asked.catch(() => cache.delete(key));
  }
  return cache.get(key);
}
