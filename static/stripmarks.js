// What the strip over the lanes shows, as data: events in groups where they would overlap, stretches joined where no
// eye could part them. Pure functions, easy to test.

import { clockText } from "./format.js";

export const WORDS = { surface: "Surface", bed: "Bed", end_of_stroke: "End stop", dive: "Dive", climb: "Climb", waypoint: "Waypoint", end: "End of the mission" };
const APART = 20; // pixels between two marks
const MOST_TOLD = 6;

// Events of a run, and its end where the mission ran to it.
export function eventsOf(run, duration) {
  if (!run) return [];
  const events = run.events.map(({ time, kind, cell, label }) => ({ time, kind, words: cell ? `${cell}: ${WORDS[kind]?.toLowerCase() ?? kind}` : WORDS[kind] ?? label }));
  return run.status === "completed" ? [...events, { time: duration, kind: "end", words: WORDS.end }] : events;
}

// [{x, time, kind, count, words}] from left to right.
export function grouped(events, scale) {
  const groups = [];
  for (const event of events.filter(({ time }) => scale.shows(time)).sort((a, b) => a.time - b.time)) {
    const x = scale.x(event.time);
    const last = groups.at(-1);
    if (last && x - last.x < APART) last.events.push(event);
    else groups.push({ x, events: [event] });
  }
  return groups.map(({ x, events: found }) => ({ x, time: found[0].time, kind: found[0].kind, count: found.length, words: told(found, scale.end) }));
}

function told(events, end) {
  const lines = events.slice(0, MOST_TOLD).map(({ time, words }) => `${words} at ${clockText(time, end, { digits: 2 })}`);
  return events.length > MOST_TOLD ? [...lines, `and ${events.length - MOST_TOLD} more`] : lines;
}

// Stretches within the window as [left, width] in pixels, at least `least` wide, joined where less than 2 px apart.
export function bars(times, scale, least = 3) {
  const found = [];
  for (const [a, b] of times) {
    if (b < scale.from || a > scale.to) continue;
    const left = scale.x(Math.max(a, scale.from));
    const right = Math.max(scale.x(Math.min(b, scale.to)), left + least);
    const last = found.at(-1);
    if (last && left - last[1] < 2) last[1] = Math.max(last[1], right);
    else found.push([left, right]);
  }
  return found.map(([left, right]) => [left, right - left]);
}

// Phases by the line they are drawn on.
export function tracksOf(phases) {
  const tracks = new Map();
  for (const phase of phases) tracks.set(phase.track, [...(tracks.get(phase.track) ?? []), phase]);
  return tracks;
}
