// Hears of jobs as they change. A browser opens six connections to one host in all: a stream holds one for as long as it
// is open, so few jobs are streamed, none while the page is hidden, and the rest is asked for.

import { getJob, eventsAddress } from "./jobapi.js";
import { isOver } from "./jobwords.js";

const RETRY = 2000; // ms, where the browser itself gives up on a stream

// Follows one job until it is over; returns how to stop.
export function watchJob(id, { onJob, onLinked, onGone }) {
  let source = null;
  let timer = null;
  let stopped = false;

  function take(job) {
    if (stopped) return;
    onLinked?.(true);
    onJob(job);
    if (isOver(job)) stop();
  }

  async function ask() {
    try {
      take(await getJob(id));
    } catch (error) {
      if (stopped) return;
      if (error.problem?.status === 404) return void (stop(), onGone?.());
      onLinked?.(false);
    }
    if (!stopped) timer = setTimeout(connect, RETRY);
  }

  function connect() {
    if (stopped || document.visibilityState === "hidden") return;
    source = new EventSource(eventsAddress(id));
    source.addEventListener("job", (event) => take(JSON.parse(event.data)));
    source.addEventListener("open", () => onLinked?.(true));
    source.addEventListener("error", () => {
      onLinked?.(false);
      if (source.readyState === EventSource.CLOSED) ask(); // a refusal of the stream says no reason
    });
  }

  function disconnect() {
    clearTimeout(timer);
    source?.close();
    source = null;
  }

  function onVisibility() {
    if (document.visibilityState === "hidden") disconnect();
    else if (!source) connect();
  }

  function stop() {
    stopped = true;
    disconnect();
    document.removeEventListener("visibilitychange", onVisibility);
  }

  document.addEventListener("visibilitychange", onVisibility);
  connect();
  return stop;
}

// Keeps streams open for the first few of the jobs that are named.
export class Streams {
  constructor(most, { onJob, onGone }) {
    Object.assign(this, { most, onJob, onGone });
    this.open = new Map();
  }

  follow(ids) {
    const wanted = ids.slice(0, this.most);
    for (const [id, stop] of this.open) {
      if (wanted.includes(id)) continue;
      stop();
      this.open.delete(id);
    }
    for (const id of wanted) {
      if (this.open.has(id)) continue;
      this.open.set(id, watchJob(id, { onJob: (job) => this.onJob(job), onGone: () => this.onGone(id) }));
    }
  }
}
