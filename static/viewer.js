// The only module that knows the viewer's client: it pushes messages into the iframe's own queue.
// The hook is the client's test hook, not a promise: detected anew each time, and without it the server moves the scene.

import { messages } from "./nodemessages.js";
import { annotated } from "./picture.js";
import { labelChoice } from "./scenelabels.js";
import { applySkin, mendOutlines } from "./viewerskin.js";

const HOOK_PATIENCE = 8000; // ms after the iframe's load before the fallback starts
const CHECK_EVERY = 300; // ms between comparisons of wanted and shown
const FALLBACK_EVERY = 50; // ms between clock posts: 20 Hz
const PICTURE_DPR = 1; // at least so many of the canvas's pixels to one of the page's in a saved picture
const SHARPEN_FRAMES = 30;
const RETURN_PATIENCE = 3000; // ms the client has to come back by itself once the server answers again
const RELOAD_EVERY = [10000, 20000, 40000, 60000]; // ms; longer each time, as a slow machine loads the client slowly

const differs = (a, b) => {
  if (a === b) return false;
  if (typeof a !== "object" || typeof b !== "object" || !a || !b) return true;
  return a.length !== b.length || [...a].some((v, i) => Math.abs(v - b[i]) > 1e-7);
};

// The state of the client's renderer (react-three-fiber keeps it at the scene), or null where it is kept elsewhere.
function rendererOf({ scene }) {
  const state = scene?.__r3f?.root?.getState?.();
  return typeof state?.setDpr === "function" && state.viewport?.dpr > 0 ? state : null;
}

// Draws as many pixels as the page has, where the client was told to draw fewer; resolves when it has, or in vain.
async function sharpen(mutable, renderer) {
  const before = mutable.canvas.width;
  renderer.setDpr(PICTURE_DPR);
  mutable.requestRender();
  const frame = () => new Promise((resolve) => mutable.canvas.ownerDocument.defaultView.requestAnimationFrame(resolve));
  for (let k = 0; k < SHARPEN_FRAMES && mutable.canvas.width === before; k += 1) await frame();
  mutable.requestRender();
  for (let k = 0; k < 3; k += 1) await frame();
}

export class Viewer {
  constructor(iframe, { visibilityOf, onLink, onKey, onGrab, postClock }) {
    Object.assign(this, { iframe, visibilityOf, onLink, onKey, onGrab, postClock });
    this.wanted = new Map();
    this.poseUpdates = 0;
    this.loadedAt = performance.now();
    this.lostSince = null;
    this.lastPost = 0;
    this.everReady = false;
    this.online = true;
    this.expectSince(performance.now());
    this.checks = setInterval(() => this.check(), CHECK_EVERY);
  }

  // Whether the server answers, as the page's event stream tells.
  setOnline(online) {
    if (online && !this.online) this.expectSince(performance.now());
    this.online = online;
  }

  // From here the client has its time to come back by itself.
  expectSince(now) {
    this.reloads = 0;
    this.nextReload = now + RETURN_PATIENCE;
  }

  // What is seen now, as a PNG with `notes` over it; null where the client shows nothing. Its canvas keeps what it drew.
  async picture(notes) {
    const mutable = this.hook();
    if (!mutable?.canvas) return null;
    const { canvas } = mutable;
    const renderer = rendererOf(mutable);
    const dpr = renderer?.viewport.dpr;
    const finer = renderer && dpr < PICTURE_DPR;
    if (finer) await sharpen(mutable, renderer);
    try {
      return await annotated(canvas, { width: canvas.clientWidth, height: canvas.clientHeight }, notes);
    } finally {
      if (finer) {
        renderer.setDpr(dpr);
        mutable.requestRender();
      }
    }
  }

  // Asked for at each check: a load event may have come before this module ran.
  greet() {
    const doc = this.iframe.contentDocument;
    if (!doc || doc === this.greeted || doc.readyState !== "complete" || doc.URL === "about:blank") return;
    this.greeted = doc;
    this.loadedAt = performance.now();
    applySkin(doc);
    // Keys pressed after a click into the scene still drive the page's clock.
    this.iframe.contentWindow?.addEventListener("keydown", this.onKey);
    this.iframe.contentWindow?.addEventListener("pointerdown", () => this.onGrab(), { capture: true });
  }

  // The client's mutable state, or null as long as (or in a version where) it offers no such hook.
  hook() {
    try {
      const mutable = this.iframe.contentWindow?.__viserMutable;
      const usable = Array.isArray(mutable?.messageQueue) && typeof mutable.requestRender === "function";
      return usable ? mutable : null;
    } catch {
      return null; // an error page of another origin
    }
  }

