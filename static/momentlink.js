// Links to a moment of a glide: the one to hand on, and the one that this page was opened by.

import { $, setText } from "./dom.js";
import { clockText } from "./format.js";
import { ROOT } from "./root.js";
import { designLink } from "./stored.js";

const SECONDS = 2; // digits of a link's time

// Where what is shown can be found by others, or null.
function linkTo(origin, t) {
  const moment = { t: Number(t.toFixed(SECONDS)) };
  if (origin?.kind === "stored") return designLink(origin.design_id, { revision: origin.revision, ...moment });
  if (origin?.kind !== "case") return null;
  return new URL(`d?${new URLSearchParams({ run: `${origin.job_id}.${origin.case}`, ...moment })}`, ROOT).href;
}

const nameOf = (origin) => (origin.kind === "stored" ? `revision ${origin.revision}` : `case ${origin.case} of the job`);

// The clipboard is closed to pages that came without encryption from another machine.
async function copy(address) {
  try {
    await navigator.clipboard.writeText(address);
    return true;
  } catch {
    $("link-address").select();
    return false;
  }
}

export function connectMomentLink({ store, clock }) {
  async function offer() {
    const origin = store.get("state")?.origin ?? null;
    const address = linkTo(origin, clock.t);
    $("link-row").hidden = address === null;
    $("link-warning").hidden = !origin?.changed;
    if (address === null) return setText($("link-text"), "Only a saved design has a link: save this one first.");
    $("link-address").value = address;
    setText($("link-warning"), `Unsaved changes are not in it: it leads to ${nameOf(origin)} as it is stored. Save first to link to them.`);
    const moment = `${nameOf(origin)} at ${clockText(clock.t, clock.end)}`;
    setText($("link-text"), "");
    setText($("link-text"), `${(await copy(address)) ? "Copied: a link" : "Copy this link"} to ${moment}.`);
  }

  $("link").addEventListener("toggle", () => $("link").open && offer());
  $("link-copy").addEventListener("click", offer);
}

// Shows the moment that the address names, once the glide is there.
export function startAt({ store, clock }) {
  let wanted = new URLSearchParams(location.search).get("t");
  store.watch(["state"], ({ state }) => {
    if (wanted === null || !state?.run || state.simulating) return;
    if (Number.isFinite(Number(wanted))) clock.seek(Number(wanted));
    wanted = null;
  });
}
