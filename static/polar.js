// The dialog "Force data and law": what the forces come from, how well the law fits them, and what they are not.

import { getPolar } from "./api.js";
import { $, el, setText } from "./dom.js";
import { NONE, clockText, fixed, scientific, toDegrees } from "./format.js";
import { prepare } from "./plotcanvas.js";
import { describePolarKeys, readByKeys } from "./polarkeys.js";
import { PolarPlot, drawDot, drawMarker, drawTrim, lawAt, mirrored } from "./polarplot.js";
import { angleAt, locate } from "./series.js";
import { GlidePolarView } from "./glidepolar.js";
import { spansText } from "./held.js";
import { onKey } from "./keys.js";
import { problemNodes } from "./problem.js";
import { onScheme } from "./theme.js";

const NAMES = { lift: "Lift", drag: "Drag", moment: "Moment" };

// Three significant digits.
function short(value) {
  if (!value || !Number.isFinite(value)) return fixed(value, 0);
  const size = Math.floor(Math.log10(Math.abs(value)));
  return size < -3 ? scientific(value, 2) : fixed(value, Math.max(2 - size, 0));
}

function legendKey(draw) {
  const canvas = el("canvas", { "aria-hidden": "true" });
  draw(prepare(canvas, 16, 14));
  return canvas;
}

function legend({ data, chosen, law, folds }, { whole, trims }) {
  const items = data.map(({ speed }, k) => [`${speed} m/s`, legendKey((c) => drawMarker(c, k, 8, 7))]);
  if (!whole && chosen) items.push([`${chosen.what}: what the law is made from`, legendKey((c) => drawDot(c, 8, 7))]);
  const rows = items.map(([text, key]) => el("span", {}, key, text));
  rows.push(el("span", {}, el("i", { class: "key law" }), `law in use: ${law.what}`));
  rows.push(el("span", {}, el("i", { class: "key now" }), "angle of attack now"));
  trims.forEach(({ words }, k) => rows.push(el("span", { "data-testid": "polar-trim" }, legendKey((c) => drawTrim(c, k + 1, 8, 7)), words)));
  const rest = folds ? "angles measured; the rest by symmetry and reflection" : "angles that the data are meant for";
  if (whole) rows.push(el("span", {}, el("i", { class: "key measured" }), rest));
  return rows;
}

function errorRows({ errors, units }) {
  return errors.map((e) => el("tr", {},
    el("th", { scope: "row" }, NAMES[e.quantity], " ", el("small", {}, units[e.quantity])),
    ...[short(e.rms), short(e.largest), e.largest > 0 ? `${fixed(e.largest_at_deg, 0)}°` : NONE, `${fixed(100 * e.relative, 2)} %`].map((text) => el("td", {}, text))));
}

function provenance({ provenance: { title, source, limits }, reference_density: density, reference_point: point, beyond, sideways, munk }) {
  const about = point.some((v) => v !== 0) ? `(${point.map((v) => fixed(v, 3)).join(", ")}) m` : "the body origin";
  return [
    el("p", {}, el("strong", {}, title)),
    limits ? el("p", { class: "limits" }, el("b", {}, "What they are not. "), limits) : null,
    el("p", {}, el("b", {}, "Source. "), source),
    el("p", {}, el("b", {}, "Reference. "), `Taken at ${density} kg/m³, moments about ${about}, ${munk} the Munk moment.`),
    el("p", {}, el("b", {}, "Range. "), beyond),
    el("p", {}, el("b", {}, "Sideways. "), `${sideways[0].toUpperCase()}${sideways.slice(1)}.`.replace(/\.\.$/, ".")),
  ].filter(Boolean);
}

