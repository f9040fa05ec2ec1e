// The last rejected change, where pointers into the document lead, and the notes laid over the 3D view.

import { $, el, flash, setText } from "./dom.js";
import { fieldWords } from "./fieldwords.js";
import { focusField } from "./parts.js";
import { problemNodes } from "./problem.js";
import { connectWarnings } from "./warnings.js";

const FORCES = "/vehicle/hydrodynamics";
const COMPONENT = /^\/vehicle\/components\/(\d+)/;
const LANE = /^\/mission\/control\/schedules\/(\d+)(?:\/points\/(\d+))?/;
const OURS = /^\/(vehicle|mission|name|notes)(\/|$)/; // what is said of a request has no field on the page

const linkButton = (pointer, label, onclick) => el("button", { type: "button", class: "link", title: pointer, onclick }, label);

// Chooses the cell, and gives its point, or its lane, the focus.
function showLane(cell, k) {
  const found = (name) => document.querySelector(`[data-testid=${CSS.escape(name)}]`);
  const lane = found(`lane-${cell}`);
  if (!lane) return;
  lane.querySelector(".lane-name").click();
  (found(`point-${cell}-${k}`) ?? lane.querySelector(".lane-name")).focus();
  lane.scrollIntoView({ block: "nearest" });
  flash(lane);
}

function laneLink(pointer, state) {
  const [, index, k] = LANE.exec(pointer) ?? [];
  if (index === undefined) return null;
  const schedule = state.schedules.find((s) => s.index === Number(index));
  if (!schedule) return linkButton(pointer, "Show the schedules", () => flash($("lanes"))); // refused: it is not there
  const point = schedule.points[k] ? `point ${Number(k) + 1}` : "schedule";
  return linkButton(pointer, `Show ${schedule.cell}, ${point}`, () => showLane(schedule.cell, k));
}

function linkWords(pointer, state) {
  const component = state.components[Number(COMPONENT.exec(pointer)?.[1])];
  if (component) return [component.name, fieldWords(pointer, 3)].filter(Boolean).join(": ");
  return /^\/vehicle\/components/.test(pointer) ? "the list of parts" : fieldWords(pointer);
}

// A pointer to a schedule leads to its lane, one into the force data to their dialog, any other to its field at the left.
export function pointerLink(state, { showForces }) {
  return (pointer) => {
    if (!state || !OURS.test(pointer ?? "")) return null;
    if (pointer.startsWith(FORCES)) return linkButton(pointer, "Show the force data", showForces);
    return laneLink(pointer, state) ?? linkButton(pointer, `Show ${linkWords(pointer, state)}`, () => focusField(pointer));
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
