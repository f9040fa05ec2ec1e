// The one clock of the page: everything that moves follows it.

const PATIENCE = 24; // ms

export class Clock {
  constructor() {
    this.t = 0;
    this.end = 0;
    this.speed = 1;
    this.loop = false;
    this.playing = false;
    this.listeners = [];
    this.last = 0;
    this.request = 0;
    this.timer = 0;
    this.frame = this.frame.bind(this);
  }

  watch(listener) {
    this.listeners.push(listener);
    listener(this);
  }

  tell() {
    for (const listener of this.listeners) listener(this);
  }

  setEnd(end) {
    this.end = end;
    this.t = Math.min(this.t, end);
    if (end <= 0) this.playing = false;
    this.tell();
  }

  seek(t) {
    this.t = Math.min(Math.max(t, 0), this.end);
    this.tell();
  }

  setSpeed(speed) {
    this.speed = speed;
    this.tell();
  }

  setLoop(loop) {
    this.loop = loop;
    this.tell();
  }

  play() {
    if (this.playing || this.end <= 0) return;
    if (this.t >= this.end - 1e-9) this.t = 0;
    this.playing = true;
    this.last = performance.now();
    this.tell();
    this.schedule();
  }

  // A slow compositor (no graphics hardware) must not slow the clock: after PATIENCE a timer ticks instead.
  schedule() {
    cancelAnimationFrame(this.request);
    clearTimeout(this.timer);
    this.request = requestAnimationFrame(this.frame);
    this.timer = setTimeout(this.frame, PATIENCE);
  }

  pause() {
    this.playing = false;
    this.tell();
  }

  toggle() {
    if (this.playing) this.pause();
    else this.play();
  }

  frame() {
    if (!this.playing) return;
    // Frames and timers take turns, so their own time stamps will not do. A hidden tab sleeps long.
    const now = performance.now();
    const passed = Math.min(now - this.last, 250) / 1000;
    this.last = now;
    let t = this.t + passed * this.speed;
    if (t >= this.end) {
      if (this.loop) t %= this.end;
      else {
        t = this.end;
        this.playing = false;
      }
    }
    this.t = t;
    this.tell();
    if (this.playing) this.schedule();
  }
}
