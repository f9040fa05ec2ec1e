// Wires the studio page: one store, one clock, and the views that follow them.

import { postClock } from "./api.js";
import { Clock } from "./clock.js";
import { $ } from "./dom.js";
import { connectHeader } from "./header.js";
import { connectMomentLink, startAt } from "./momentlink.js";
import { connectNotices } from "./notices.js";
import { connectOverlays } from "./overlays.js";
import { connectPolar } from "./polar.js";
import { connectReadouts } from "./readouts.js";
import { rememberSession } from "./recent.js";
import { bedInSight, largestForce, pathBox, positionAt, sceneAt, visibility } from "./scene.js";
import { createActions, follow } from "./session.js";
import { createStore } from "./store.js";
import { connectSaving } from "./stored.js";
import { Timeline } from "./timeline.js";
import { connectTransport, pressKey } from "./transport.js";
import { Viewer } from "./viewer.js";

const store = createStore({
  state: null,
  connected: true,
  over: false,
  viewerLinked: true,
  busy: 0,
  awaited: 0,
  rejected: null,
  rejectedHere: false,
  view: { follow: true, forces: true, centers: true, path: true, exaggeration: 10, camera: null },
});
const clock = new Clock();

// On a machine without graphics hardware a coarser 3D picture plays smoothly: ?fixedDpr=0.5
const dpr = Number(new URLSearchParams(location.search).get("fixedDpr"));
if (dpr > 0) $("view").src = `view/?fixedDpr=${dpr}`;

const actions = createActions(store);

// Without a run there is nothing to point the arrows by.
function shown() {
  const view = store.get("view");
  const run = store.get("state")?.run;
  const bed = bedInSight(store.get("state"), clock.t);
  return { ...view, forces: view.forces && Boolean(run), spatial: run?.model === "spatial", bed };
}

const viewer = new Viewer($("view"), {
  visibilityOf: (name) => visibility(name, shown()),
  onDock: (left) => document.documentElement.style.setProperty("--dock", `${left}px`),
  onLink: (viewerLinked) => store.set({ viewerLinked }),
  onKey: (event) => {
    saving.press(event);
    if (event.key === " ") pressKey(event, clock);
  },
  postClock,
});

const BEACON = 0.012; // of the path's size: how large the ball that stands for the glider is in the overview
let largest = 0;
let anchor = null; // what the view stays on: the glider, or where it was when following was turned off
function showScene() {
  const state = store.get("state");
  if (!state?.run) return;
  const { follow: following, exaggeration, camera } = store.get("view");
  const far = camera === "overview" && pathBox(state.run);
  if (far && !following) anchor = far.middle;
  else if (following || !anchor) anchor = positionAt(state.run, clock.t);
  // Chasing means to stay behind: the view turns with the glider.
  viewer.show(sceneAt(state, clock.t, { anchor, exaggeration, largest, turning: camera === "chase", beacon: far && BEACON * far.size }), clock.t);
}

store.watch(["state"], ({ state }) => {
  if (!state) return;
  largest = state.run ? largestForce(state.run.columns) : 0;
  clock.setEnd(state.run?.columns.t.at(-1) ?? 0);
});
store.watch(["connected"], ({ connected }) => viewer.setOnline(connected));
store.watch(["view"], () => {
  showScene();
  viewer.check();
});
clock.watch(showScene);

connectHeader({ store, actions });
const saving = connectSaving(store);
connectMomentLink({ store, clock });
startAt({ store, clock });
const polar = connectPolar({ store, clock });
connectNotices({ store, select: actions.select, showForces: polar.open });
connectOverlays({ store, clock, setCamera: actions.camera });
connectReadouts({ store, clock });
connectTransport(clock);
const timeline = new Timeline({ store, clock, actions });
rememberSession(store);
follow(store);

// For tests: what the page knows, and how often it moved the scene.
window.__studio = {
  clock,
  timeline,
  get state() { return store.get("state"); },
  get view() { return store.get("view"); },
  get poseUpdates() { return viewer.poseUpdates; },
};
