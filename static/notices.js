// The last rejected change, where pointers into the document lead, and the notes laid over the 3D view.

import { $, el, setText } from "./dom.js";
import { focusField } from "./parts.js";
import { problemNodes } from "./problem.js";
import { connectWarnings } from "./warnings.js";

const FORCES = "/vehicle/hydrodynamics";
const COMPONENT = /^\/vehicle\/components\/(\d+)/;
const POINT = /^\/mission\/control\/schedules\/(\d+)\/points\/(\d+)/;

const linkButton = (pointer, label, onclick) => el("button", { type: "button", class: "link", title: pointer, onclick }, label);

function pointLink(pointer, state) {
  const [, index, k] = POINT.exec(pointer) ?? [];
  const schedule = state?.schedules.find((s) => s.index === Number(index));
  if (!schedule?.points[k]) return null;
  const id = CSS.escape(`point-${schedule.cell}-${k}`);
  return linkButton(pointer, `Show ${schedule.cell}, point ${Number(k) + 1}`, () => document.querySelector(`[data-testid=${id}]`)?.focus());
}

const wordsOf = (tokens) => tokens.join(" ").replaceAll("_", " ");

// A pointer to a point leads to its lane, one into the force data to their dialog, any other to its field at the left.
export function pointerLink(state, { showForces }) {
  return (pointer) => {
    if (!pointer) return null;
    const point = pointLink(pointer, state);
    if (point) return point;
    if (pointer.startsWith(FORCES)) return linkButton(pointer, "Show the force data", showForces);
    const component = state?.components[Number(COMPONENT.exec(pointer)?.[1])];
    const tokens = pointer.split("/").slice(1);
    const field = wordsOf(component ? tokens.slice(3) : tokens.slice(-1));
    const label = component ? `Show ${component.name}${field ? `: ${field}` : ""}` : `Show ${field}`;
    return linkButton(pointer, label, () => focusField(pointer));
  };
}

function showProblem(problem, state, link) {
  const box = $("problem");
  box.hidden = !problem;
  if (!problem) return box.replaceChildren();
  const note = problem.status === 422 && state?.run ? "The last good glide is kept." : null;
  box.replaceChildren(...problemNodes(problem, { note, link }));
}

const STATUS = {
  over: "Session over",
  offline: "Connection lost, retrying…",
  compiling: "Compiling the physics…",
  simulating: "Simulating…",
  ready: "Ready",
};

function statusOf({ state, connected, over, busy, awaited }) {
  if (over) return "over";
  if (!connected) return "offline";
  if (!state || state.kernel === "compiling") return "compiling";
  return busy || state.revision < awaited ? "simulating" : "ready";
}

export function connectNotices({ store, clock, showForces }) {
  store.watch(["state", "rejected"], ({ state, rejected }) => {
    showProblem(rejected ?? state?.problem, state, pointerLink(state, { showForces }));
  });
  connectWarnings({ store, clock, link: (pointer) => pointerLink(store.get("state"), { showForces })(pointer) });
  store.watch(["state", "connected", "over", "busy", "awaited", "viewerLinked"], (values) => {
    const status = statusOf(values);
    $("status").dataset.state = status;
    setText($("status"), STATUS[status]);
    // A compiling server may starve the 3D view for a moment: it comes back, so that alone is no news.
    const compiling = values.state?.kernel === "compiling" && values.connected && !values.over;
    $("compiling").hidden = !compiling;
    $("lost").hidden = values.over || (values.connected && (values.viewerLinked || compiling));
    setText($("lost-text"), values.connected ? "The 3D view lost its connection, retrying…" : "Connection lost, retrying…");
  });
}
