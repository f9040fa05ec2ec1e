// The left panel: the list of parts with its buttons, and the fields below. It keeps no document of its own: everything
// is asked of the server, and drawn from what it answers.

import { editPaired, latestWins } from "./api.js";
import { $, el } from "./dom.js";
import { describeKey } from "./keys.js";
import { addPart, copyPart, getFields, getSchema, linkPairs, markPart, mirrorPart, movePart, removePart, setMassProperties } from "./partsapi.js";
import { PartsForm } from "./partsform.js";
import { kindIcon, sign } from "./partsicons.js";
import { closeMenu, openMenu } from "./partsmenu.js";
import { PartsTree, STILL_THERE } from "./partstree.js";
import { repeatable } from "./session.js";
import { onUnits, suitUnits } from "./unitchoice.js";

export const FOCUS_FIELD = "studio:focus-field";
const PAUSE = 100; // ms between two fetches of the fields while something is dragged

// What the palette offers, and what it is in a few words.
const PALETTE = [
  ["rigid", "Rigid part", "Fuselage, payload, anything that keeps its shape"],
  ["wing", "Wing", "A plate from tip to tip"],
  ["fin", "Fin", "One panel, upwards"],
  null,
  ["bellows", "Bellows", "A pleated cell that grows along its axis"],
  ["piston", "Piston", "A cell of constant section"],
  ["bladder", "Bladder", "A cell with a measured table of volumes"],
  null,
  ["movable_mass", "Movable mass", "Slides along an axis inside the hull"],
  ["rolling_mass", "Rolling mass", "Turns about an axis, and banks the glider"],
  ["ballast", "Ballast", "A bar of lead"],
  ["core_sampler", "Core sampler", "A closed tube under the hull"],
];
const IN_SPACE = "It rolls out of the vertical plane: choose the spatial model first, under Mission and solver";
const NO_SIDES = "In the vertical plane it has no side: choose the spatial model first, under Mission and solver";
const MIRROR = "Mirror port and starboard";

// Selects the component, opens the section, and gives the field at a pointer of the document the focus.
export function focusField(pointer) {
  document.dispatchEvent(new CustomEvent(FOCUS_FIELD, { detail: { pointer } }));
}

class Parts {
  constructor({ store, actions, showForces }) {
    Object.assign(this, { store, actions, showForces, schema: null, fields: null, waiting: null, senders: new Map() });
    const scroller = el("div", { class: "parts-form", tabindex: "-1" });
    const list = el("ul", { class: "parts-tree", role: "tree", "aria-label": "Components", "data-testid": "parts-tree" });
    $("parts").replaceChildren(this.head(), list, scroller);
    this.tree = new PartsTree(list, {
      select: (index) => index !== this.selected && actions.select(index),
      rename: (index, name) => actions.edit([{ op: "replace", path: `/vehicle/components/${index}/name`, value: name }]),
      locked: (index) => this.sayLocked(index),
      move: (index, to) => index !== to && this.act(() => movePart(index, to)),
      mark: (index, marks) => this.act(() => markPart(index, marks)),
      menu: (index, place) => this.menu(index, place),
      key: (event, index) => this.key(event, index),
    });
    this.form = new PartsForm(scroller, { change: (spec, value) => this.change(spec, value), press: (name) => name === "forces" && this.showForces(), unlock: () => this.act(() => markPart(this.selected, { locked: false })),
      link: (linked) => this.act(() => linkPairs(linked)) });
    this.fetch = latestWins(() => this.refresh());
    onUnits(() => this.draw());
    store.watch(["state"], ({ state }) => state && this.follow(state));
    document.addEventListener(FOCUS_FIELD, ({ detail }) => this.focus(detail.pointer));
  }

  get selected() {
    return this.store.get("state")?.selected ?? 0;
  }

