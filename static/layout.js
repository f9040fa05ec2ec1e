// How large the page's columns and the timeline are: borders to drag, or to move by keys; remembered.
// On a narrow screen the panels take turns instead.

import { $ } from "./dom.js";
import { describeKey } from "./keys.js";

const KEY = "glider-studio.layout";
const STEP = 16; // px a key press
const SCENE = { width: 320, height: 180 }; // px that always stay for the scene

// Variable, sense of a drag to the right or down, smallest size, and largest share of the window.
const BORDERS = {
  "split-left": { name: "--left", axis: "x", sense: 1, least: 220, most: 0.4, of: "parts" },
  "split-right": { name: "--right", axis: "x", sense: -1, least: 240, most: 0.4, of: "results" },
  "split-bottom": { name: "--bottom", axis: "y", sense: -1, least: 96, most: 0.65, of: "timeline" },
};

function read() {
  try {
    return JSON.parse(localStorage.getItem(KEY) ?? "{}") ?? {};
  } catch {
    return {};
  }
}

function keep(sizes) {
  try {
    localStorage.setItem(KEY, JSON.stringify(sizes));
  } catch {
    // Not remembered where the browser keeps nothing.
  }
}

const sizeOf = ({ axis, of }) => $(of).getBoundingClientRect()[axis === "x" ? "width" : "height"];

function bounds({ axis, least, most, of }) {
  const whole = axis === "x" ? innerWidth : innerHeight;
  const others = axis === "x" ? sizeOf(BORDERS[of === "parts" ? "split-right" : "split-left"]) + SCENE.width : SCENE.height + 44;
  return [least, Math.max(least, Math.min(whole * most, whole - others))];
}

export function connectLayout() {
  const sizes = read();
  const root = document.documentElement;

  function set(border, size) {
    const { name } = border;
    if (size === null) {
      delete sizes[name];
      root.style.removeProperty(name);
    } else {
      const [low, high] = bounds(border);
      sizes[name] = Math.round(Math.min(Math.max(size, low), high));
      root.style.setProperty(name, `${sizes[name]}px`);
    }
    keep(sizes);
    say();
  }

  function say() {
    for (const [id, border] of Object.entries(BORDERS)) {
      const [low, high] = bounds(border);
      for (const [part, value] of [["now", sizeOf(border)], ["min", low], ["max", high]]) $(id).setAttribute(`aria-value${part}`, String(Math.round(value)));
    }
  }

  for (const [id, border] of Object.entries(BORDERS)) {
    const { axis, sense } = border;
    if (Number.isFinite(sizes[border.name])) set(border, sizes[border.name]);
    $(id).addEventListener("pointerdown", (event) => {
      if (event.button !== 0) return;
      const [start, size] = [axis === "x" ? event.clientX : event.clientY, sizeOf(border)];
      $(id).setPointerCapture(event.pointerId);
      document.body.classList.add("resizing"); // the 3D view is another document and would swallow the moves
      $(id).onpointermove = (move) => set(border, size + sense * ((axis === "x" ? move.clientX : move.clientY) - start));
    });
    // As the column grows, a part's row comes to lie under where the press began, and the browser would drag that.
    $(id).addEventListener("mousedown", (event) => {
      event.preventDefault();
      $(id).focus({ preventScroll: true });
    });
    $(id).addEventListener("lostpointercapture", () => {
      $(id).onpointermove = null;
      document.body.classList.remove("resizing");
    });
    $(id).addEventListener("dblclick", () => set(border, null));
    $(id).addEventListener("keydown", (event) => {
      const way = { ArrowLeft: ["x", -1], ArrowRight: ["x", 1], ArrowUp: ["y", -1], ArrowDown: ["y", 1] }[event.key];
      if (event.key === "Home") set(border, null);
      else if (way?.[0] === axis) set(border, sizeOf(border) + sense * way[1] * STEP);
      else return;
      event.preventDefault();
    });
  }
  describeKey(["ArrowLeft", "ArrowRight", "ArrowUp", "ArrowDown", "drag"], "On a border between panels: move it", "View");
  describeKey(["Home", "double click"], "On a border between panels: back to where it was at first", "View");
  describeKey(["ArrowLeft", "ArrowRight"], "On a narrow screen, on the tabs: another panel", "View");
  addEventListener("resize", say);
  say();
  connectTabs();
}

function connectTabs() {
  const tabs = [...document.querySelectorAll("#tabs [data-tab]")];
  const choose = (tab) => {
    document.body.dataset.tab = tab.dataset.tab;
    for (const each of tabs) {
      each.setAttribute("aria-selected", String(each === tab));
      each.tabIndex = each === tab ? 0 : -1;
    }
    dispatchEvent(new Event("resize")); // what was hidden could not measure itself
  };
  tabs.forEach((tab, k) => {
    tab.addEventListener("click", () => choose(tab));
    tab.addEventListener("keydown", (event) => {
      const way = { ArrowLeft: -1, ArrowRight: 1 }[event.key];
      if (!way) return;
      event.preventDefault();
      const next = tabs[(k + way + tabs.length) % tabs.length];
      choose(next);
      next.focus();
    });
  });
  choose(tabs[0]);
}
