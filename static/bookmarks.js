// Bookmarks: moments of the glide with names, kept by this browser for each design.

import { $, el, setText, svg } from "./dom.js";
import { ForDesigns, designOf } from "./fordesign.js";
import { clockText } from "./format.js";
import { onKey } from "./keys.js";
import { connectMenu } from "./menu.js";

const KEPT = new ForDesigns("bookmarks");
const MOST = 50; // of one design
const SAME = 1e-3; // s

const isBookmark = (one) => Number.isFinite(one?.t) && typeof one?.name === "string";

function read(design) {
  const kept = KEPT.read(design);
  return Array.isArray(kept) ? kept.filter(isBookmark).slice(0, MOST) : [];
}

const cross = () => svg("svg", { viewBox: "0 0 16 16", "aria-hidden": "true" }, svg("path", { d: "m4 4 8 8m0-8-8 8" }));

function row(bookmark, k, { clock, jump, rename, remove, close }) {
  const time = clockText(bookmark.t, clock.end);
  const name = el("input", { type: "text", maxlength: "60", value: bookmark.name, "aria-label": `Name of the bookmark at ${time}`, "data-testid": `bookmark-name-${k}` });
  name.addEventListener("change", () => rename(bookmark, name.value));
  name.addEventListener("keydown", (event) => {
    if (event.key !== "Enter") return;
    event.preventDefault(); // else it would press what gets the focus next, and open the menu again
    close();
  });
  return el("li", {},
    el("button", { class: "btn small", type: "button", title: "Go there", "aria-label": `Go to ${bookmark.name}, ${time}`, "data-testid": `bookmark-${k}`, onclick: () => jump(bookmark) }, time),
    name,
    el("button", { class: "btn icon quiet-icon", type: "button", "aria-label": `Delete ${bookmark.name}`, "data-testid": `bookmark-delete-${k}`, onclick: () => remove(bookmark) }, cross()));
}

export function connectBookmarks({ store, clock }) {
  const menu = $("bookmarks");
  let design = null;
  const shut = connectMenu(menu);

  const list = () => store.get("bookmarks");
  function keep(bookmarks) {
    const sorted = [...bookmarks].sort((a, b) => a.t - b.t);
    store.set({ bookmarks: sorted });
  }

  const acts = {
    clock,
    close() {
      shut(); // the field loses the focus, and with it the name is taken
      menu.querySelector("summary").focus();
    },
    jump: ({ t }) => clock.seek(t),
    rename: (one, text) => keep(list().map((each) => (each === one ? { ...one, name: text.trim() || one.name } : each))),
    remove: (one) => keep(list().filter((each) => each !== one)),
  };

  function add() {
    if (!design || clock.end <= 0) return;
    clock.pause();
    const there = list().find(({ t }) => Math.abs(t - clock.t) < SAME);
    if (!there && list().length < MOST) keep([...list(), { t: clock.t, name: `Bookmark ${list().length + 1}` }]);
    const k = list().findIndex(({ t }) => Math.abs(t - clock.t) < SAME);
    menu.open = true;
    $("bookmark-list").querySelectorAll("input")[k]?.select();
  }

  function go(direction) {
    const { t } = clock;
    const next = direction > 0 ? list().find((one) => one.t > t + SAME) : list().findLast((one) => one.t < t - SAME);
    if (next) clock.seek(next.t);
  }

  function show() {
    const bookmarks = list();
    setText($("bookmark-count"), bookmarks.length ? String(bookmarks.length) : "");
    $("bookmark-none").hidden = bookmarks.length > 0;
    $("bookmark-list").replaceChildren(...bookmarks.map((one, k) => row(one, k, acts)));
    $("bookmark-add").disabled = bookmarks.length >= MOST;
  }

  store.watch(["bookmarks"], ({ bookmarks }) => {
    if (design) KEPT.write(design, bookmarks.length ? bookmarks : null); // the timeline drags them, too
    show();
  });
  store.watch(["state"], ({ state }) => {
    if (!state || designOf(state) === design) return;
    const before = design === null ? [] : list();
    design = designOf(state);
    // Saved as a design of its own, it takes its bookmarks with it.
    const kept = read(design);
    if (kept.length || !before.length) store.set({ bookmarks: kept });
    else keep(before);
  });
  // Times are written in the unit that suits the run.
  let end = clock.end;
  clock.watch(() => end !== clock.end && ((end = clock.end), show()));
  $("bookmark-add").addEventListener("click", add);
  onKey("b", add, { words: "Bookmark this moment", group: "Playback" });
  onKey("[", () => go(-1), { words: "To the bookmark before", group: "Playback" });
  onKey("]", () => go(1), { words: "To the next bookmark", group: "Playback" });
}
