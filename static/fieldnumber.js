// A box for a number: shown and typed in the unit of the person's choice, stepped by arrow keys, kept in SI outside.
// A refused number stays in the box as a draft until it is mended, given up by Escape, or another change is accepted.

import { el } from "./dom.js";
import { rememberUnit } from "./fieldbounds.js";
import { nextUnit, shown, typed, unitNow } from "./unitchoice.js";

const COARSE = 10; // of a step with Shift held, and of a fine one with Alt
const FIGURES = 12; // that a stepped number keeps: sums of steps must not grow tails

const NOT_A_NUMBER = (text) => ({ errors: [{ message: `‘${text}’ is no number`, hint: "Type a number such as 12.5, with a unit if you like: 1.2 cm" }] });

export class NumberBox {
  // send(value) answers {ok, revision, problem}, or undefined where a later value took its place;
  // onRefused(problem) is told of a refusal, and null once it is over.
  constructor(spec, { send, onRefused = () => {}, label = spec.label, id = null }) {
    Object.assign(this, { spec, send, onRefused, pending: 0, until: 0, revision: 0, refusedAt: null, draft: null });
    this.input = el("input", { class: "field-box", type: "text", inputmode: "decimal", autocomplete: "off", spellcheck: "false", "aria-label": id ? null : label, id, placeholder: spec.placeholder ?? (spec.nullable ? "none" : null) });
    rememberUnit(spec);
    this.input.addEventListener("focus", () => this.input.select());
    this.input.addEventListener("input", () => (this.dirty = true));
    this.input.addEventListener("blur", () => this.dirty && this.take());
    this.input.addEventListener("keydown", (event) => this.key(event));
  }

  // Whether there is text that the document has not got; keys.js asks, too.
  get dirty() {
    return this.input.hasAttribute("data-draft");
  }

  set dirty(on) {
    this.input.toggleAttribute("data-draft", on);
  }

  get unit() {
    return unitNow(this.spec.quantity, this.spec.unit);
  }

  // Shows the document's value, unless a person's own has not come back from the server yet or was refused.
  update(spec, revision) {
    this.spec = spec;
    this.revision = revision;
    if (this.refusedAt !== null && revision > this.refusedAt) this.giveUp();
    if (this.held) return;
    this.draft = null;
    this.write(spec.value);
  }

  get held() {
    return this.dirty || this.pending > 0 || this.revision < this.until || this.refusedAt !== null;
  }

  get value() {
    return this.draft ?? this.spec.value;
  }

  write(value) {
    const text = this.spec.scale === "log" && value != null ? String(value) : shown(value, this.unit);
    if (this.input.value !== text) this.input.value = text;
  }

  // In another unit; what was typed and is no number has none.
  reshow() {
    if (!this.dirty && !(this.refusedAt !== null && this.draft === null)) this.write(this.value);
  }

  key(event) {
    const turns = { ArrowUp: 1, ArrowDown: -1 }[event.key];
    if (turns) this.step(turns * (event.shiftKey ? COARSE : 1) * (event.altKey ? 1 / COARSE : 1));
    else if (event.key === "Enter") this.enter();
    else if (event.key === "Escape" && (this.dirty || this.refusedAt !== null)) this.giveUp(true);
    else if (event.altKey && event.key.toLowerCase() === "u" && this.spec.quantity) nextUnit(this.spec.quantity, this.spec.unit);
    else return;
    event.preventDefault();
    event.stopPropagation();
  }

  enter() {
    this.take();
    this.input.select();
  }

  giveUp(rewrite = false) {
    this.dirty = false;
    this.refusedAt = this.draft = null;
    this.input.removeAttribute("aria-invalid");
    this.onRefused(null);
    if (rewrite) this.write(this.spec.value);
  }

  take() {
    const text = this.input.value.trim();
    if (!this.dirty) return;
    this.dirty = false;
    if (text === "" && this.spec.nullable) return this.put(null);
    const value = text === "" ? null : typed(text, this.spec.quantity, this.spec.unit);
    if (value === null) return this.refuse(NOT_A_NUMBER(text));
    // What stands there was rounded for the eye: untouched, it must not reach the document.
    if (text === shown(this.spec.value, this.unit) && this.refusedAt === null) return this.write(this.spec.value);
    this.put(value);
  }

  // Live: of the values of a drag the server gets those it has time for, and always the last.
  step(turns) {
    if (this.spec.scale === "log") return this.put(Number((this.value * 10 ** Math.sign(turns)).toPrecision(3)));
    const { per, step } = this.unit;
    const size = this.spec.integer ? 1 : step;
    this.put(this.within(Number((((this.value ?? 0) * per + turns * size) / per).toPrecision(FIGURES))));
  }

  within(value) {
    const { low, high, aboveLow, integer } = this.spec;
    const whole = integer ? Math.round(value) : value;
    if (low != null && (whole < low || (aboveLow && whole === low))) return aboveLow ? (this.value ?? low) : low;
    return high != null && whole > high ? high : whole;
  }

  async put(value) {
    this.draft = value;
    this.dirty = false;
    this.write(value);
    this.pending += 1;
    const answer = await this.send(value);
    this.pending -= 1;
    if (answer === undefined) return;
    if (!answer.ok) return this.refuse(answer.problem, answer.revision);
    this.until = answer.revision ?? 0;
    if (this.refusedAt !== null) this.giveUp();
    if (!this.held) this.update(this.spec, this.revision);
  }

  // Only what was accepted after the refusal ends it: the fields shown may be older.
  refuse(problem, revision = this.until) {
    this.refusedAt = Math.max(this.revision, revision);
    this.input.setAttribute("aria-invalid", "true");
    this.onRefused(problem);
  }
}

const SLOP = 3; // pixels before a press on a label is a drag
const PIXELS = 4; // of a drag for one step

// Dragging the label left and right changes its number, as in drawing programs; a press without a drag gives it the focus.
export function scrub(label, box) {
  let from = null;
  label.classList.add("scrubs");
  label.addEventListener("pointerdown", (event) => {
    if (event.button !== 0 || box.input.disabled) return;
    from = { x: event.clientX, turns: 0, moved: false };
    label.setPointerCapture(event.pointerId);
    event.preventDefault();
  });
  label.addEventListener("pointermove", (event) => {
    if (!from) return;
    const dx = event.clientX - from.x;
    if (!from.moved && Math.abs(dx) < SLOP) return;
    from.moved = true;
    const turns = Math.round(dx / PIXELS);
    if (turns === from.turns) return;
    box.step((turns - from.turns) * (event.shiftKey ? COARSE : 1) * (event.altKey ? 1 / COARSE : 1));
    from.turns = turns;
  });
  const end = () => {
    if (from && !from.moved) box.input.focus();
    from = null;
  };
  label.addEventListener("pointerup", end);
  label.addEventListener("pointercancel", end);
}
