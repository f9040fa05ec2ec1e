// What this browser keeps for each design, a value a kind: of a saved design by its id, else of a session.

const MOST_DESIGNS = 40; // whose values of a kind are remembered; the oldest go first

export const designOf = ({ id, origin }) => (origin?.kind === "stored" ? `design ${origin.design_id}` : `session ${id}`);

export class ForDesigns {
  constructor(kind) {
    this.key = `glider-studio.${kind}`;
  }

  all() {
    try {
      const kept = JSON.parse(localStorage.getItem(this.key) ?? "{}");
      return kept && typeof kept === "object" && !Array.isArray(kept) ? kept : {};
    } catch {
      return {};
    }
  }

  read(design) {
    return this.all()[design] ?? null;
  }

  // Null is nothing to keep.
  write(design, value) {
    const { [design]: _, ...others } = this.all();
    const rest = Object.entries(others).slice(-(MOST_DESIGNS - 1));
    try {
      localStorage.setItem(this.key, JSON.stringify(Object.fromEntries(value === null ? rest : [...rest, [design, value]])));
    } catch {
      // Held by this page alone where the browser keeps nothing.
    }
  }
}
