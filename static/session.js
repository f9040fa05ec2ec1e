// What the page asks of the server, and the state it hears back.

import * as api from "./api.js";

const REFUSED = "The change was refused"; // as the state says it: the document itself is as good as before
const RETRY = 2000; // ms, where the browser itself gives up on the event stream

export function createActions(store) {
  const unsent = []; // changes that found no server; made again, in their order, once it is back

  // `again` is for calls that may be made twice.
  async function act(call, { keepProblem = false, again = false, onRefused = () => {} } = {}) {
    store.set({ busy: store.get("busy") + 1 });
    try {
      const answer = await call();
      store.set({ rejected: null, awaited: answer?.revision ?? store.get("awaited") });
      return answer;
    } catch (error) {
      const problem = toldOf(error, { again, keepProblem });
      if (again && problem.unreachable) unsent.push(call);
      // The server keeps the last rejected edit in its state; other refusals only this page knows.
      store.set({ rejected: problem, rejectedHere: keepProblem || problem.status !== 422 });
      onRefused(problem);
      return undefined;
    } finally {
      store.set({ busy: store.get("busy") - 1 });
    }
  }
  const drag = api.latestWins((patch, gesture) => act(() => api.edit(patch, gesture)));
  return {
    act,
    edit: (patch, options) => act(() => api.edit(patch), { again: repeatable(patch), ...options }),
    // The studio is back, perhaps begun anew: what was said of its absence is over, and what it missed is sent.
    async resume() {
      store.set({ awaited: 0, rejected: store.get("rejected")?.unreachable ? null : store.get("rejected") });
      for (const call of unsent.splice(0)) await act(call, { again: true });
    },
    editLatest: drag,
    undo: () => store.get("state")?.can_undo && act(api.undo),
    redo: () => store.get("state")?.can_redo && act(api.redo),
    trim: () => act(api.trimBallast),
    open: (read) => act(async () => api.openDesign(await read()), { keepProblem: true }),
    select: (index) => index !== undefined && act(() => api.selectComponent(index)),
    camera: (view, covered) => act(() => api.setCamera(view, covered)),
  };
}

// Where nothing is added or removed, a change that did arrive is the same when it is made again.
export const repeatable = (patch) => patch.every(({ op }) => op === "replace");

function toldOf(error, { again, keepProblem }) {
  const told = error.problem ?? { title: error.message };
  const problem = told.status === 422 && !keepProblem ? { ...told, title: REFUSED } : told;
  return again && problem.unreachable ? { ...problem, detail: "The change is kept in this page, and sent once the studio is back." } : problem;
}

function take(store, state) {
  const keep = store.get("rejected") && store.get("rejectedHere");
  const consequences = newer(store.get("consequences"), state);
  store.set({ state, consequences, connected: true, rejected: keep ? store.get("rejected") : null });
}

// An event stream's refusal has no reason that script can read; the state's has.
async function askWhy(store) {
  try {
    take(store, await api.getState());
  } catch (error) {
    const gone = [403, 404].includes(error.problem?.status);
    const rejected = { title: "This session is over", detail: "Go back to the presets and open a saved design file there." };
    if (gone) store.set({ over: true, rejected, rejectedHere: true });
    else store.set({ connected: false });
  }
}

// They also come by themselves, sooner than a state that holds them: an older state must not bring older ones back.
function newer(heard, { consequences, run }) {
  return heard && consequences && heard.run > consequences.run && heard.run <= (run?.number ?? 0) ? heard : consequences;
}

// Hears the state at once and after each change.
export function follow(store, actions) {
  let source = null;
  let before = null; // what was selected when the connection was lost: a studio that began anew does not know
  async function recover(selected) {
    before = null;
    if (selected !== undefined) await api.selectComponent(selected).catch(() => {});
    await actions.resume();
  }
  function connect() {
    source = new EventSource("events");
    source.addEventListener("state", ({ data }) => take(store, JSON.parse(data)));
    source.addEventListener("consequences", ({ data }) => store.set({ consequences: JSON.parse(data) }));
    source.addEventListener("open", () => {
      store.set({ connected: true });
      if (before) recover(before.selected);
    });
    source.addEventListener("error", async () => {
      before ??= { selected: store.get("state")?.selected };
      store.set({ connected: false });
      if (source.readyState !== EventSource.CLOSED) return;
      await askWhy(store);
      if (!store.get("over")) setTimeout(connect, RETRY);
    });
  }
  connect();
  window.addEventListener("pagehide", () => source.close());
  window.addEventListener("pageshow", (event) => event.persisted && connect());
}
