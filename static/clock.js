// The one clock of the page: everything that moves follows it.

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
    // A quick pause and play must not leave two frame chains running.
    cancelAnimationFrame(this.request);
    this.request = requestAnimationFrame(this.frame);
  }

  pause() {
    this.playing = false;
    this.tell();
  }

  toggle() {
    if (this.playing) this.pause();
    else this.play();
  }

  frame(now) {
    if (!this.playing) return;
    // A frame's time stamp may lie before the click that started the clock; a hidden tab sleeps long.
    const passed = Math.min(Math.max(now - this.last, 0), 250) / 1000;
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
    if (this.playing) this.request = requestAnimationFrame(this.frame);
  }
}
