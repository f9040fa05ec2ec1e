// Which points of which lanes are chosen, by cell and index.

export class Selection {
  constructor(onChange) {
    this.chosen = new Map();
    this.onChange = onChange;
  }

  of(cell) {
    return this.chosen.get(cell) ?? new Set();
  }

  has(cell, k) {
    return this.of(cell).has(k);
  }

  get cells() {
    return [...this.chosen.keys()];
  }

  get size() {
    return this.cells.reduce((sum, cell) => sum + this.of(cell).size, 0);
  }

  // `chosen` is a list of [cell, indices].
  set(chosen) {
    this.chosen = new Map(chosen.filter(([, ks]) => [...ks].length).map(([cell, ks]) => [cell, new Set(ks)]));
    this.onChange();
  }

  only(cell, k) {
    this.set([[cell, [k]]]);
  }

  toggle(cell, k) {
    const ks = new Set(this.of(cell));
    if (!ks.delete(k)) ks.add(k);
    this.set([...[...this.chosen].filter(([name]) => name !== cell), [cell, ks]]);
  }

  add(chosen) {
    const cells = new Set([...this.cells, ...chosen.map(([cell]) => cell)]);
    const more = new Map(chosen);
    this.set([...cells].map((cell) => [cell, [...this.of(cell), ...(more.get(cell) ?? [])]]));
  }

  clear() {
    if (this.size) this.set([]);
  }

  // Points that are no longer there cannot stay chosen.
  prune(countOf) {
    if (this.cells.every((cell) => Math.max(...this.of(cell)) < countOf(cell))) return;
    this.set([...this.chosen].map(([cell, ks]) => [cell, [...ks].filter((k) => k < countOf(cell))]));
  }
}
