// The played range and whether it goes round, kept by this browser for each design.

import { ForDesigns, designOf } from "./fordesign.js";

const isRange = (one) => one === null || (Number.isFinite(one?.from) && Number.isFinite(one?.to) && one.from < one.to);

export function connectPlayedRange({ store, clock }) {
  const kept = new ForDesigns("played");
  let design = null;
  let written = { range: null, loop: false };

  function write() {
    const { asked: range, loop } = clock;
    kept.write(design, range || loop ? { range, loop } : null);
    written = { range, loop };
  }

  store.watch(["state"], ({ state }) => {
    if (!state || designOf(state) === design) return;
    const first = design === null;
    design = designOf(state);
    const found = kept.read(design);
    // Saved as a design of its own, it takes its range with it.
    if (found && isRange(found.range)) clock.ask(found.range, Boolean(found.loop));
    else if (!first) write();
  });
  clock.watch(() => design && (clock.asked !== written.range || clock.loop !== written.loop) && write());
}
