// The names of a plot's lines beside it, each with its key and its value at the clock.

import { el, setText } from "./dom.js";

export class Legend {
  constructor(root) {
    this.root = root;
    this.values = [];
  }

  // Anew only where the plot shows other lines.
  show({ title, series }) {
    if (series === this.series) return;
    this.series = series;
    this.values = series.map(({ name }) => el("output", { "data-testid": `legend-${name}` }));
    const rows = series.map(({ name, label }, i) => el("div", { class: "legend" }, el("span", {}, el("i", { class: `key ${name}` }), label), this.values[i]));
    this.root.replaceChildren(el("h3", {}, title), ...rows);
  }

  write(described) {
    this.values.forEach((node, i) => setText(node, described[i]?.[1] ?? ""));
  }
}
