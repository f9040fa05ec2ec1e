// The player of a replay file: it moves the scene as the studio's page does, and shows the numbers of the moment.
// It knows the viewer's client by the same hook as viewer.js; the file carries the client it was made with.

import { Clock } from "./clock.js";
import { $, el, setText } from "./dom.js";
import { clockText, degrees, fixed } from "./format.js";
import { messages } from "./nodemessages.js";
import { gradientOf, pathLegend } from "./pathlegend.js";
import { largestForce, positionAt, sceneAt, visibility } from "./scene.js";
import { labelChoice } from "./scenelabels.js";
import { angleAt, at, locate } from "./series.js";
import { withUnit } from "./units.js";

const SPEEDS = [0.1, 0.5, 1, 2, 5, 10, 50, 100];
const READ_EVERY = 50; // ms, until the client has taken in the scene
const EXAGGERATION = 10; // of the cells' growth, as the studio begins with
const LABELS_EVERY = 300; // ms between choices of the labels that have room
const ARROWS = [
  ["net_buoyancy", "Net buoyancy", "buoyancy"], ["lift", "Lift", "lift"], ["drag", "Drag", "drag"], ["side_force", "Side force", "side"],
];
const HUD = [
  ["time", "Time", ""], ["depth", "Depth", "m"], ["speed", "Speed", "m/s"], ["pitch", "Pitch", "°"], ["roll", "Roll", "°"],
];

// The numbers of a moment: SI and radians in, what is written on the page out.
export function numbersAt(run, t, end) {
  const place = locate(run.columns.t, t);
  const { columns } = run;
  return {
    time: clockText(t, end), depth: fixed(at(columns.z, place), 3), speed: fixed(at(columns.speed, place), 3),
    pitch: degrees(angleAt(columns.theta, place)), roll: columns.phi ? degrees(angleAt(columns.phi, place)) : degrees(0),
  };
}

// What the arrows and the colours of the path stand for.
function legend({ run, scene }) {
  const arrows = ARROWS.filter(([column]) => run.columns[column] && (column !== "side_force" || run.model === "spatial"));
  const names = arrows.map(([, words, key]) => el("li", {}, el("i", { class: `force-key ${key}`, "aria-hidden": "true" }), words));
  const path = pathLegend(scene);
  const bar = path && el("i", { class: "path-bar", "aria-hidden": "true" });
  if (bar) bar.style.background = gradientOf(path.colors);
  const range = path && el("p", { "data-testid": "legend-path" }, `Path: ${path.label.toLowerCase()}`, bar,
    el("span", {}, withUnit(path.low, path.unit), el("span", {}, withUnit(path.high, path.unit))));
  return el("aside", { class: "legend", "aria-label": "Marks in the scene" }, el("ul", { "data-testid": "legend-arrows" }, ...names), range);
}

function build(document_, made) {
  const numbers = HUD.map(([id, label, unit]) =>
    el("div", {}, el("dt", {}, label), el("dd", {}, el("output", { id: `hud-${id}`, "data-testid": `hud-${id}` }), unit && ` ${unit}`)));
  const play = el("button", { id: "play", class: "btn icon primary", type: "button", "data-testid": "play" });
  const scrub = el("input", { id: "scrub", type: "range", min: "0", max: "1", step: "any", value: "0", "aria-label": "Time", "data-testid": "scrub" });
  const speed = el("select", { id: "speed", class: "btn", "aria-label": "Playback speed", "data-testid": "speed" },
    ...SPEEDS.map((v) => el("option", { value: String(v), selected: v === 1 }, `${v}×`)));
  const source = `${document_.hydrodynamics} (${document_.hydrodynamics_range}) · ${document_.solver}`;
  return el("main", { class: "replay", "aria-label": "Replay" },
    el("header", {}, el("h1", {}, document_.name), el("p", {}, source), el("dl", { class: "hud", "data-testid": "hud" }, ...numbers), legend(document_)),
    el("footer", {}, play, scrub, el("output", { id: "total", class: "time" }), speed, el("small", {}, `Replay made ${made}. Cells' growth is drawn ×${EXAGGERATION}.`)));
}