  head() {
    const button = (name, words, run, attributes = {}) => el("button", { type: "button", class: "part-tool", "aria-label": words, title: words, "data-testid": `parts-${name}`, onclick: run, ...attributes }, sign(name));
    this.adder = el("button", { type: "button", class: "btn small part-add", "aria-haspopup": "menu", "aria-expanded": "false", "data-testid": "parts-add", title: "Add a part (A)", onclick: () => this.palette() }, sign("add"), "Add");
    this.more = button("more", "More for the selected part", () => this.menu(this.selected, placeUnder(this.more), this.more), { "aria-haspopup": "menu", "aria-expanded": "false" });
    return el("div", { class: "parts-head" }, el("h2", {}, "Components"), el("span", { class: "spring" }),
      el("div", { class: "parts-tools", role: "toolbar", "aria-label": "Selected part" },
        button("copy", "Duplicate (Ctrl+D)", () => this.act(() => copyPart(this.selected))),
        (this.mirrorer = button("mirror", `${MIRROR} (M)`, () => this.act(() => mirrorPart(this.selected, null)))),
        button("remove", "Remove (Delete)", () => this.act(() => removePart(this.selected))), this.more),
      this.adder);
  }

  act(call) {
    return this.actions.act(call);
  }

  // Before anybody types what would be refused.
  sayLocked(index) {
    const { name } = this.store.get("state").components[index];
    const detail = "Its name stays as it is until it is unlocked: by its lock in the list of parts, or by L there.";
    this.store.set({ rejected: { title: `${name} is locked`, detail }, rejectedHere: true });
  }

  // Of the changes of one field the newest wins; those of different fields all arrive.
  async change(spec, value) {
    const patch = spec.call ? null : spec.write(value);
    if (patch?.length === 0) return { ok: true };
    if (!this.senders.has(spec.key)) this.senders.set(spec.key, latestWins((call, again) => this.ask(call, again)));
    return this.senders.get(spec.key)(spec.call ? () => setMassProperties(spec.call(value)[1]) : () => editPaired(patch), !patch || repeatable(patch));
  }

  async ask(call, again) {
    let problem = null;
    const answer = await this.actions.act(call, { again, onRefused: (told) => (problem = told) });
    const known = Math.max(this.store.get("state").revision, this.store.get("awaited"));
    return problem ? { ok: false, problem, revision: known } : { ok: true, revision: answer?.revision };
  }

  follow(state) {
    this.tree.update(state);
    this.mirrorer.disabled = this.sideless(state.selected);
    this.mirrorer.title = this.mirrorer.disabled ? `${MIRROR}. ${NO_SIDES}` : `${MIRROR} (M)`;
    if (!this.fields || this.fields.revision !== state.revision) this.fetch();
    else this.draw();
  }

  async refresh() {
    try {
      this.schema ??= await getSchema();
      this.fields = await getFields();
    } catch {
      return; // the connection notice already says it; the next state asks again
    }
    suitUnits(this.fields.facts.mass.mass);
    this.draw();
    this.tree.draw();
    await new Promise((done) => setTimeout(done, PAUSE));
  }

  draw() {
    const state = this.store.get("state");
    if (!state || !this.fields) return;
    const name = state.components[state.selected]?.name;
    const index = this.fields.design.vehicle.components.findIndex((part) => part.name === name);
    if (index < 0) return;
    this.form.update({ ...this.fields, schema: this.schema, state, index });
    if (this.waiting && [null, state.selected].includes(this.form.partOf(this.waiting))) this.focus(this.waiting);
  }

  // A part has to be chosen, and its fields to be there, first.
  focus(pointer) {
    const index = this.fields ? this.form.partOf(pointer) : null;
    if (index !== null && !this.store.get("state").components[index]) return this.tree.point(); // refused: it is not there
    const ready = this.fields && (index === null || index === this.selected);
    this.waiting = ready ? null : pointer;
    if (ready) this.form.focus(pointer) || this.tree.point();
    else if (index !== null) this.actions.select(index);
  }

  // In the plane a part on the axis stays its own mirror image: no field lets it leave.
  sideless(index) {
    const { model, components } = this.store.get("state");
    return model === "planar" && components[index]?.position[1] === 0;
  }

