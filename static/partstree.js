// The list of parts: a row each with its colour, kind, name and mass; chosen, renamed, moved and marked in place.

import { el, flash, setText, swatch } from "./dom.js";
import { iconOf, kindIcon, sign } from "./partsicons.js";
import { onUnits, unitNow } from "./unitchoice.js";

export const STILL_THERE = "not drawn, yet it counts; the arrows are the forces on the whole glider";

export class PartsTree {
  // hooks: select(index), rename(index, name), locked(index), move(index, to), mark(index, marks), menu(index, place), key(event, index)
  constructor(root, hooks) {
    Object.assign(this, { root, hooks, rows: [], components: [], selected: -1, renaming: null, dragged: null });
    root.addEventListener("keydown", (event) => this.key(event));
    onUnits(() => this.draw());
  }

  update({ components, selected }) {
    const moved = selected !== this.selected;
    Object.assign(this, { components, selected });
    while (this.rows.length > components.length) this.rows.pop().root.remove();
    while (this.rows.length < components.length) this.rows.push(this.row(this.rows.length));
    this.draw();
    if (moved) this.rows[selected]?.root.scrollIntoView({ block: "nearest" });
    if (moved && this.root.contains(document.activeElement) && !this.renaming) this.rows[selected]?.root.focus();
  }

  // Shows where the list is, to whom something led here.
  point() {
    this.rows[this.selected]?.root.focus();
    flash(this.root);
  }

  row(index) {
    const mark = (name) => el("button", { type: "button", class: `part-mark ${name}`, tabindex: "-1", onclick: (event) => {
      event.stopPropagation();
      this.hooks.mark(index, { [name]: !this.components[index][name] });
    } });
    const parts = {
      color: swatch(""), icon: el("span", { class: "part-kind" }), name: el("span", { class: "part-name" }), pair: el("span", { class: "part-pair" }, sign("linked")),
      locked: mark("locked"), hidden: mark("hidden"), mass: el("span", { class: "part-mass" }), unit: el("span", { class: "part-unit" }),
    };
    const root = el("li", { role: "treeitem", class: "part", draggable: "true", tabindex: "-1", "aria-level": "1" }, ...Object.values(parts));
    this.listen(root, index);
    this.root.append(root);
    return { root, ...parts };
  }

  listen(root, index) {
    root.addEventListener("click", () => {
      if (this.renaming === null) root.focus();
      this.hooks.select(index);
    });
    root.addEventListener("dblclick", (event) => event.target.closest("button") || this.rename(index));
    root.addEventListener("contextmenu", (event) => {
      event.preventDefault();
      this.hooks.select(index);
      this.hooks.menu(index, { x: event.clientX, y: event.clientY });
    });
    root.addEventListener("dragstart", (event) => {
      this.dragged = index;
      event.dataTransfer.effectAllowed = "move";
      event.dataTransfer.setData("text/plain", this.components[index].name);
    });
    root.addEventListener("dragover", (event) => this.over(event, root));
    root.addEventListener("dragleave", () => this.unmark());
    root.addEventListener("drop", (event) => this.drop(event, index));
    root.addEventListener("dragend", () => this.unmark((this.dragged = null)));
  }

  draw() {
    const unit = unitNow("mass", "kg");
    this.components.forEach((part, k) => this.drawRow(this.rows[k], part, k, unit));
  }

  drawRow(row, part, k, unit) {
    const chosen = k === this.selected;
    row.root.dataset.testid = `part-${part.name}`;
    row.root.setAttribute("aria-selected", String(chosen));
    row.root.tabIndex = chosen ? 0 : -1;
    row.root.classList.toggle("is-hidden", part.hidden);
    row.root.style.setProperty("--cell", part.color);
    row.color.style.background = part.color;
    if (row.kind !== iconOf(part)) row.icon.replaceChildren(kindIcon((row.kind = iconOf(part))));
    if (this.renaming !== k) setText(row.name, part.name);
    row.name.title = part.name;
    const partner = part.partner === null ? null : this.components[part.partner]?.name;
    row.pair.hidden = partner === null;
    row.pair.title = `Mirrors ${partner}`;
    const mass = (part.mass * unit.per).toFixed(unit.digits);
    setText(row.mass, mass);
    setText(row.unit, unit.symbol);
    this.drawMark(row.locked, "locked", part, part.locked ? `Unlock ${part.name}` : `Lock ${part.name}`, part.locked ? "lock" : "unlock");
    this.drawMark(row.hidden, "hidden", part, part.hidden ? `Show ${part.name}` : `Hide ${part.name}`, part.hidden ? "hidden" : "shown", `: ${STILL_THERE}`);
    const said = [part.name, part.kind.replaceAll("_", " "), `${mass} ${unit.symbol}`, partner && `mirrors ${partner}`, part.locked && "locked", part.hidden && "hidden"];
    row.root.setAttribute("aria-label", said.filter(Boolean).join(", "));
  }

