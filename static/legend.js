// The names of a plot's lines beside it, each with its key and its value at the clock and under the cursor.

import { el, setText, svg } from "./dom.js";

const paint = (color) => (color.startsWith("--") ? `var(${color})` : color);

// As the line is drawn: colour and dash.
function key({ color, dash, width }) {
  const mark = svg("line", { x1: 0, y1: 4, x2: 20, y2: 4, "stroke-width": width, "stroke-dasharray": dash.join(" ") });
  mark.style.stroke = paint(color);
  return svg("svg", { class: "key", viewBox: "0 0 20 8", "aria-hidden": "true" }, mark);
}

// A kept run that lies under the lines, by its colour.
function keptName({ name, color }) {
  return el("span", { title: `Kept run: ${name}` }, key({ color, dash: [], width: 1.3 }), el("em", {}, name));
}

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
    const shown = JSON.stringify([kept, series.map(({ id, label, color, dash, width }) => [id, label, color, dash, width])]);
    if (shown === this.shown) return;
    this.shown = shown;
    const output = (id, label, where) => el("output", { class: where, title: `${label} at the ${where}`, "aria-label": `${label} at the ${where}`, "data-testid": `${where === "clock" ? "legend" : where}-${id}` });
    this.values = series.map(({ id, label }) => output(id, label, "clock"));
    this.cursors = series.map(({ id, label }) => output(id, label, "cursor"));
    this.rows.replaceChildren(...series.map((each, i) =>
      el("div", { class: "legend" }, el("span", { title: each.label }, key(each), el("em", {}, each.label)), this.cursors[i], this.values[i])),
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