  palette() {
    const planar = this.store.get("state")?.model === "planar";
    const items = PALETTE.map((entry) => {
      if (!entry) return null;
      const [kind, label, about] = entry;
      const barred = planar && kind === "rolling_mass";
      return { label, about: barred ? IN_SPACE : about, icon: kindIcon(kind), disabled: barred, run: () => this.act(() => addPart(kind)) };
    });
    openMenu(placeUnder(this.adder), items, { label: "Add a part", anchor: this.adder });
  }

  menu(index, place, anchor = null) {
    const part = this.store.get("state").components[index];
    const last = this.store.get("state").components.length - 1;
    const disabled = this.sideless(index);
    const about = disabled ? NO_SIDES : undefined;
    const mirror = (schedule) => ({ icon: sign("mirror"), disabled, run: () => this.act(() => mirrorPart(index, schedule)) });
    openMenu(place, [
      { label: "Rename", icon: sign("rename"), keys: "F2", run: () => this.tree.rename(index) },
      { label: "Duplicate", icon: sign("copy"), keys: "Ctrl+D", run: () => this.act(() => copyPart(index)) },
      { label: MIRROR, keys: "M", about, ...mirror(null) },
      ...(part.moves ? [{ label: "Mirror with its schedule", ...mirror("same") }, { label: "Mirror with the opposite schedule", ...mirror("opposite") }] : []),
      null,
      { label: "Move up", icon: sign("up"), keys: "Alt+↑", disabled: index === 0, run: () => this.act(() => movePart(index, index - 1)) },
      { label: "Move down", icon: sign("down"), keys: "Alt+↓", disabled: index === last, run: () => this.act(() => movePart(index, index + 1)) },
      null,
      { label: "Lock", icon: sign("lock"), keys: "L", checked: part.locked, run: () => this.act(() => markPart(index, { locked: !part.locked })) },
      { label: "Hide", about: STILL_THERE[0].toUpperCase() + STILL_THERE.slice(1), icon: sign("hidden"), keys: "H", checked: part.hidden, run: () => this.act(() => markPart(index, { hidden: !part.hidden })) },
      null,
      { label: "Remove", icon: sign("remove"), keys: "Delete", disabled: last === 0, run: () => this.act(() => removePart(index)) },
    ], { label: part.name, anchor });
  }

  key(event, index) {
    const part = this.store.get("state").components[index];
    const modified = event.ctrlKey || event.metaKey;
    const key = event.key.length === 1 ? event.key.toLowerCase() : event.key;
    if (modified && key === "d") this.act(() => copyPart(index));
    else if (modified || event.altKey) return false;
    else if (key === "Delete" || key === "Backspace") this.act(() => removePart(index));
    else if (key === "a") this.palette();
    else if (key === "m") this.act(() => mirrorPart(index, null));
    else if (key === "l") this.act(() => markPart(index, { locked: !part.locked }));
    else if (key === "h") this.act(() => markPart(index, { hidden: !part.hidden }));
    else if (key === "Enter") this.form.focus(`/vehicle/components/${index}/position/0`);
    else return false;
    return true;
  }
}

function placeUnder(node) {
  const { left, bottom } = node.getBoundingClientRect();
  return { x: left, y: bottom + 4 };
}

const KEYS = [
  [["ArrowUp", "ArrowDown"], "Choose a part"], [["F2", "double click"], "Rename it"], [["Alt+ArrowUp", "Alt+ArrowDown"], "Move it up or down the list"], ["Ctrl+D", "Duplicate it"],
  ["M", "Mirror it port and starboard"], ["L", "Lock or unlock it"], ["H", "Hide or show it"], ["Delete", "Remove it"], ["A", "Add a part"], ["Enter", "To its fields"],
  ["F1", "In a field: what it is"], [["ArrowUp", "ArrowDown"], "In a field: step its number (Shift: ten times, Alt: a tenth)"], ["Alt+U", "In a field: the next unit"], ["drag", "On a field's name: change its number (Shift: ten times, Alt: a tenth)"],
  ["Shift+F10", "On a part: its menu"],
];

export function connectParts(connected) {
  for (const [keys, words] of KEYS) describeKey(keys, words, "Parts");
  const parts = new Parts(connected);
  window.addEventListener("pagehide", () => closeMenu());
  return parts;
}
