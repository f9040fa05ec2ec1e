// The transport bar and the keys that drive the clock.

import { $, setText } from "./dom.js";
import { clockText } from "./format.js";
import { timeStep } from "./timescale.js";

export function connectTransport(clock) {
  $("to-start").addEventListener("click", () => clock.seek(0));
  $("play").addEventListener("click", () => clock.toggle());
  $("speed").addEventListener("change", () => clock.setSpeed(Number($("speed").value)));
  $("loop").addEventListener("click", () => clock.setLoop(!clock.loop));
  $("scrub").addEventListener("input", () => clock.seek(Number($("scrub").value)));
  document.addEventListener("keydown", (event) => pressKey(event, clock));
  clock.watch(() => show(clock));
}

function show({ t, end, playing, loop }) {
  setText($("time"), `${clockText(t, end, { unit: false })} / ${clockText(end, end)}`);
  $("scrub").value = String(t);
  $("scrub").setAttribute("aria-valuetext", `${clockText(t, end, { unit: false })} of ${clockText(end, end)}`);
  for (const id of ["play", "to-start", "scrub", "loop"]) $(id).disabled = end <= 0;
  $("play").setAttribute("aria-pressed", String(playing));
  $("play").setAttribute("aria-label", playing ? "Pause" : "Play");
  $("loop").setAttribute("aria-pressed", String(loop));
}

// Controls that use a key themselves keep it.
function takes(target, key) {
  const tag = target?.tagName;
  if (/^(TEXTAREA|SELECT)$/.test(tag)) return true;
  if (tag === "INPUT") return target.type !== "range" || (key !== " " && key !== "Home");
  return key === " " && /^(BUTTON|SUMMARY|A)$/.test(tag);
}

export function pressKey(event, clock) {
  const { key } = event;
  if (event.ctrlKey || event.metaKey || event.altKey || takes(event.target, key)) return;
  const step = timeStep(clock.end) * (event.shiftKey ? 10 : 1);
  if (key === " ") clock.toggle();
  else if (key === "Home") clock.seek(0);
  else if (key === "End") clock.seek(clock.end);
  else if (key === "ArrowLeft") clock.seek(clock.t - step);
  else if (key === "ArrowRight") clock.seek(clock.t + step);
  else return;
  event.preventDefault();
}
