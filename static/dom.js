// Small helpers to build DOM without innerHTML: names and messages come from people's files.

const SVG = "http://www.w3.org/2000/svg";

export const $ = (id) => document.getElementById(id);

function fill(node, attributes, children) {
  for (const [name, value] of Object.entries(attributes ?? {})) {
    if (name === "onclick") node.addEventListener("click", value);
    else if (value === true) node.setAttribute(name, "");
    else if (value !== false && value != null) node.setAttribute(name, value);
  }
  node.append(...children.filter((child) => child != null));
  return node;
}

export function el(tag, attributes, ...children) {
  return fill(document.createElement(tag), attributes, children);
}

export function svg(tag, attributes, ...children) {
  return fill(document.createElementNS(SVG, tag), attributes, children);
}

// Writing equal text would still cost layout at 60 frames a second.
export function setText(node, text) {
  if (node.textContent !== text) node.textContent = text;
}

export function swatch(color) {
  const node = el("i", { class: "swatch", "aria-hidden": "true" });
  node.style.background = color;
  return node;
}

const FLASH = 1600; // ms
const flashing = new WeakMap();

// Draws the eye to where something led.
export function flash(node) {
  clearTimeout(flashing.get(node));
  node.classList.remove("flash");
  requestAnimationFrame(() => node.classList.add("flash"));
  flashing.set(node, setTimeout(() => node.classList.remove("flash"), FLASH));
}