  tree() {
    return this.iframe.contentWindow?.__viserSceneTree?.getState?.() ?? null;
  }

  // Shows this moment: poses always, scales (which cost the client more) only when they changed.
  show(wanted, t) {
    const before = this.wanted;
    this.wanted = wanted;
    const mutable = this.hook();
    if (!mutable) return this.showByServer(t);
    const tree = this.tree();
    for (const [name, node] of wanted) {
      // A node that the scene does not have would leave its message behind as a stray pose.
      if (tree && !(name in tree)) continue;
      for (const [key, value] of Object.entries(node)) {
        if (key !== "scale" || differs(before.get(name)?.scale, value)) mutable.messageQueue.push(messages[key](name, value));
      }
    }
    mutable.requestRender();
    this.poseUpdates += 1;
  }

  showByServer(t) {
    const now = performance.now();
    clearTimeout(this.lastTimer);
    if (!this.online || this.iframe.hidden) return; // hidden: this browser draws nothing
    if (now - this.loadedAt < HOOK_PATIENCE && !this.everReady) return;
    const wait = this.lastPost + FALLBACK_EVERY - now;
    if (wait > 0) {
      this.lastTimer = setTimeout(() => this.showByServer(t), wait);
      return;
    }
    this.lastPost = now;
    this.postClock(t).catch(() => {}); // the connection notice already says it
  }

  // The server may rebuild nodes or the client reconnect at any time: compare, and push what differs.
  check() {
    this.greet();
    const mutable = this.hook();
    this.watchLink(mutable);
    if (!mutable) return;
    this.everReady = true;
    mendOutlines(mutable.scene);
    const tree = this.tree();
    if (!tree || mutable.messageQueue.length > 0) return;
    const corrections = [];
    for (const [name, node] of this.wanted) {
      if (name in tree) this.compare(corrections, name, node, tree[name], mutable.nodePoseData?.[name]);
    }
    this.compareVisibility(corrections, tree, labelChoice(mutable, tree));
    if (corrections.length === 0) return;
    mutable.messageQueue.push(...corrections);
    mutable.requestRender();
  }

  compare(corrections, name, wanted, node, pose) {
    const shown = { position: pose?.position, wxyz: pose?.wxyz, scale: node.message?.props?.scale };
    for (const [key, value] of Object.entries(wanted)) {
      if (differs(shown[key], value)) corrections.push(messages[key](name, value));
    }
  }

  compareVisibility(corrections, tree, labelShown) {
    for (const [name, node] of Object.entries(tree)) {
      const visible = this.visibilityOf(name) ?? labelShown(name);
      if (visible !== null && (node?.visibility ?? true) !== visible) corrections.push(messages.visible(name, visible));
    }
  }

  // Lost: a client that says so, one that was there and is gone, or an error page (of another origin: no document).
  lost(mutable) {
    const silent = mutable ? String(mutable.sendMessage).includes("not connected") : this.everReady || this.iframe.contentDocument === null;
    // A first load has its time to connect; a load that is itself a retry must not look like a success meanwhile.
    return silent && (this.lostSince !== null || performance.now() - this.loadedAt > 3000);
  }

  // The client reconnects only while its document has focus, so a lost link is given focus, then a new load.
  // Without a server a load would end on the browser's error page, which never comes back by itself.
  watchLink(mutable) {
    const now = performance.now();
    if (!this.lost(mutable)) {
      if (this.lostSince !== null) this.regained();
      return;
    }
    if (this.lostSince === null) {
      this.lostSince = now;
      this.expectSince(now);
      this.focusBefore = document.activeElement;
      this.onLink(false);
    }
    if (!this.online || document.visibilityState === "hidden") return;
    if (now > this.nextReload) {
      this.nextReload = now + RELOAD_EVERY[Math.min(this.reloads, RELOAD_EVERY.length - 1)];
      this.reloads += 1;
      this.iframe.src = this.iframe.src; // the same address anew; an error page's own reload is out of reach
    } else if (mutable && !this.typing()) this.iframe.contentWindow.focus();
  }

  typing() {
    return /^(INPUT|SELECT|TEXTAREA)$/.test(document.activeElement?.tagName ?? "");
  }

  regained() {
    this.lostSince = null;
    this.onLink(true);
    if (document.activeElement === this.iframe) {
      this.iframe.blur();
      this.focusBefore?.focus?.({ preventScroll: true });
    }
  }
}