  drawMark(button, name, part, words, icon, more = "") {
    if (button.dataset.icon !== icon) button.replaceChildren(sign((button.dataset.icon = icon)));
    button.setAttribute("aria-label", words);
    button.setAttribute("aria-pressed", String(part[name]));
    button.title = words + more;
  }

  key(event) {
    if (this.renaming !== null) return;
    const { key, altKey, ctrlKey, metaKey } = event;
    const last = this.components.length - 1;
    const at = this.selected;
    const to = { ArrowUp: at - 1, ArrowDown: at + 1, Home: 0, End: last }[key];
    if (altKey && (key === "ArrowUp" || key === "ArrowDown")) this.hooks.move(at, Math.min(Math.max(to, 0), last));
    else if (to !== undefined && !ctrlKey && !metaKey && !altKey) this.hooks.select(Math.min(Math.max(to, 0), last));
    else if (key === "F2") this.rename(at);
    else if (key === "ContextMenu" || (key === "F10" && event.shiftKey)) this.hooks.menu(at, this.placeOf(at));
    else if (this.hooks.key(event, at) === false) return;
    event.preventDefault();
    event.stopPropagation();
  }

  placeOf(index) {
    const { left, bottom } = this.rows[index].root.getBoundingClientRect();
    return { x: left + 24, y: bottom };
  }

  // Enter or leaving takes the name, Escape leaves the old one; a refused one stays in the box until it is mended.
  rename(index) {
    if (this.components[index].locked) return this.hooks.locked(index);
    const { name, root } = this.rows[index];
    const before = this.components[index].name;
    const box = el("input", { class: "part-rename", type: "text", maxlength: "80", "aria-label": `Name of ${before}`, "data-testid": "part-rename", spellcheck: "false" });
    box.value = before;
    this.renaming = index;
    root.draggable = false;
    name.replaceChildren(box);
    box.focus();
    box.select();
    let asked = false;
    const end = (focus) => {
      if (this.renaming !== index) return;
      const stayed = document.activeElement === box; // who has gone on meanwhile is not called back
      this.renaming = null;
      root.draggable = true;
      setText(name, this.components[index]?.name ?? before);
      if (focus && stayed) root.focus();
    };
    const take = async (focus) => {
      if (asked || this.renaming !== index) return;
      asked = true;
      const wanted = box.value.trim();
      if (wanted === before || (await this.hooks.rename(index, wanted))) end(focus);
      else box.setAttribute("aria-invalid", "true");
      asked = false;
    };
    box.addEventListener("keydown", (event) => {
      event.stopPropagation();
      if (event.key === "Enter") take(true);
      else if (event.key === "Escape") end(true);
    });
    box.addEventListener("blur", () => (box.getAttribute("aria-invalid") ? end(false) : take(false)));
    for (const kind of ["dblclick", "click", "pointerdown"]) box.addEventListener(kind, (event) => event.stopPropagation());
    return undefined;
  }

  over(event, root) {
    if (this.dragged === null) return;
    event.preventDefault();
    this.unmark();
    const { top, height } = root.getBoundingClientRect();
    root.classList.add(event.clientY < top + height / 2 ? "drop-before" : "drop-after");
  }

  unmark() {
    for (const { root } of this.rows) root.classList.remove("drop-before", "drop-after");
  }

  drop(event, index) {
    event.preventDefault();
    const { dragged } = this;
    const after = this.rows[index].root.classList.contains("drop-after");
    this.unmark((this.dragged = null));
    if (dragged === null || dragged === index) return;
    const place = index + (after ? 1 : 0);
    this.hooks.move(dragged, place > dragged ? place - 1 : place);
  }
}
