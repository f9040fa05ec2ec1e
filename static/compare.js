// The compare menu: keep the present glide, name the kept ones, and choose which one is the reference.
// The reference is drawn as a ghost in the scene (`view.ghost`) and is what others compare with (`reference`).

import { $, el, setText, svg } from "./dom.js";
import { aboutKept, colorOf, forgetRun, keepRun, renameRun } from "./keptruns.js";
import { onKey } from "./keys.js";
import { connectMenu } from "./menu.js";

const MOST = 4; // as the server keeps

const cross = () => svg("svg", { viewBox: "0 0 16 16", "aria-hidden": "true" }, svg("path", { d: "m4 4 8 8m0-8-8 8" }));

// The number says which one it is where colours cannot.
function badge(kept) {
  const node = el("i", { class: "run-badge", "aria-hidden": "true" }, String(kept.place + 1));
  node.style.setProperty("--run", colorOf(kept));
  return node;
}

function row(kept, { reference, choose, rename, forget }) {
  const name = el("input", { type: "text", maxlength: "60", value: kept.name, "aria-label": `Name of kept run ${kept.place + 1}`, "data-testid": `kept-name-${kept.id}` });
  name.addEventListener("change", () => rename(kept, name));
  name.addEventListener("keydown", (event) => event.key === "Enter" && name.blur());
  const chosen = reference === kept.id;
  return el("li", { "data-testid": `kept-${kept.id}` }, badge(kept), name,
    el("span", { class: "run-about" }, aboutKept(kept)),
    el("button", { class: "btn small", type: "button", "aria-pressed": String(chosen), "aria-label": `Reference: ${kept.name}`,
      title: "Drawn as a ghost in the scene, and compared with", "data-testid": `reference-${kept.id}`, onclick: () => choose(chosen ? null : kept.id) }, "Reference"),
    el("button", { class: "btn icon quiet-icon", type: "button", "aria-label": `Delete ${kept.name}`, title: "Delete", "data-testid": `forget-${kept.id}`, onclick: () => forget(kept) }, cross()),
    kept.note && el("p", { class: "run-note", "data-testid": `kept-note-${kept.id}` }, kept.note));
}

// Told where the menu is closed, too.
function showFailed(failed) {
  $("compare-count").classList.toggle("bad", failed.length > 0);
  $("compare").querySelector("summary").title = failed.length ? `Cannot be computed any more: ${failed.map(({ name }) => name).join(", ")}` : "";
}

export function connectCompare({ store }) {
  const menu = $("compare");
  connectMenu(menu);
  const say = (text) => {
    setText($("compare-problem"), text);
    $("compare-problem").hidden = !text;
  };

  async function ask(call) {
    try {
      const answer = await call();
      say("");
      return answer ?? true;
    } catch (error) {
      const problem = error.problem ?? { title: error.message };
      const [first] = problem.errors ?? [];
      say(first ? `${first.message}${first.hint ? `: ${first.hint}` : ""}` : (problem.detail ?? problem.title));
      return null;
    }
  }

  function choose(reference) {
    store.set({ reference, view: { ...store.get("view"), ghost: reference } });
  }

  async function rename(kept, field) {
    if (!(await ask(() => renameRun(kept.id, field.value.trim())))) field.value = kept.name;
  }

  let first = null; // kept where there was no reference: it becomes one as soon as the state tells of it
  async function keep() {
    if ($("keep").disabled) return;
    const answer = await ask(() => keepRun($("keep-name").value.trim()));
    if (!answer) {
      menu.open = true;
      return;
    }
    $("keep-name").value = "";
    if (store.get("reference") === null) first = answer.id;
    show();
  }

  let drawn = "";
  function show() {
    const state = store.get("state");
    const kept = state?.kept ?? [];
    const reference = store.get("reference");
    if (reference && state && !kept.some(({ id }) => id === reference)) return choose(null);
    if (kept.some(({ id }) => id === first)) {
      const id = first;
      first = null;
      if (reference === null) return choose(id);
    }
    $("keep").disabled = !state?.run || kept.length >= MOST;
    $("keep").title = kept.length >= MOST ? `${MOST} runs are kept, the most that can be: delete one first` : "Keep this glide to compare with (K)";
    setText($("compare-count"), kept.length ? String(kept.length) : "");
    showFailed(kept.filter(({ state: its }) => its === "failed"));
    $("compare-none").hidden = kept.length > 0;
    // Drawn anew only when it changed, else a name would lose the focus at each state.
    const now = JSON.stringify([kept, reference]);
    if (now === drawn) return undefined;
    drawn = now;
    const focused = document.activeElement?.dataset.testid;
    $("kept-runs").replaceChildren(...kept.map((one) => row(one, { reference, choose, rename, forget: (each) => ask(() => forgetRun(each.id)) })));
    if (focused) $("kept-runs").querySelector(`[data-testid="${CSS.escape(focused)}"]`)?.focus();
    return undefined;
  }

  $("keep").addEventListener("click", keep);
  $("keep-name").addEventListener("keydown", (event) => event.key === "Enter" && keep());
  onKey("k", keep, { words: "Keep this glide to compare with", group: "Design" });
  store.watch(["state", "reference"], show);
}
