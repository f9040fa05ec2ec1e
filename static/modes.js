// The panel of modes: small motions about a trim or an instant, on a plane and in a table, and played in the 3D view.

import { call } from "./api.js";
import { $, el, setText } from "./dom.js";
import { clockText, fixed } from "./format.js";
import { heldAt, spansText } from "./held.js";
import { onKey } from "./keys.js";
import { ModePlay, pace } from "./modeplay.js";
import { drawPlane, modeInWords } from "./modesplane.js";
import { problemNodes } from "./problem.js";

const CLOCK = "clock";
const CURRENT = "held"; // the hold in force at the clock
const DEGREES = Math.PI / 180;

const time = (v) => (v == null ? "–" : fixed(v, v < 10 ? 2 : v < 1000 ? 1 : 0));

class Modes {
  constructor({ store, clock }) {
    Object.assign(this, { store, clock, found: null, asked: "", chosen: 0, pointed: null });
    this.build();
    this.point.addEventListener("change", () => this.load());
    store.watch(["consequences"], () => this.offer());
    clock.watch(() => this.point.value === CURRENT && this.open && this.load());
  }

  build() {
    this.point = el("select", { id: "modes-point", class: "btn", "aria-label": "Operating point", "data-testid": "modes-point" });
    this.words = el("p", { class: "sentence", role: "status", "data-testid": "modes-words" });
    this.problem = el("section", { class: "box", role: "alert", "data-testid": "modes-problem", hidden: true });
    this.plane = el("div", { class: "plane-box" });
    this.pointedAt = el("p", { class: "pointed", "aria-hidden": "true" });
    this.table = el("div", { class: "modes-table" });
    this.play = el("button", { id: "mode-play", class: "btn primary", type: "button", "aria-pressed": "false", "data-testid": "mode-play", onclick: () => this.toggle() }, "Play in 3D");
    this.amplitude = el("input", { id: "mode-amplitude", type: "range", min: "1", max: "45", step: "1", value: "12", "aria-label": "Amplitude in degrees", "data-testid": "mode-amplitude" });
    this.shownAmplitude = el("output", { for: "mode-amplitude" }, "12°");
    this.amplitude.addEventListener("input", () => this.resize());
    this.playing = el("p", { class: "sentence", role: "status", "data-testid": "mode-playing" });
    this.pillName = el("span", { role: "status" });
    this.pill = el("div", { class: "over mode-pill", "data-testid": "mode-pill", hidden: true }, this.pillName,
      el("button", { class: "btn small", type: "button", "data-testid": "mode-pill-stop", onclick: () => this.stop() }, "Stop"));
    document.querySelector("main.scene").append(this.pill);
    this.body = el("div", {}, this.plane, this.pointedAt, this.table,
      el("div", { class: "mode-bar" }, this.play, el("label", {}, "Amplitude", this.amplitude), this.shownAmplitude), this.playing);
    $("pane-modes").replaceChildren(el("label", { class: "modes-head" }, "About", this.point), this.words, this.problem, this.body);
  }

  get open() {
    return !$("pane-modes").hidden;
  }

  // The holds as they are now; the chosen one stays chosen, if it is still there.
  offer() {
    const holds = this.store.get("consequences")?.holds ?? [];
    const before = this.point.value || CURRENT;
    const options = [[CURRENT, "the trim at the clock"], ...holds.map((hold, k) => [String(k), `the trim held ${spansText(hold.spans, this.clock.end)}${hold.reached ? "" : ", not reached"}`]), [CLOCK, "the run at the clock, frozen"]];
    const key = JSON.stringify(options);
    if (key !== this.options) {
      this.options = key;
      this.point.replaceChildren(...options.map(([value, text]) => el("option", { value }, text)));
      this.point.value = options.some(([value]) => value === before) ? before : CURRENT;
    }
    this.load();
  }

  // What to ask for; the same question is not asked twice.
  query() {
    const consequences = this.store.get("consequences");
    if (this.point.value === CLOCK) return { time: this.clock.t };
    return { hold: this.point.value === CURRENT ? (heldAt(consequences, this.clock.t)?.index ?? 0) : Number(this.point.value) };
  }

  async load() {
    const consequences = this.store.get("consequences");
    if (!this.open || !consequences) return;
    const query = new URLSearchParams(this.query());
    const asked = `${consequences.run} ${query}`;
    if (asked === this.asked) return;
    this.asked = asked;
    try {
      const found = await call("GET", `modes?${query}`);
      if (this.asked === asked) this.show(found);
    } catch (error) {
      if (this.asked === asked) this.fail(error.problem ?? { title: error.message });
    }
  }

  show(found) {
    const before = this.found?.modes[this.chosen]?.name;
    this.found = found;
    const again = found.modes.findIndex(({ name }) => name === before);
    this.chosen = again >= 0 ? again : Math.max(found.modes.findIndex(({ name }) => name === found.leading), 0);
    this.problem.hidden = true;
    this.body.hidden = false;
    const where = found.equilibrium ? "" : " This is no equilibrium: the motion is frozen as it is.";
    setText(this.words, `${found.stable ? "All small motions die out" : "Small motions grow"}; ${found.leading ?? "none"} leads, at ${fixed(found.speed, 3)} m/s. Depth, heading and commands are held.${where}`);
    this.draw();
    if (this.player) this.start();
  }

  fail(problem) {
    this.found = null;
    this.stop();
    this.body.hidden = true;
    setText(this.words, "");
    this.problem.hidden = false;
    this.problem.replaceChildren(...problemNodes(problem));
  }

