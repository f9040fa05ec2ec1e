// The right column: what the design and its glide amount to, in numbers.

import { call } from "./api.js";
import { BALANCE, ENERGY, MARGINS, settlesIn, TRIM, withinSource } from "./consequencerows.js";
import { $, el, setText } from "./dom.js";
import { clockText, degrees, fixed, trueMinus } from "./format.js";
import { connectGroups } from "./groups.js";
import { heldAt, isLeftOut, spansText } from "./held.js";
import { isReady } from "./keptruns.js";
import { showReach } from "./reach.js";
import { END, NOW, NUMERICS, TITLES } from "./readoutrows.js";
import { fillTable, write, writeChange, writeNote } from "./readouttable.js";
import { at, locate } from "./series.js";

const withTitles = (rows) => rows.map(([id, label, unit, show, read, model, more]) => [id, label, unit, show, read, TITLES[id], { model, ...more }]);

// Why there is no trim, and what the glider does instead.
function noTrim({ hold }) {
  if (!hold) return "The schedule holds the cells nowhere: there is no steady glide to tell.";
  if (hold.rest) {
    const roll = Math.abs(hold.rest.roll) > 1e-6 ? `, roll ${degrees(hold.rest.roll)}°` : "";
    return `No steady glide: the glider weighs what it displaces. At rest it hangs at pitch ${degrees(hold.rest.pitch)}°${roll}.`;
  }
  return hold.why ? `No steady glide: ${trueMinus(hold.why)}.` : "";
}

// A steady glide that takes longer to come about than anybody waits for it is not what the run shows.
function tooShort({ trim, spans }, end) {
  const [longest, slowest] = [Math.max(...spans.map(([from, to]) => to - from)), settlesIn(trim)];
  return slowest > longest ? `Held ${clockText(longest, end)}, less than the ${clockText(slowest, slowest)} in which it settles: the run does not come to this glide.` : "";
}

const readyReference = (reference, state) => state?.kept?.find((kept) => kept.id === reference && isReady(kept));

// The kept run that others are compared with: its consequences, asked for once.
function connectReference(store, show) {
  const known = new Map();
  let shown = null;
  store.watch(["reference", "state"], async ({ reference, state }) => {
    const kept = readyReference(reference, state)?.id ?? null;
    if (kept === shown) return;
    shown = kept;
    if (kept && !known.has(kept)) known.set(kept, await call("GET", `runs/${encodeURIComponent(kept)}/consequences`).catch(() => null));
    if (kept === shown) show();
  });
  return () => known.get(shown) ?? null;
}

class Readouts {
  constructor({ store, clock }) {
    Object.assign(this, { store, clock, number: 0 });
    this.now = fillTable($("now"), withTitles(NOW));
    this.ofState = [...fillTable($("end"), withTitles(END)), ...fillTable($("numerics"), withTitles(NUMERICS))];
    const onTime = (t) => clock.seek(t);
    this.trim = fillTable($("trim-now"), TRIM);
    this.held = [...this.trim, ...[["balance", BALANCE], ["margins", MARGINS], ["energy", ENERGY]].flatMap(([id, rows]) => fillTable($(id), rows, { onTime }))];
    this.delta = el("p", { class: "delta-heading", role: "status", "data-testid": "delta-to", hidden: true });
    $("problem").after(this.delta);
    this.reference = connectReference(store, () => this.showHeld());
    store.watch(["reference", "state"], ({ reference, state }) => this.showDelta(readyReference(reference, state)));
    store.watch(["state", "consequences"], () => this.show());
    clock.watch(() => this.showClock());
  }

  get model() {
    const state = this.store.get("state");
    return state?.run?.model ?? state?.model;
  }

  showDelta(kept) {
    this.delta.hidden = !kept;
    setText(this.delta, kept ? `Δ to ${kept.name}` : "");
    this.delta.title = kept ? `The differences beside the numbers are those to the kept run ${kept.name}` : "";
  }

