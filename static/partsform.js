// The fields of the selected part, and the sections of the rest of the document below them.

import { el, flash, setText, swatch } from "./dom.js";
import { Items } from "./fieldrows.js";
import { wordOf } from "./fieldwords.js";
import { hideHelp, refreshHelp } from "./fieldhelp.js";
import { iconOf, kindIcon } from "./partsicons.js";
import { SECTIONS, partItems } from "./partsections.js";

const KEY = "glider-studio.sections";
const SCHEDULE = /^\/mission\/control\/schedules\/(\d+)/;
const PART = /^\/vehicle\/components\/(\d+)/;

function readOpen() {
  try {
    return new Set(JSON.parse(localStorage.getItem(KEY)) ?? []);
  } catch {
    return new Set(); // storage may be forbidden
  }
}

export class PartsForm {
  // hooks: change(spec, value), press(name), unlock(), link(whether mirror images go along)
  constructor(root, hooks) {
    Object.assign(this, { root, hooks, ctx: null, open: readOpen() });
    const env = (locked) => ({ change: hooks.change, press: hooks.press, locked, colorNow: () => this.part?.color ?? "#808080" });
    this.color = swatch("");
    this.icon = el("span", { class: "part-kind" });
    this.title = el("span", { class: "form-name" });
    this.kind = el("span", { class: "form-kind" });
    this.lockNote = el("p", { class: "lock-note", "data-testid": "locked", hidden: true }, "Locked. ", el("button", { type: "button", class: "link", onclick: hooks.unlock }, "Unlock"));
    this.linked = el("input", { type: "checkbox", "data-testid": "pair-linked" });
    this.linked.addEventListener("change", () => hooks.link(this.linked.checked));
    this.pairWords = el("span");
    this.pairNote = el("label", { class: "pair-note", hidden: true, title: "What is changed here, or dragged in the scene, is done to both parts, mirrored" }, this.linked, this.pairWords);
    const body = el("div", { class: "field-body" });
    this.fields = new Items(body, env(() => Boolean(this.part?.locked)));
    const heading = el("h2", { class: "form-head", "data-testid": "form-title" }, this.color, this.icon, this.title, this.kind);
    this.place = el("section", { class: "form-part", "aria-label": "Selected part", "data-testid": "part-fields" }, heading, this.lockNote, this.pairNote, body);
    root.append(this.place);
    this.sections = SECTIONS.map((section) => this.made(section, env(() => false)));
    root.addEventListener("scroll", hideHelp);
  }

  made(section, env) {
    const body = el("div", { class: "field-body" });
    const brief = el("span", { class: "section-brief" });
    const root = el("details", { class: "section", "data-testid": `section-${section.id}` }, el("summary", {}, el("span", {}, section.label), brief), body);
    root.open = this.open.has(section.id);
    const items = new Items(body, env);
    root.addEventListener("toggle", () => {
      this.remember(section.id, root.open);
      this.drawSection(made);
    });
    const made = { ...section, root, brief, content: items };
    this.root.append(root);
    return made;
  }

  remember(id, open) {
    if (open) this.open.add(id);
    else this.open.delete(id);
    try {
      localStorage.setItem(KEY, JSON.stringify([...this.open]));
    } catch {
      // It holds until the page closes.
    }
  }

  get part() {
    return this.ctx?.state.components.find(({ name }) => name === this.ctx.design.vehicle.components[this.ctx.index]?.name) ?? null;
  }

  // ctx: the document's fields and facts, the schema, the state, and the index of the selected part in the document.
  update(ctx) {
    const another = this.ctx !== null && this.ctx.index !== ctx.index;
    this.ctx = ctx;
    this.draw();
    if (another) this.bringUp();
    refreshHelp();
  }

  // Whoever compares the same fields of two parts keeps their place; from another section it goes back to the part.
  bringUp() {
    const { top, height } = this.root.getBoundingClientRect();
    if (this.place.getBoundingClientRect().bottom < top + height / 2) this.root.scrollTop = 0;
  }

  draw() {
    if (!this.ctx) return;
    const part = this.ctx.design.vehicle.components[this.ctx.index];
    const row = this.part;
    setText(this.title, part.name);
    setText(this.kind, wordOf(part.kind));
    this.color.style.background = row?.color ?? "";
    this.color.closest("section").style.setProperty("--cell", row?.color ?? null);
    const icon = iconOf(row ?? part);
    if (this.drawnIcon !== icon) this.icon.replaceChildren(kindIcon((this.drawnIcon = icon)));
    this.lockNote.hidden = !row?.locked;
    this.drawPair(row);
    this.fields.update(partItems(this.ctx), this.ctx.revision);
    for (const section of this.sections) this.drawSection(section);
  }

  drawPair(row) {
    const { components, linked } = this.ctx.state;
    const partner = components[row?.partner ?? -1];
    this.pairNote.hidden = !partner || row.locked;
    if (!partner) return;
    this.linked.checked = linked && !partner.locked;
    this.linked.disabled = partner.locked;
    setText(this.pairWords, partner.locked ? `${partner.name} mirrors it, but is locked and stays` : `Also ${partner.name}, mirrored`);
  }

  // A closed section has no rows: it is made when somebody opens it.
  drawSection({ root, brief, briefOf, content, items }) {
    if (!this.ctx) return;
    setText(brief, briefOf(this.ctx));
    content.update(root.open ? items(this.ctx) : [], this.ctx.revision);
  }

  // The index of the part that a pointer belongs to, or null.
  partOf(pointer) {
    const index = PART.exec(pointer)?.[1];
    if (index !== undefined) return Number(index);
    const schedule = this.ctx?.design.mission.control.schedules[SCHEDULE.exec(pointer)?.[1]];
    const found = schedule ? this.ctx.design.vehicle.components.findIndex(({ name }) => name === schedule.cell) : -1;
    return found < 0 ? null : found;
  }

  // Opens what holds a field, and gives it the focus; false where there is none. A field that this model does not show
  // is stood for by the part or the section it belongs to.
  focus(pointer) {
    const ofPart = this.partOf(pointer) !== null;
    const [, root] = pointer.split("/");
    const section = ofPart || pointer === "/vehicle/components" ? null : (this.sections.find(({ holds }) => holds.test(pointer)) ?? this.sections.find(({ id }) => id === root));
    if (section) {
      section.root.open = true;
      this.drawSection(section);
    }
    const found = (section ? section.content : this.fields).find(pointer) ?? section?.root ?? (ofPart ? this.place : null);
    if (!found) return false;
    found.scrollIntoView({ block: "center" });
    const control = found.matches("details") ? found.querySelector("summary") : (entryOf(found, pointer) ?? found.querySelector("input, select, textarea, button"));
    control?.focus({ preventScroll: true });
    flash(found);
    return true;
  }
}

// The entry of a vector that a pointer ends in.
function entryOf(row, pointer) {
  const rest = pointer.slice((row.dataset.pointer ?? "").length + 1);
  return /^\d+$/.test(rest) ? row.querySelectorAll(".field-entry input")[Number(rest)] : null;
}
