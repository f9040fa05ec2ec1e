// Plays a mode in the 3D view: the glider about its trim, moved by the mode's amplitudes. Knows no viewer: it changes
// what the scene is about to show, and asks for a new frame as long as it plays.

import { about, rotate, times } from "./attitude.js";

const SHOWN = 3.2; // s on the screen for one period, or for the time to 1/e of what does not oscillate
const FADED = 3; // time constants after which it begins again
const MOST_PERIODS = 6;
const PATIENCE = 24; // ms, as of the clock

// How many times faster than life a mode plays, and after how long (s of life) it begins again.
export function pace({ period, time_constant: constant }) {
  const unit = period ?? constant ?? 1;
  const lasts = Math.min(FADED * (constant ?? Infinity), period ? MOST_PERIODS * period : FADED * unit);
  return { faster: unit / SHOWN, lasts: Math.max(lasts, unit) };
}

// The departure from the trim at a time (s of life): place in metres, angles in radians. What grows ends at its full size.
export function departure({ real, imag, motion }, t, amplitude, lasts) {
  const size = amplitude * Math.exp(real * (real > 0 ? t - lasts : t));
  const [c, s] = [Math.cos(imag * t) * size, Math.sin(imag * t) * size];
  return Object.fromEntries(Object.entries(motion).map(([name, [re, im]]) => [name, re * c - im * s]));
}

// Body to world of roll, pitch and yaw (Z-Y-X).
export const attitudeOf = (roll, pitch, yaw) => times(times(about([0, 0, 1], yaw), about([0, 1, 0], pitch)), about([1, 0, 0], roll));

export class ModePlay {
  constructor({ mode, point, amplitude, heading }) {
    Object.assign(this, { mode, point, amplitude, heading, began: performance.now(), ...pace(mode) });
  }

  // Calls the scene's `show` for every frame from now on; where a slow compositor asks for none, a timer does.
  follow(show) {
    const frame = () => {
      this.stop();
      this.request = requestAnimationFrame(frame);
      this.timer = setTimeout(frame, PATIENCE);
      show();
    };
    frame();
  }

  stop() {
    cancelAnimationFrame(this.request);
    clearTimeout(this.timer);
  }

  get t() {
    return ((((performance.now() - this.began) / 1000) * this.faster) % this.lasts + this.lasts) % this.lasts;
  }

  // Where the glider is and how it is turned, in a view in which the world is turned by `turn`.
  pose(base, turn) {
    const by = departure(this.mode, this.t, this.amplitude, this.lasts);
    const { heading } = this;
    const wxyz = times(turn, attitudeOf(this.point.roll + by.roll, this.point.pitch + by.pitch, heading + by.yaw));
    const moved = rotate(times(turn, about([0, 0, 1], heading)), [by.ahead, by.right, by.down]);
    return { position: base.map((p, k) => p + moved[k]), wxyz };
  }

  // Puts the glider of a scene about its trim; everything else stays as the clock has it.
  onto(wanted) {
    const glider = wanted.get("/glider");
    if (glider) wanted.set("/glider", { ...glider, ...this.pose(glider.position, wanted.get("/world")?.wxyz ?? [1, 0, 0, 0]) });
    return wanted;
  }
}
