// The transport bar and the keys that drive the clock.

import { $, setText } from "./dom.js";
import { clockText } from "./format.js";
import { onKey } from "./keys.js";
import { timeStep } from "./timescale.js";

const FAST = 10; // steps at once with Shift

export function connectTransport({ store, clock }) {
  const step = (direction) => clock.step(store.get("state")?.run?.columns.t ?? [], direction);
  const whole = () => clock.setRange(null);
  const clicks = {
    "to-start": () => clock.seek(clock.played.from), play: () => clock.toggle(), loop: () => clock.setLoop(!clock.loop),
    "step-back": () => step(-1), "step-on": () => step(1), "set-in": () => clock.setIn(), "set-out": () => clock.setOut(), "clear-range": whole,
  };
  for (const [id, click] of Object.entries(clicks)) $(id).addEventListener("click", click);
  $("speed").addEventListener("change", () => clock.setSpeed(Number($("speed").value)));
  $("scrub").addEventListener("input", () => clock.seek(Number($("scrub").value)));
  connectKeys(clock, { step, whole });
  clock.watch(() => show(clock));
}

function connectKeys(clock, { step, whole }) {
  const group = "Playback";
  const move = (direction) => (event) => clock.seek(clock.t + direction * timeStep(clock.end) * (event.shiftKey ? FAST : 1));
  onKey("Space", () => clock.toggle(), { words: "Play or pause", group });
  onKey(",", () => step(-1), { words: "Back by one sample", group });
  onKey(".", () => step(1), { words: "On by one sample", group });
  onKey(["ArrowLeft", "Shift+ArrowLeft"], move(-1), { words: `Back a little, ×${FAST} with Shift`, group });
  onKey(["ArrowRight", "Shift+ArrowRight"], move(1), { words: `On a little, ×${FAST} with Shift`, group });
  onKey("Home", () => clock.seek(0), { words: "To the start", group });
  onKey("End", () => clock.seek(clock.end), { words: "To the end", group });
  onKey("i", () => clock.setIn(), { words: "The played range begins here", group });
  onKey("o", () => clock.setOut(), { words: "The played range ends here", group });
  onKey("u", whole, { words: "Play the whole glide again", group });
  onKey("l", () => clock.setLoop(!clock.loop), { words: "Loop on or off", group });
}

const WHEN_A_RUN = ["play", "to-start", "step-back", "step-on", "set-in", "set-out", "scrub", "loop"];

function show({ t, end, playing, loop, range }) {
  setText($("time"), `${clockText(t, end, { unit: false })} / ${clockText(end, end)}`);
  $("scrub").value = String(t);
  $("scrub").setAttribute("aria-valuetext", `${clockText(t, end, { unit: false })} of ${clockText(end, end)}`);
  for (const id of WHEN_A_RUN) $(id).disabled = end <= 0;
  $("play").setAttribute("aria-pressed", String(playing));
  $("play").setAttribute("aria-label", playing ? "Pause" : "Play");
  $("loop").setAttribute("aria-pressed", String(loop));
  $("clear-range").hidden = range === null;
  if (range) setText($("range-text"), `${clockText(range.from, end, { unit: false })} – ${clockText(range.to, end)}`);
}
