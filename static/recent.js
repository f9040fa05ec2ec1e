// The sessions this browser opened last: kept by the browser, as the server has no list of who opened what.

import { ROOT } from "./root.js";

const MOST = 8;

// Two studios on one host under different paths keep separate lists.
const KEY = `glider-studio.recent:${ROOT.pathname}`;

// Storage may be refused, full, or hold anything: then there is no list, and everything else works.
export function recentSessions() {
  try {
    const items = JSON.parse(localStorage.getItem(KEY)) ?? [];
    return items.filter(({ id, name, time }) => typeof id === "string" && typeof name === "string" && Number.isFinite(time));
  } catch {
    return [];
  }
}

function keep(items) {
  try {
    localStorage.setItem(KEY, JSON.stringify(items.slice(0, MOST)));
  } catch {
    // as above
  }
}

export const forget = (id) => keep(recentSessions().filter((item) => item.id !== id));

export function remember(id, name, time) {
  keep([{ id, name, time }, ...recentSessions().filter((item) => item.id !== id)]);
}

// One after the other: each answer may make the server open the session again.
export async function forgetGone(onGone) {
  for (const { id } of recentSessions()) {
    let response;
    try {
      response = await fetch(`s/${encodeURIComponent(id)}/state`);
    } catch {
      return; // no server, no answer about the rest either
    }
    response.body?.cancel(); // only the status matters
    if (![403, 404].includes(response.status)) continue;
    forget(id);
    onGone();
  }
}

// The studio's page: its session and the design's present name.
export function rememberSession(store) {
  const id = /\/s\/([^/]+)\//.exec(location.pathname)?.[1];
  let known = null;
  store.watch(["state", "over"], ({ state, over }) => {
    if (!id) return;
    if (over) forget(decodeURIComponent(id));
    else if (state && state.name !== known) remember(decodeURIComponent(id), (known = state.name), Date.now());
  });
}
