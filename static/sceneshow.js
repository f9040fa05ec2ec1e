// Moves the 3D scene with the clock: what it should show at each moment, and the ghost of a kept run beside it.

import { postClock, postShown, showInScene } from "./api.js";
import { $, setText } from "./dom.js";
import { fixed } from "./format.js";
import { columnsOf, isReady } from "./keptruns.js";
import { bedInSight, largestForce, largestMoment, pathBox, positionAt, sceneAt, visibility } from "./scene.js";
import { Viewer } from "./viewer.js";

const BEACON = 0.012; // of the path's size: how large the ball that stands for the glider is in the overview
const GHOST_COLUMNS = { planar: ["x", "z", "theta"], spatial: ["x", "y", "z", "q0", "q1", "q2", "q3"] };

export function connectScene({ store, clock, onKey }) {
  let largest = { force: 0, turn: 0 };
  let anchor = null; // what the view stays on: the glider, or where it was when following was turned off
  let ghost = null; // the columns of the kept run that flies along
  const view = () => store.get("view");

  // Without a run there is nothing to point the arrows by.
  function shown() {
    const state = store.get("state");
    const { forces, moments } = view();
    const [run, bed] = [state?.run, bedInSight(state, clock.t)];
    return { ...view(), forces: forces && Boolean(run), moments: moments && Boolean(run), spatial: run?.model === "spatial", bed };
  }

  const viewer = new Viewer($("view"), {
    visibilityOf: (name) => visibility(name, shown()),
    onLink: (viewerLinked) => store.set({ viewerLinked }),
    onKey,
    // A part that is dragged moves along the axes of the glider as this page shows it, which the server does not know.
    onGrab: () => {
      const pose = viewer.wanted.get("/glider");
      if (pose) postShown(pose.wxyz).catch(() => {});
    },
    postClock,
  });

  function show() {
    const state = store.get("state");
    if (!state?.run) return;
    const { follow, exaggeration, camera, offset } = view();
    const far = camera === "overview" && pathBox(state.run);
    if (far && !follow) anchor = far.middle;
    else if (follow || !anchor) anchor = positionAt(state.run, clock.t);
    // Chasing means to stay behind: the view turns with the glider.
    const how = { anchor, exaggeration, offset, largest: largest.force, largestTurn: largest.turn, turning: camera === "chase" };
    const wanted = sceneAt(state, clock.t, { ...how, beacon: far && BEACON * far.size, ghost });
    viewer.show(store.get("modePlay")?.onto(wanted) ?? wanted, clock.t);
    tellGhost(state);
  }

  // In words too, as it may be out of sight.
  function tellGhost(state) {
    const kept = ghost && state.kept.find(({ id }) => id === view().ghost);
    $("scene-ghost").hidden = !kept;
    if (!kept) return;
    const [there, here] = [positionAt({ columns: ghost }, clock.t), positionAt(state.run, clock.t)];
    const away = there.map((v, k) => v - here[k]);
    const deeper = Math.abs(away[2]) < 5e-4 ? "as deep" : `${fixed(Math.abs(away[2]), 3)} m ${away[2] > 0 ? "deeper" : "higher"}`;
    setText($("scene-ghost"), `Ghost ${kept.name}: ${fixed(Math.hypot(...away), 3)} m away, ${deeper}`);
  }

  // The server draws the ghost for all pages of the session; each moves it by its own clock.
  async function callGhost() {
    const state = store.get("state");
    const wanted = view().ghost;
    const kept = state?.kept?.find(({ id }) => id === wanted);
    if (state && state.scene.ghost !== (kept?.id ?? null)) showInScene({ ghost: kept?.id ?? null }).catch(() => {});
    const columns = kept && isReady(kept) ? await columnsOf(kept.id, GHOST_COLUMNS[kept.model]).catch(() => null) : null;
    ghost = columns && view().ghost === wanted ? { t: columns.t, ...columns.columns } : null;
    show();
  }

  store.watch(["state"], ({ state }) => {
    if (!state) return;
    largest = state.run ? { force: largestForce(state.run.columns), turn: largestMoment(state.run.columns) } : { force: 0, turn: 0 };
    clock.setEnd(state.run?.columns.t.at(-1) ?? 0);
  });
  let [ghostOf, keptBefore] = [undefined, ""];
  store.watch(["state", "view"], ({ state, view: { ghost: wanted } }) => {
    const kept = (state?.kept ?? []).map(({ id, state: its }) => `${id} ${its}`).join();
    if (!state || (wanted === ghostOf && kept === keptBefore)) return;
    const first = ghostOf === undefined;
    [ghostOf, keptBefore] = [wanted, kept];
    // A page that is opened beside another shows the ghost that is there.
    if (first && !wanted && state.scene.ghost) store.set({ reference: state.scene.ghost, view: { ...view(), ghost: state.scene.ghost } });
    else callGhost();
  });
  store.watch(["modePlay"], ({ modePlay }) => (modePlay ? modePlay.follow(show) : show()));
  store.watch(["connected"], ({ connected }) => viewer.setOnline(connected));
  store.watch(["view"], () => {
    show();
    viewer.check();
  });
  clock.watch(show);
  return viewer;
}
