// The names of a plot's lines beside it, each with its key and its value at the clock and under the cursor.

import { el, setText, svg, swatch } from "./dom.js";
import { KEPT_WIDTH } from "./plots.js";

const LINE = 4; // pixels from one line of a key to the next

const paint = (color) => (color.startsWith("--") ? `var(${color})` : color);

// As the lines are drawn, by colour and dash: the present run's, and below it those of kept runs.
function key({ color, dash, width, kept }) {
  const lines = [{ color, width }, ...kept.map((run) => ({ color: run.color, width: KEPT_WIDTH }))];
  const height = LINE * (lines.length + 1);
  const marks = lines.map((each, i) => {
    const y = LINE * (i + 1);
    const mark = svg("line", { x1: 0, y1: y, x2: 20, y2: y, "stroke-width": each.width, "stroke-dasharray": dash.join(" ") });
    mark.style.stroke = paint(each.color);
    return mark;
  });
  return svg("svg", { class: "key", width: 20, height, viewBox: `0 0 20 ${height}`, "aria-hidden": "true" }, ...marks);
}

// A kept run that lies under the lines, by its colour.
function keptName({ name, color }) {
  return el("span", { title: `Kept run: ${name}` }, swatch(paint(color)), el("em", {}, name));
}

const titleOf = ({ label, kept }) => (kept.length ? `${label}; with the same dash in their colours: ${kept.map(({ name }) => name).join(", ")}` : label);

export class Legend {
  // `menu` is the button beside the title.
  constructor(root, menu) {
    Object.assign(this, { root, title: el("h3", {}), values: [], cursors: [], shown: "" });
    this.rows = el("div", { class: "legend-rows", tabindex: "0", role: "group", "aria-label": "Legend" });
    root.append(el("div", { class: "legend-head" }, this.title, menu), this.rows);
  }

  // Anew only where the plot shows other lines.
  show({ title, series }) {
    setText(this.title, title);
    this.title.title = title;
    const kept = [...new Map(series.flatMap((each) => each.kept).map(({ name, color }) => [`${name} ${color}`, { name, color }])).values()];
    const shown = JSON.stringify([kept, series.map(({ id, label, color, dash, width, kept: laid }) => [id, label, color, dash, width, laid.length])]);
    if (shown === this.shown) return;
    this.shown = shown;
    const output = (id, label, where) => el("output", { class: where, title: `${label} at the ${where}`, "aria-label": `${label} at the ${where}`, "data-testid": `${where === "clock" ? "legend" : where}-${id}` });
    this.values = series.map(({ id, label }) => output(id, label, "clock"));
    this.cursors = series.map(({ id, label }) => output(id, label, "cursor"));
    this.rows.replaceChildren(...series.map((each, i) =>
      el("div", { class: "legend" }, el("span", { title: titleOf(each) }, key(each), el("em", {}, each.label)), this.cursors[i], this.values[i])),
    ...(kept.length ? [el("div", { class: "kept-names", role: "group", "aria-label": "Kept runs laid under" }, ...kept.map(keptName))] : []));
  }

  write(described) {
    this.values.forEach((node, i) => setText(node, described[i]?.[1] ?? ""));
  }

  writeCursor(described) {
    // The unit stands at the clock's value, close by.
    this.cursors.forEach((node, i) => setText(node, described?.[i]?.[1].split(" ")[0] ?? ""));
  }
}
