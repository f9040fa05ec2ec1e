// The plane of eigenvalues: damping to the left, oscillation up, rays of equal damping ratio; modes to point at and choose.

import { svg } from "./dom.js";
import { fixed } from "./format.js";

const [WIDTH, HEIGHT] = [272, 190];
const PAD = { left: 12, right: 34, top: 8, bottom: 26 };
const RATIOS = [0.1, 0.3, 0.6, 0.9];
const LINEAR = 0.05; // 1/s: real parts beyond this are drawn by their logarithm, as fast modes would hide the slow ones

// Signed and nearly linear about 0, logarithmic far away: modes lie between 0.01 and 10 1/s.
export const squeezed = (v, unit = LINEAR) => Math.sign(v) * Math.log1p(Math.abs(v) / unit);

function scales(modes) {
  const reals = modes.map(({ real }) => real);
  const [low, high] = [Math.min(...reals, -2 * LINEAR), Math.max(...reals, LINEAR)].map((v) => squeezed(v) * 1.08);
  const top = squeezed(Math.max(...modes.map(({ imag }) => imag), 4 * LINEAR)) * 1.3;
  const inner = [WIDTH - PAD.left - PAD.right, HEIGHT - PAD.top - PAD.bottom];
  return {
    x: (real) => PAD.left + ((squeezed(real) - low) / (high - low)) * inner[0],
    y: (imag) => PAD.top + (1 - squeezed(imag) / top) * inner[1],
    low, high, top,
  };
}

const label = (x, y, text, anchor = "middle") => svg("text", { x, y, "text-anchor": anchor }, text);
const path = (points, name) => svg("polyline", { class: name, points: points.map(([x, y]) => `${x.toFixed(1)},${y.toFixed(1)}`).join(" ") });

function grid({ x, y, low, high, top }) {
  const nodes = [];
  for (const v of [-10, -3, -1, -0.3, -0.1, 0, 0.1, 0.3, 1, 3, 10]) {
    if (squeezed(v) < low || squeezed(v) > high) continue;
    nodes.push(path([[x(v), PAD.top], [x(v), HEIGHT - PAD.bottom]], v === 0 ? "axis" : "grid"), label(x(v), HEIGHT - PAD.bottom + 11, fixed(v, v && Math.abs(v) < 1 ? 1 : 0)));
  }
  for (const v of [0, 0.1, 0.3, 1, 3, 10]) {
    if (squeezed(v) > top) continue;
    nodes.push(path([[PAD.left, y(v)], [WIDTH - PAD.right, y(v)]], v === 0 ? "axis" : "grid"), label(WIDTH - PAD.right + 4, y(v) + 3, fixed(v, v && v < 1 ? 1 : 0), "start"));
  }
  return nodes;
}

// Squeezed axes bend the rays, so they are drawn by points.
function rays({ x, y, low, top }) {
  return RATIOS.map((ratio) => {
    const points = [];
    for (let s = 0; s <= 1.001; s += 0.04) {
      const size = LINEAR * Math.expm1(s * Math.max(top, -low) * 1.2);
      const at = [-ratio * size, Math.sqrt(1 - ratio * ratio) * size];
      if (squeezed(at[0]) >= low && squeezed(at[1]) <= top) points.push([x(at[0]), y(at[1])]);
    }
    const [endX, endY] = points.at(-1);
    return svg("g", {}, path(points, "ray"), label(endX + 2, endY + 9, `ζ ${ratio}`, "start"));
  });
}

// What a mode is in one line, for the pointer and for who cannot see the plane.
export function modeInWords({ name, real, imag, period, damping_ratio: ratio, time_constant: constant }) {
  const parts = [`${name}: ${fixed(real, 4)}${imag ? ` ± ${fixed(imag, 4)} i` : ""} 1/s`];
  if (period) parts.push(`period ${fixed(period, 2)} s`, `damping ratio ${fixed(ratio, 3)}`);
  else if (constant) parts.push(`${real > 0 ? "grows by e" : "falls to 1/e"} in ${fixed(constant, 2)} s`);
  return parts.join(", ");
}

function mark(mode, k, scale, { chosen, choose, point }) {
  const node = svg("g", { class: `mode${chosen ? " chosen" : ""}${mode.real > 1e-7 ? " grows" : ""}`, role: "button", tabindex: "0", "aria-label": modeInWords(mode), "aria-pressed": String(chosen), "data-testid": `mode-mark-${k}`, transform: `translate(${scale.x(mode.real).toFixed(1)} ${scale.y(mode.imag).toFixed(1)})` },
    svg("circle", { class: "target", r: 9 }),
    // Crosses are stable, filled squares grow: told by shape before colour.
    mode.real > 1e-7 ? svg("rect", { x: -4, y: -4, width: 8, height: 8 }) : svg("path", { d: "M-4-4 4 4M4-4-4 4" }));
  node.addEventListener("click", () => choose(k));
  node.addEventListener("keydown", (event) => {
    if (event.key !== "Enter" && event.key !== " ") return;
    event.preventDefault();
    choose(k);
  });
  for (const [event, shown] of [["pointerenter", k], ["focus", k], ["pointerleave", null], ["blur", null]]) node.addEventListener(event, () => point(shown));
  return node;
}

export function drawPlane(modes, { chosen, choose, point }) {
  const scale = scales(modes);
  const unstable = svg("rect", { class: "unstable", x: scale.x(0), y: PAD.top, width: Math.max(WIDTH - PAD.right - scale.x(0), 0), height: HEIGHT - PAD.top - PAD.bottom });
  return svg("svg", { class: "plane", viewBox: `0 0 ${WIDTH} ${HEIGHT}`, role: "group", "aria-label": "Eigenvalues: growth to the right, oscillation up; both scales are linear near 0 and logarithmic beyond", "data-testid": "modes-plane" },
    unstable, ...grid(scale), ...rays(scale),
    label((PAD.left + WIDTH - PAD.right) / 2, HEIGHT - 3, "dies out ← growth (1/s, symlog) → grows"),
    svg("text", { "text-anchor": "middle", transform: `translate(${WIDTH - 4} ${(PAD.top + HEIGHT - PAD.bottom) / 2}) rotate(-90)` }, "oscillation (rad/s)"),
    ...modes.map((mode, k) => mark(mode, k, scale, { chosen: k === chosen, choose, point })));
}
