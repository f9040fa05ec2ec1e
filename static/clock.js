// The one clock of the page: everything that moves follows it. A range, where one is set, is what is played.

const PATIENCE = 24; // ms that a frame of the screen may take before a timer ticks in its place
const BEAT = 1000 / 60; // ms between such ticks
const SAME = 1e-9; // s

export class Clock {
  constructor() {
    this.t = 0;
    this.end = 0;
    this.speed = 1;
    this.loop = false;
    this.asked = null; // the range {from, to} that was set, which a shorter run may not hold; null for the whole run
    this.range = null; // as much of it as the run has
    this.playing = false;
    this.ranOut = false; // whether playing came to the end of what is played, and nothing was done since
    this.listeners = [];
    this.last = 0;
    this.request = 0;
    this.timer = 0;
    this.due = 0; // when a timer ticks, ms
    this.paintedAt = -Infinity;
    this.painted = () => this.frame(this.afterPaint(performance.now()));
    this.missed = () => this.frame(Math.max(this.due + BEAT, performance.now()));
  }

  watch(listener) {
    this.listeners.push(listener);
    listener(this);
  }

  tell() {
    for (const listener of this.listeners) listener(this);
  }

  // What playing goes through: the range, or all of the run.
  get played() {
    return this.range ?? { from: 0, to: this.end };
  }

  setEnd(end) {
    this.end = end;
    this.t = Math.min(this.t, end);
    this.range = this.asked && this.within(this.asked); // a longer run brings back what a shorter one cut off
    if (end <= 0) this.playing = false;
    this.tell();
  }

  seek(t) {
    this.ranOut = false;
    this.t = Math.min(Math.max(t, 0), this.end);
    this.tell();
  }

  // To the next or the last of some moments, standing still there.
  step(moments, direction) {
    this.playing = false;
    const next = direction > 0 ? moments.find((t) => t > this.t + SAME) : moments.findLast((t) => t < this.t - SAME);
    this.seek(next ?? (direction > 0 ? this.end : 0));
  }

  setSpeed(speed) {
    this.speed = speed;
    this.tell();
  }

  setLoop(loop) {
    this.loop = loop;
    // A range whose end stopped the play goes round from now on.
    if (loop && this.range && this.ranOut) return this.play();
    return this.tell();
  }

  // The whole run is no range.
  setRange(range) {
    this.asked = this.range = range && this.within(range);
    this.ranOut = false;
    this.tell();
  }

  // What was set when the page was last open, perhaps before there is a run.
  ask(range, loop) {
    Object.assign(this, { asked: range, range: range && this.within(range), loop });
    this.tell();
  }

  within({ from, to }) {
    const cut = { from: Math.max(from, 0), to: Math.min(to, this.end) };
    if (cut.to - cut.from < SAME || (cut.from < SAME && cut.to > this.end - SAME)) return null;
    return cut;
  }

  // A new beginning behind the old end takes all that follows, and the other way round.
  setIn(t = this.t) {
    const { to } = this.played;
    this.setRange({ from: t, to: to > t + SAME ? to : this.end });
  }

  setOut(t = this.t) {
    const { from } = this.played;
    this.setRange({ from: from < t - SAME ? from : 0, to: t });
  }

  play() {
    if (this.playing || this.end <= 0) return;
    const { from, to } = this.played;
    if (this.t < from || this.t >= to - SAME) this.t = from;
    this.playing = true;
    this.ranOut = false;
    this.last = performance.now();
    this.due = this.last + PATIENCE;
    this.tell();
    this.schedule();
  }

  // A slow compositor (no graphics hardware) must not slow the clock: a timer ticks where a frame is missing, and keeps
  // the beat until frames come again.
  schedule() {
    cancelAnimationFrame(this.request);
    clearTimeout(this.timer);
    this.request = requestAnimationFrame(this.painted);
    this.timer = setTimeout(this.missed, this.due - performance.now());
  }

  // Where frames come in time the next may be a little late; where they are rare the timers' beat goes on.
  afterPaint(now) {
    const inTime = now - this.paintedAt < 2 * BEAT;
    this.paintedAt = now;
    return now + (inTime ? PATIENCE : BEAT);
  }

  pause() {
    this.playing = false;
    this.tell();
  }

  toggle() {
    if (this.playing) this.pause();
    else this.play();
  }

  frame(due) {
    this.due = due;
    if (!this.playing) return;
    // Frames and timers take turns, so their own time stamps will not do. A hidden tab sleeps long.
    const now = performance.now();
    const passed = Math.min(now - this.last, 250) / 1000;
    this.last = now;
    const { from, to } = this.played;
    let t = this.t + passed * this.speed;
    if (t >= to) {
      if (this.loop) t = from + ((t - from) % (to - from));
      else {
        t = to;
        this.playing = false;
        this.ranOut = true;
      }
    }
    this.t = t;
    this.tell();
    if (this.playing) this.schedule();
  }
}