export function connectPolar({ store, clock }) {
  const dialog = $("polar");
  const plots = Object.keys(NAMES).map((quantity) => new PolarPlot($(`polar-${quantity}`), quantity));
  let shown = null;
  let revision = null;
  let pointed = null;

  const glide = new GlidePolarView({ store, clock });
  const page = () => dialog.querySelector("[name=polar-page]:checked").value;
  const whole = () => dialog.querySelector("[name=polar-range]:checked").value === "whole";

  function angleNow() {
    const run = store.get("state")?.run;
    return run ? toDegrees(angleAt(run.columns.alpha, locate(run.columns.t, clock.t))) : null;
  }

  const told = ({ quantity }, degrees) => `${short(lawAt(shown.law, quantity, degrees))} at ${fixed(degrees, 1)}°`;

  function readAt(degrees) {
    pointed = degrees;
    showAngle();
  }

  function showAngle() {
    if (!dialog.open || !shown) return;
    const angle = angleNow();
    const read = pointed ?? angle;
    for (const plot of plots) {
      plot.showAngle(angle);
      const { quantity } = plot;
      plot.showRead(pointed);
      setText($(`polar-${quantity}-value`), read === null ? "" : told(plot, read));
    }
    const folded = angle !== null && !whole() && mirrored(angle, shown) !== angle;
    setText($("polar-now"), angle === null ? "No glide yet"
      : `At ${clockText(clock.t, clock.end)} the angle of attack is ${fixed(angle, 1)}°${folded ? `, by symmetry drawn at ${fixed(mirrored(angle, shown), 1)}°` : ""}`);
  }

  // Where the steady glides of the schedule's holds lie.
  function trimsShown() {
    const holds = (store.get("consequences")?.holds ?? []).filter(({ trim }) => trim);
    return holds.map(({ trim, spans }) => {
      const attack = toDegrees(trim.angle_of_attack);
      return { attack, words: `trim held ${spansText(spans, clock.end)}, at ${fixed(attack, 2)}°` };
    });
  }

  function draw() {
    if (!dialog.open) return;
    if (page() === "glide") glide.load();
    if (!shown || page() === "glide") return;
    const trims = trimsShown();
    $("polar-legend").replaceChildren(...legend(shown, { whole: whole(), trims }));
    for (const plot of plots) {
      plot.setRange(shown, whole());
      plot.trims = trims;
      plot.draw();
    }
    showAngle();
  }

  function fill() {
    const [low, high] = shown.range_deg;
    setText($("polar-measured"), `${fixed(low, 0)} to ${fixed(high, 0)}°`);
    $("polar-fit").hidden = shown.errors.length === 0;
    $("polar-errors").replaceChildren(...errorRows(shown));
    $("polar-provenance").replaceChildren(...provenance(shown));
    draw();
  }

  async function load() {
    const wanted = store.get("state")?.revision;
    if (!dialog.open || wanted === undefined || wanted === revision) return;
    revision = wanted;
    try {
      const answer = await getPolar();
      if (revision !== wanted) return; // a later change was asked about meanwhile
      shown = answer;
      $("polar-problem").hidden = true;
      fill();
    } catch (error) {
      revision = null; // asked for again at the next change, or when opened again
      $("polar-problem").hidden = false;
      $("polar-problem").replaceChildren(...problemNodes(error.problem ?? { title: error.message }));
    }
  }

  function turn() {
    const forces = page() === "forces";
    $("polar-forces").hidden = !forces;
    $("polar-glide").hidden = forces;
    for (const id of ["polar-now", "polar-angles"]) $(id).hidden = !forces;
    setText($("polar-title"), forces ? "Force data and law" : "Glide polar");
    draw();
  }

  function open(at = "forces") {
    dialog.querySelector(`[name=polar-page][value=${at}]`).checked = true;
    if (!dialog.open) dialog.showModal();
    turn();
    if (shown) fill();
    load();
  }

  $("hydrodynamics").addEventListener("click", () => open());
  $("glide-polar-open").addEventListener("click", () => open("glide"));
  onKey("p", () => open("glide"), { words: "Glide polar", group: "View" });
  for (const radio of dialog.querySelectorAll("[name=polar-page]")) radio.addEventListener("change", turn);
  $("polar-close").addEventListener("click", () => dialog.close());
  // A click on the backdrop is a click on the dialog element itself, outside its box.
  dialog.addEventListener("pointerdown", (event) => {
    const box = dialog.getBoundingClientRect();
    const inside = event.clientX >= box.left && event.clientX <= box.right && event.clientY >= box.top && event.clientY <= box.bottom;
    if (event.target === dialog && !inside) dialog.close();
  });
  for (const radio of dialog.querySelectorAll("[name=polar-range]")) radio.addEventListener("change", draw);
  for (const plot of plots) {
    plot.canvas.addEventListener("pointermove", (event) => readAt(plot.angleUnder(event)));
    plot.canvas.addEventListener("pointerleave", () => readAt(null));
    readByKeys(plot, { start: () => pointed ?? angleNow() ?? 0, onRead: readAt, told });
  }
  describePolarKeys();
  new ResizeObserver(draw).observe(dialog);
  onScheme(() => dialog.open && shown && fill());
  store.watch(["state"], load);
  store.watch(["consequences"], draw);
  clock.watch(showAngle);
  return { open: () => open() };
}
