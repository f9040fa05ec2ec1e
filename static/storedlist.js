// The list of stored designs on the start page: the newest first, searched, a page at a time.

import { listDesigns } from "./api.js";
import { $, el, setText } from "./dom.js";
import { dayAndTime } from "./format.js";

const FIRST = 6;
const MORE = 12;
const PAUSE = 200; // ms between the last key and the search

function card({ id, name, tags, revision, updated }) {
  const address = `d/${encodeURIComponent(id)}`;
  const image = el("img", { src: `${address}/picture`, alt: "", loading: "lazy" });
  image.addEventListener("error", () => image.remove());
  const about = el("p", {}, `Revision ${revision} · `, el("time", { datetime: updated }, dayAndTime(Date.parse(updated))));
  return el("li", { class: "card", "data-testid": `stored-${id}` },
    el("figure", {}, image),
    el("div", { class: "text" },
      el("h3", {}, el("a", { href: address, title: name }, name)), about,
      tags.length ? el("p", { class: "tags" }, ...tags.map((tag) => el("span", {}, tag))) : null));
}

function note(text, action) {
  $("stored-note").hidden = text === "";
  $("stored-note").replaceChildren(text, ...(action ? [action] : []));
}

export function connectStoredList() {
  let next = null;
  let asked = 0;
  let timer = 0;

  async function load({ more = false } = {}) {
    const search = $("stored-search").value.trim();
    const mine = ++asked;
    const query = { search, limit: more ? MORE : FIRST, ...(more ? { cursor: next } : {}) };
    $("stored-more").disabled = true;
    let page;
    try {
      page = await listDesigns(query);
    } catch (error) {
      if (mine === asked) fail(error, more);
      return;
    }
    if (mine !== asked) return; // another search was begun since
    show(page, { search, more });
  }

  function fail(error, more) {
    const retry = el("button", { class: "btn", type: "button", onclick: () => load({ more }) }, "Try again");
    $("stored").hidden = false;
    $("stored-more").hidden = true;
    note(`The stored designs could not be loaded: ${error.problem?.detail ?? error.message}.`, retry);
  }

  function show({ items, next: following }, { search, more }) {
    const cards = items.map(card);
    next = following;
    if (more) $("stored-list").append(...cards);
    else $("stored-list").replaceChildren(...cards);
    $("stored").hidden = items.length === 0 && search === "" && !more;
    $("stored-more").hidden = next === null;
    $("stored-more").disabled = false;
    note(items.length || more ? "" : `No stored design holds “${search}” in its name, notes or tags.`);
    if (more) cards[0]?.querySelector("a").focus();
    setText($("stored-status"), search && items.length ? `${next ? "more than " : ""}${$("stored-list").children.length} found` : "");
  }

  $("stored-search").addEventListener("input", () => {
    clearTimeout(timer);
    timer = setTimeout(load, PAUSE);
  });
  $("stored-more").addEventListener("click", () => load({ more: true }));
  load();
  // A page kept by the browser for its back button knows nothing of what was saved since.
  window.addEventListener("pageshow", (event) => event.persisted && load());
}