// The scene's nodes; null before there are any.
function sceneTree() {
  const tree = window.__viserSceneTree?.getState?.();
  return tree && "/glider" in tree && "/world" in tree ? tree : null;
}

// The same, once the client has taken in all that it was told.
const settledTree = () => (window.__viserMutable?.messageQueue.length === 0 ? sceneTree() : null);

class Player {
  constructor(state) {
    this.state = state;
    this.largest = largestForce(state.run.columns);
    this.updates = 0;
  }

  show(t) {
    const tree = sceneTree();
    if (!tree) return;
    const { run } = this.state;
    const wanted = sceneAt(this.state, t, { anchor: positionAt(run, t), exaggeration: EXAGGERATION, largest: this.largest });
    const queue = window.__viserMutable.messageQueue;
    for (const [name, node] of wanted) {
      if (!(name in tree)) continue;
      for (const [key, value] of Object.entries(node)) if (key in messages) queue.push(messages[key](name, value));
    }
    window.__viserMutable.requestRender();
    this.updates += 1;
  }

  // Labels that would lie over each other give way to the nearest.
  spreadLabels() {
    const tree = settledTree();
    if (!tree) return;
    const shown = labelChoice(window.__viserMutable, tree);
    const changed = Object.entries(tree).filter(([name, node]) => shown(name) !== null && shown(name) !== (node.visibility ?? true));
    if (changed.length === 0) return;
    window.__viserMutable.messageQueue.push(...changed.map(([name]) => messages.visible(name, shown(name))));
    window.__viserMutable.requestRender();
  }

  // Handles to drag parts by have no meaning here; the rest as the studio's page begins.
  chooseVisible(tree) {
    const shown = { forces: true, centers: true, path: true, camera: null, spatial: this.state.run.model === "spatial", bed: true };
    for (const [name, node] of Object.entries(tree)) {
      const visible = node.message?.type === "TransformControlsMessage" ? false : visibility(name, shown);
      if (visible !== null) window.__viserMutable.messageQueue.push(messages.visible(name, visible));
    }
  }
}

function connect(clock, state) {
  $("play").addEventListener("click", () => clock.toggle());
  $("scrub").addEventListener("input", () => clock.seek(Number($("scrub").value)));
  $("speed").addEventListener("change", () => clock.setSpeed(Number($("speed").value)));
  addEventListener("keydown", (event) => {
    if (event.key !== " " || /^(BUTTON|SELECT)$/.test(event.target.tagName)) return;
    event.preventDefault();
    clock.toggle();
  });
  clock.watch(({ t, end, playing }) => {
    for (const [id, text] of Object.entries(numbersAt(state.run, t, end))) setText($(`hud-${id}`), text);
    setText($("total"), `${clockText(t, end, { unit: false })} / ${clockText(end, end)}`);
    $("scrub").max = String(end);
    $("scrub").value = String(t);
    setText($("play"), playing ? "❚❚" : "▶");
    $("play").setAttribute("aria-label", playing ? "Pause" : "Play");
  });
}

export function startReplay(made) {
  const state = JSON.parse($("replay-data").textContent);
  const clock = new Clock();
  const player = new Player(state);
  const begin = () => {
    document.body.append(build(state, made));
    connect(clock, state);
    clock.setEnd(state.run.columns.t.at(-1));
    clock.watch(({ t }) => player.show(t));
    const waiting = setInterval(() => {
      const tree = settledTree();
      if (!tree) return;
      clearInterval(waiting);
      player.chooseVisible(tree);
      player.show(clock.t);
      setInterval(() => player.spreadLabels(), LABELS_EVERY);
      window.__replay.ready = true;
    }, READ_EVERY);
  };
  // For tests, as in the studio's page.
  window.__replay = { clock, ready: false, get poseUpdates() { return player.updates; } };
  if (document.readyState === "loading") addEventListener("DOMContentLoaded", begin);
  else begin();
}
