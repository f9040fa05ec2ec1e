// What lies over the 3D view: where to look from, what to show, and the forces in the colours of their arrows.

import { $, setText } from "./dom.js";
import { fixed } from "./format.js";
import { at, locate } from "./series.js";

const TOGGLES = { "toggle-follow": "follow", "toggle-forces": "forces", "toggle-centers": "centers", "toggle-path": "path" };

const FORCES = ["net_buoyancy", "lift", "drag", "side_force"];

function showForces(store, clock) {
  const run = store.get("state")?.run;
  $("forces").hidden = !run || !store.get("view").forces;
  if ($("forces").hidden) return;
  $("force-side").hidden = !run.columns.side_force;
  const place = locate(run.columns.t, clock.t);
  for (const key of FORCES) setText($(`force-${key}`), fixed(at(run.columns[key], place), 4));
}

// How much of the scene, from its top, lies under the buttons and chips.
function coveredShare() {
  const [scene, chips] = [document.querySelector(".scene"), document.querySelector(".top-over")].map((node) => node.getBoundingClientRect());
  return Math.min(Math.max((chips.bottom - scene.top) / scene.height, 0), 0.5);
}

export function connectOverlays({ store, clock, setCamera }) {
  const change = (part) => store.set({ view: { ...store.get("view"), ...part } });
  for (const [id, key] of Object.entries(TOGGLES)) {
    $(id).addEventListener("click", () => change({ [key]: !store.get("view")[key] }));
  }
  $("exaggeration").addEventListener("change", () => change({ exaggeration: Number($("exaggeration").value) }));
  for (const button of document.querySelectorAll("[data-camera]")) {
    button.addEventListener("click", () => {
      // The overview holds the path still; a view of the glider itself goes with it again.
      const before = store.get("view");
      const { camera } = button.dataset;
      const follow = camera === "overview" ? false : before.camera === "overview" || before.follow;
      change({ camera, follow });
      setCamera(camera, coveredShare());
    });
  }
  clock.watch(() => showForces(store, clock));
  store.watch(["view", "state"], () => showForces(store, clock));
  store.watch(["view"], ({ view }) => {
    for (const [id, key] of Object.entries(TOGGLES)) $(id).setAttribute("aria-pressed", String(view[key]));
    for (const button of document.querySelectorAll("[data-camera]")) {
      button.setAttribute("aria-pressed", String(button.dataset.camera === view.camera));
    }
  });
}