  show() {
    const state = this.store.get("state");
    if (!state) return;
    $("pane-readouts").classList.toggle("dense", this.model === "spatial");
    for (const item of [...this.now, ...this.ofState, ...this.held]) item.root.hidden = Boolean(item.model) && item.model !== this.model;
    for (const item of this.ofState) write(item, item.read(state), { flash: this.number > 0 && item.id !== "elapsed", own: item.unitOf?.(state) });
    setText($("end-message"), trueMinus(state.run?.message) ?? "");
    setText($("energy-message"), this.model === "planar" ? "The planar model keeps no account of the battery; the spatial one does." : "");
    this.showClock();
    this.number = this.store.get("consequences")?.run ?? 0;
    showReach(this.store.get("consequences"), state, (t) => this.clock.seek(t));
  }

  showClock() {
    const run = this.store.get("state")?.run;
    const { t, end } = this.clock;
    const place = run ? locate(run.columns.t, t) : null;
    setText($("now-title"), `Now, at ${clockText(t, end)}`);
    for (const item of this.now) if (!item.root.hidden) write(item, run ? item.read(run, place) : undefined);
    setText($("scene-depth"), run ? `depth ${fixed(at(run.columns.z, place), 3)} m` : "");
    this.showSource(run, place);
    this.showHeld();
  }

  showSource(run, place) {
    const consequences = this.store.get("consequences");
    if (!consequences || !run) return;
    const { inside, text } = withinSource(consequences, run, place);
    setText($("source-now"), text);
    $("source-line").classList.toggle("outside", !inside);
  }

  // Trims, balance and margins: of the hold in force at the clock.
  showHeld() {
    const consequences = this.store.get("consequences");
    const [state, { t, end }] = [this.store.get("state"), this.clock];
    if (!consequences || !state) return;
    const found = heldAt(consequences, t);
    const before = this.reference();
    const flash = this.number > 0 && this.number !== consequences.run;
    const now = { consequences, hold: found?.hold, state, t };
    const then = before && { consequences: before, hold: heldAt(before, t)?.hold, state: null, t };
    for (const item of this.held) {
      if (item.root.hidden && !item.optional) continue;
      const value = item.read(now);
      if (item.optional) item.root.hidden = !Number.isFinite(value);
      write(item, value, { flash });
      writeChange(item, value, then && !item.own ? item.read(then) : NaN);
      writeNote(item, item.readNote?.(now), end);
    }
    this.showTrim(consequences, found, end);
  }

  showTrim(consequences, found, end) {
    const trim = found?.hold.trim ?? null;
    setText($("trim-title"), found ? `Trim, held ${spansText([found.span], end)}` : "Trim");
    $("trim-now").hidden = !trim;
    $("trim-missing").hidden = Boolean(trim);
    setText($("trim-missing"), trim ? "" : consequences.analyses === "compiling" ? "The search for trims is still being compiled for this machine." : noTrim({ hold: found?.hold }));
    const pill = $("trim-stable");
    pill.hidden = !trim;
    if (trim) {
      pill.dataset.stable = String(trim.stable);
      setText(pill, trim.stable ? "stable" : "unstable");
    }
    const others = found?.hold.others ?? 0;
    const [about, left] = [found?.hold.about, consequences.left_out];
    const unreached = consequences.holds.filter(({ reached }) => !reached);
    setText($("held-message"), [
      found && isLeftOut(consequences, this.clock.t, found) ? `What is held now is shorter than the holds told: shown is the one held ${spansText([found.span], end)}.` : "",
      about ? "Cells as they mostly are in this phase." : "",
      trim && found ? tooShort(found.hold, end) : "",
      trim && others ? `${others} other steady motion${others > 1 ? "s" : ""} at these extensions, ${found.hold.stable_others || "none"} of them stable.` : "",
      unreached.length ? `The run ended before what is held ${unreached.map(({ spans }) => spansText(spans, end)).join(", ")}: not reached.` : "",
      left ? `${left} shorter hold${left > 1 ? "s are" : " is"} not told.` : "",
    ].filter(Boolean).join(" "));
  }
}

export function connectReadouts({ store, clock }) {
  connectGroups($("pane-readouts"));
  return new Readouts({ store, clock });
}
