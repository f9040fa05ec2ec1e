// Buttons over the 3D view: where to look from, and what to show.

import { $ } from "./dom.js";

const TOGGLES = { "toggle-follow": "follow", "toggle-forces": "forces", "toggle-centers": "centers", "toggle-path": "path" };

export function connectOverlays({ store, setCamera }) {
  const change = (part) => store.set({ view: { ...store.get("view"), ...part } });
  for (const [id, key] of Object.entries(TOGGLES)) {
    $(id).addEventListener("click", () => change({ [key]: !store.get("view")[key] }));
  }
  $("exaggeration").addEventListener("change", () => change({ exaggeration: Number($("exaggeration").value) }));
  for (const button of document.querySelectorAll("[data-camera]")) {
    button.addEventListener("click", () => {
      change({ camera: button.dataset.camera });
      setCamera(button.dataset.camera);
    });
  }
  store.watch(["view"], ({ view }) => {
    for (const [id, key] of Object.entries(TOGGLES)) $(id).setAttribute("aria-pressed", String(view[key]));
    for (const button of document.querySelectorAll("[data-camera]")) {
      button.setAttribute("aria-pressed", String(button.dataset.camera === view.camera));
    }
  });
}
