// What lies over the 3D view: where to look from, what to show, and how much larger than life.

import { $, el } from "./dom.js";
import { aboutKept, isReady } from "./keptruns.js";
import { describeKey, onKey } from "./keys.js";
import { connectMenu } from "./menu.js";

const TOGGLES = { "toggle-follow": "follow", "toggle-forces": "forces", "toggle-moments": "moments", "toggle-centers": "centers", "toggle-path": "path" };
const LATER = 1000; // ms
const SCALES = { exaggeration: "exaggeration", "offset-scale": "offset" };
const KEYS = [ // handled by the client of the 3D view, which has them after a click into it
  ["drag", "A part: along the hull (x), in whole millimetres"], ["Shift+drag", "A part: to port or starboard (y), in three dimensions"],
  ["Ctrl+drag", "A part: up or down (z)"], ["Alt+drag", "A part: without snapping, with Shift or Ctrl too"],
  [["W", "A", "S", "D", "Q", "E"], "After a click there: move the camera ahead, left, back, right, down, up"],
  [["ArrowLeft", "ArrowRight", "ArrowUp", "ArrowDown"], "After a click there: turn the camera; , and . still move the clock"],
];

// How much of the scene, from its top, lies under the buttons.
function coveredShare() {
  const [scene, bar] = [document.querySelector(".scene"), $("scene-bar")].map((node) => node.getBoundingClientRect());
  return Math.min(Math.max((bar.bottom - scene.top) / scene.height, 0), 0.5);
}

export function connectOverlays({ store, setCamera }) {
  const change = (part) => store.set({ view: { ...store.get("view"), ...part } });
  const cameras = [...document.querySelectorAll("[data-camera]")];
  connectMenu($("display"));

  function look(camera) {
    // The overview holds the path still; a view of the glider itself goes with it again.
    const before = store.get("view");
    const follow = camera === "overview" ? false : before.camera === "overview" || before.follow;
    change({ camera, follow });
    setCamera(camera, coveredShare());
  }

  for (const [id, key] of Object.entries(TOGGLES)) {
    $(id).addEventListener("click", () => change({ [key]: !store.get("view")[key] }));
  }
  for (const [id, key] of Object.entries(SCALES)) {
    $(id).addEventListener("change", () => change({ [key]: Number($(id).value) }));
  }
  $("ghost").addEventListener("change", () => {
    const ghost = $("ghost").value || null;
    store.set({ reference: ghost, view: { ...store.get("view"), ghost } });
  });
  cameras.forEach((button, k) => {
    button.addEventListener("click", () => look(button.dataset.camera));
    button.title = `${button.title || `From the ${button.dataset.camera}`} (${k + 1})`;
    onKey(String(k + 1), () => look(button.dataset.camera), { words: `Look: ${button.textContent.toLowerCase()}`, group: "View" });
  });
  for (const [keys, words] of KEYS) describeKey(keys, words, "Scene");
  onKey("f", () => $("toggle-follow").click(), { words: "Follow the glider, or stay", group: "View" });

  // A 3D view that lost its connection comes back from the side; the server hears of it a moment after the page.
  let linked = true;
  store.watch(["viewerLinked"], ({ viewerLinked, view }) => {
    if (viewerLinked && !linked && view.camera) for (const wait of [0, LATER]) setTimeout(() => setCamera(store.get("view").camera, coveredShare()), wait);
    linked = viewerLinked;
  });
  store.watch(["view"], ({ view }) => {
    for (const [id, key] of Object.entries(TOGGLES)) $(id).setAttribute("aria-pressed", String(view[key]));
    for (const [id, key] of Object.entries(SCALES)) $(id).value = String(view[key]);
    for (const button of cameras) button.setAttribute("aria-pressed", String(button.dataset.camera === (view.camera ?? "side")));
  });
  store.watch(["view", "state"], ({ view, state }) => {
    const kept = state?.kept ?? [];
    $("ghost").replaceChildren(el("option", { value: "" }, kept.length ? "None" : "None: keep a glide first"),
      ...kept.map((one) => el("option", { value: one.id }, isReady(one) ? one.name : `${one.name}: ${aboutKept(one)}`)));
    $("ghost").value = kept.some(({ id }) => id === view.ghost) ? view.ghost : "";
    $("ghost").disabled = kept.length === 0;
  });
}