  draw() {
    const { modes } = this.found;
    const how = { chosen: this.chosen, choose: (k) => this.choose(k), point: (k) => this.pointAt(k) };
    const focused = this.plane.contains(document.activeElement) ? document.activeElement.dataset.testid : null;
    this.plane.replaceChildren(drawPlane(modes, how));
    if (focused) this.plane.querySelector(`[data-testid="${focused}"]`)?.focus();
    this.table.replaceChildren(this.makeTable(modes));
    this.pointAt(null);
  }

  makeTable(modes) {
    const head = el("tr", {}, ...["Mode", "Period s", "1/e in s", "ζ"].map((text) => el("th", { scope: "col" }, text)));
    const rows = modes.flatMap((mode, k) => {
      const state = `${k === this.chosen ? "chosen" : ""}${mode.real > 1e-7 ? " grows" : ""}`;
      const button = el("button", { type: "button", class: "mode-name", "aria-pressed": String(k === this.chosen), "data-testid": `mode-${k}`, onclick: () => this.choose(k) }, mode.name);
      const numbers = [time(mode.period), `${mode.real > 1e-7 ? "×" : ""}${time(mode.time_constant)}`, mode.period ? fixed(mode.damping_ratio, 3) : "–"];
      const pair = [
        el("tr", { class: state }, el("th", { scope: "row" }, button), ...numbers.map((text) => el("td", {}, text))),
        el("tr", { class: `who ${state}` }, el("td", { colspan: "4", title: "Which states take part, by their participation factors" }, mode.participation)),
      ];
      for (const row of pair) for (const [event, shown] of [["pointerenter", k], ["pointerleave", null]]) row.addEventListener(event, () => this.pointAt(shown));
      return pair;
    });
    return el("table", { class: "modes", "data-testid": "modes-table" }, el("thead", {}, head), el("tbody", {}, ...rows));
  }

  pointAt(k) {
    const mode = this.found?.modes[k ?? this.chosen];
    setText(this.pointedAt, mode ? modeInWords(mode) : "");
    this.plane.querySelectorAll(".mode").forEach((node, j) => node.classList.toggle("pointed", j === k));
  }

  choose(k) {
    this.chosen = k;
    this.draw();
    if (this.player) this.start();
  }

  get angle() {
    return Number(this.amplitude.value) * DEGREES;
  }

  resize() {
    setText(this.shownAmplitude, `${this.amplitude.value}°`);
    if (this.player) this.player.amplitude = this.angle;
  }

  toggle() {
    if (this.player) this.stop();
    else this.start();
  }

  start() {
    const mode = this.found?.modes[this.chosen];
    this.player?.stop();
    this.player = null;
    if (!mode?.motion) {
      this.end("This mode moves nothing that could be shown.");
      return;
    }
    const player = new ModePlay({ mode, point: this.found.point, amplitude: this.angle, heading: this.heading() });
    this.player = player;
    this.store.set({ modePlay: player });
    this.play.setAttribute("aria-pressed", "true");
    setText(this.play, "Stop");
    this.pill.hidden = false;
    setText(this.pillName, `Playing mode: ${mode.name}`);
    const { faster } = pace(mode);
    const rate = faster > 1 ? `${fixed(faster, 1)} times faster than life` : `${fixed(1 / faster, 1)} times slower than life`;
    setText(this.playing, `Playing ${mode.name} about ${this.found.equilibrium ? "the trim" : "the run"}, ${rate}. The largest angle, or move by the length, is ${this.amplitude.value}°.`);
  }

  // The heading of the run at the clock, so that the glider does not swing round when a mode begins.
  heading() {
    const run = this.store.get("state")?.run;
    const { t, heading } = run?.columns ?? {};
    if (!heading) return 0;
    return heading[Math.max(t.findLastIndex((at) => at <= this.clock.t), 0)];
  }

  stop() {
    if (!this.player) return;
    this.player.stop();
    this.player = null;
    this.end("");
  }

  end(words) {
    this.store.set({ modePlay: null });
    this.pill.hidden = true;
    this.play.setAttribute("aria-pressed", "false");
    setText(this.play, "Play in 3D");
    setText(this.playing, words);
  }
}

// The tabs of the right column: arrows go from one to the other.
function connectTabs(onChange) {
  const tabs = [...document.querySelectorAll(".result-tabs [role=tab]")];
  const choose = (tab) => {
    for (const one of tabs) {
      const chosen = one === tab;
      one.setAttribute("aria-selected", String(chosen));
      one.tabIndex = chosen ? 0 : -1;
      $(one.getAttribute("aria-controls")).hidden = !chosen;
    }
    onChange(tab.id);
  };
  $("modes-open").addEventListener("click", () => choose($("tab-modes")));
  onKey("m", () => choose(tabs.find((tab) => tab.getAttribute("aria-selected") === "false")), { words: "Readouts or modes", group: "View" });
  tabs.forEach((tab, k) => {
    tab.addEventListener("click", () => choose(tab));
    tab.addEventListener("keydown", (event) => {
      if (event.key !== "ArrowLeft" && event.key !== "ArrowRight") return;
      event.preventDefault();
      const next = tabs[(k + 1) % tabs.length];
      next.focus();
      choose(next);
    });
  });
}

export function connectModes({ store, clock }) {
  const modes = new Modes({ store, clock });
  connectTabs((id) => (id === "tab-modes" ? modes.load() : modes.stop()));
  clock.watch(({ playing }) => playing && modes.stop()); // the run and a mode cannot both move the glider
  return modes;
}
