// Warnings, the last rejected change, and the notes laid over the 3D view.

import { $, el, setText } from "./dom.js";
import { problemNodes } from "./problem.js";

const COMPONENT = /^\/vehicle\/components\/(\d+)/;

// A pointer into a component leads to its folder in the editor; any other is shown as it is.
function pointerLink(state, select) {
  return (pointer) => {
    const index = COMPONENT.exec(pointer)?.[1];
    const component = index === undefined ? null : state?.components[Number(index)];
    if (!component) return el("span", { class: "where" }, pointer);
    const field = pointer.split("/").slice(4).join(" ").replaceAll("_", " ");
    return el("button", { type: "button", class: "link", title: pointer, onclick: () => select(component.index) },
      `Show ${component.name}${field ? `: ${field}` : ""}`);
  };
}

function showWarnings(state, link) {
  const warnings = state.warnings ?? [];
  $("warnings-title").hidden = warnings.length === 0;
  $("warnings").replaceChildren(...warnings.map(({ message, pointer }) =>
    el("div", { class: "box" }, el("p", {}, message), pointer ? link(pointer) : null)));
}

function showProblem(problem, state, link) {
  const box = $("problem");
  box.hidden = !problem;
  if (!problem) return box.replaceChildren();
  const note = problem.status === 422 && state?.run ? "The last good glide is kept." : null;
  box.replaceChildren(...problemNodes(problem, { note, link }));
}

const STATUS = {
  offline: "Connection lost, retrying…",
  compiling: "Compiling the physics…",
  simulating: "Simulating…",
  ready: "Ready",
};

function statusOf({ state, connected, busy }) {
  if (!connected) return "offline";
  if (!state || state.kernel === "compiling") return "compiling";
  return busy ? "simulating" : "ready";
}

export function connectNotices({ store, select }) {
  store.watch(["state", "rejected"], ({ state, rejected }) => {
    const link = pointerLink(state, select);
    showProblem(rejected ?? state?.problem, state, link);
    if (state) showWarnings(state, link);
  });
  store.watch(["state", "connected", "busy", "viewerLinked"], (values) => {
    const status = statusOf(values);
    $("status").dataset.state = status;
    setText($("status"), STATUS[status]);
    $("compiling").hidden = values.state?.kernel !== "compiling";
    $("lost").hidden = values.connected && values.viewerLinked;
    setText($("lost-text"), values.connected ? "The 3D view lost its connection, retrying…" : "Connection lost, retrying…");
  });
}
