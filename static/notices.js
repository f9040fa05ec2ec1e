// Warnings, the last rejected change, and the notes laid over the 3D view.

import { $, el, setText } from "./dom.js";
import { problemNodes } from "./problem.js";

const COMPONENT = /^\/vehicle\/components\/(\d+)/;

const POINT = /^\/mission\/control\/schedules\/(\d+)\/points\/(\d+)/;

const FORCES = "/vehicle/hydrodynamics";

const linkButton = (pointer, label, onclick) => el("button", { type: "button", class: "link", title: pointer, onclick }, label);

function pointLink(pointer, state) {
  const [, index, k] = POINT.exec(pointer) ?? [];
  const schedule = state?.schedules.find((s) => s.index === Number(index));
  if (!schedule?.points[k]) return null;
  const id = CSS.escape(`point-${schedule.cell}-${k}`);
  return linkButton(pointer, `Show ${schedule.cell}, point ${Number(k) + 1}`, () => document.querySelector(`[data-testid=${id}]`)?.focus());
}

// A pointer to a point leads to its lane, one into a component to its folder in the editor, one into the force data
// to their dialog; any other is shown as it is.
function pointerLink(state, { select, showForces }) {
  return (pointer) => {
    const point = pointLink(pointer, state);
    if (point) return point;
    if (pointer.startsWith(FORCES)) return linkButton(pointer, "Show the force data", showForces);
    const index = COMPONENT.exec(pointer)?.[1];
    const component = index === undefined ? null : state?.components[Number(index)];
    if (!component) return el("span", { class: "where" }, pointer);
    const field = pointer.split("/").slice(4).join(" ").replaceAll("_", " ");
    return linkButton(pointer, `Show ${component.name}${field ? `: ${field}` : ""}`, () => select(component.index));
  };
}

// One line until it is opened; the line holds the whole text, which only the eye sees cut.
const warningNode = (message, more, open) =>
  el("details", { class: "box", open }, el("summary", { title: message }, message), more);

function showWarnings(state, link) {
  const warnings = state.warnings ?? [];
  $("warnings-panel").hidden = warnings.length === 0;
  setText($("warnings-title"), warnings.length > 1 ? `Warnings · ${warnings.length}` : "Warnings");
  const open = new Set([...$("warnings").querySelectorAll("details[open] summary")].map((node) => node.textContent));
  const nodes = warnings.map(({ message, pointer }) => warningNode(message, pointer ? link(pointer) : null, open.has(message)));
  // Anew only where they differ: a rebuilt one would lose the focus.
  const same = nodes.length === $("warnings").children.length && nodes.every((node, i) => node.isEqualNode($("warnings").children[i]));
  if (!same) $("warnings").replaceChildren(...nodes);
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

export function connectNotices({ store, select, showForces }) {
  store.watch(["state", "rejected"], ({ state, rejected }) => {
    const link = pointerLink(state, { select, showForces });
    showProblem(rejected ?? state?.problem, state, link);
    if (state) showWarnings(state, link);
  });
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
