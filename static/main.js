// Wires the studio page: one store, one clock, and the views that follow them.

import { connectBookmarks } from "./bookmarks.js";
import { Clock } from "./clock.js";
import { connectCompare } from "./compare.js";
import { $ } from "./dom.js";
import { connectExports } from "./exports.js";
import { connectHeader } from "./header.js";
import { pressKey } from "./keys.js";
import { connectLayout } from "./layout.js";
import { connectModes } from "./modes.js";
import { connectMomentLink, startAt } from "./momentlink.js";
import { connectNotices } from "./notices.js";
import { connectNumerics } from "./numerics.js";
import { connectOverlays } from "./overlays.js";
import { connectParts } from "./parts.js";
import { connectPlayedRange } from "./playedrange.js";
import { connectPolar } from "./polar.js";
import { connectReadouts } from "./readouts.js";
import { rememberSession } from "./recent.js";
import { connectCorner } from "./scenecorner.js";
import { connectLegend } from "./scenelegend.js";
import { connectScene } from "./sceneshow.js";
import { createActions, follow } from "./session.js";
import { createStore } from "./store.js";
import { connectSaving } from "./stored.js";
import { Timeline } from "./timeline.js";
import { connectTransport } from "./transport.js";
import { connectTrimFor } from "./trimfor.js";

const store = createStore({
  state: null,
  consequences: null,
  warnings: [],
  focusedWarning: null,
  connected: true,
  over: false,
  viewerLinked: true,
  busy: 0,
  awaited: 0,
  rejected: null,
  rejectedHere: false,
  bookmarks: [],
  reference: null,
  view: { follow: true, forces: true, moments: false, centers: true, path: true, exaggeration: 10, offset: 50, camera: null, ghost: null },
});
const clock = new Clock();

const actions = createActions(store);

const viewer = connectScene({
  store,
  clock,
  onKey: (event) => {
    saving.press(event);
    if (!event.key?.startsWith("Arrow")) pressKey(event); // arrows move the camera there
  },
});

connectHeader({ store, actions });
const saving = connectSaving(store);
connectMomentLink({ store, clock });
startAt({ store, clock });
const polar = connectPolar({ store, clock });
connectParts({ store, actions, showForces: polar.open });
connectNotices({ store, clock, showForces: polar.open });
connectModes({ store, clock });
connectTrimFor({ store, clock, actions });
connectNumerics({ store, showForces: polar.open });
connectOverlays({ store, setCamera: actions.camera });
connectLegend({ store, clock, actions });
connectCorner({ viewer });
connectReadouts({ store, clock });
connectTransport({ store, clock });
connectBookmarks({ store, clock });
connectPlayedRange({ store, clock });
connectCompare({ store });
connectExports({ store, clock, viewer });
connectLayout();
const timeline = new Timeline({ store, clock, actions });
rememberSession(store);
follow(store, actions);

// For tests: what the page knows, and how often it moved the scene.
window.__studio = {
  clock,
  timeline,
  get state() { return store.get("state"); },
  get consequences() { return store.get("consequences"); },
  get view() { return store.get("view"); },
  get poseUpdates() { return viewer.poseUpdates; },
};
