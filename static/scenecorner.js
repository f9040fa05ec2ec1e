// The corner of the scene that tells how it is seen: a compass that turns with the camera, and a bar of known length.

import { $, setText } from "./dom.js";
import { scaleOf, withUnit } from "./units.js";

const EVERY = 120; // ms between looks at the camera
const LONGEST = 132; // px of the bar

const column = ({ elements: m }, k) => [m[4 * k], m[4 * k + 1], m[4 * k + 2]];
const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];

// The camera's heading in the water, rad from north to the right. What is level of its line of sight tells it, and
// straight down or up what is level of its picture's upward side.
export function headingOf(camera, world) {
  const [north, east, down] = [0, 1, 2].map((k) => column(world, k));
  const [up, back] = [column(camera, 1), column(camera, 2)];
  const sight = back.map((c, k) => -c + (dot(back, down) < 0 ? 1 : -1) * up[k]);
  return Math.atan2(dot(sight, east), dot(sight, north));
}

// The largest of 1, 2, 5 times a power of ten that is no longer than this.
export function niceLength(longest) {
  const power = 10 ** Math.floor(Math.log10(longest));
  return [5, 2, 1].map((m) => m * power).find((length) => length <= longest * (1 + 1e-9));
}

function distanceOf({ camera, cameraControl }) {
  const target = cameraControl?.getTarget?.(camera.position.clone());
  return target ? camera.position.distanceTo(target) : camera.position.length();
}

export function connectCorner({ viewer }) {
  let before = "";

  function look() {
    const hook = viewer.hook();
    const world = hook?.nodeRefFromName?.["/world"]?.matrixWorld;
    const { camera, canvas } = hook ?? {};
    $("scene-corner").dataset.known = String(Boolean(world && camera && canvas));
    if (!world || !camera || !canvas) return;
    const heading = (headingOf(camera.matrixWorld, world) * 180) / Math.PI;
    const height = 2 * Math.tan((camera.fov * Math.PI) / 360) * distanceOf(hook);
    const perMetre = canvas.clientHeight / height;
    const length = niceLength(LONGEST / perMetre);
    const now = `${heading.toFixed(0)} ${perMetre.toPrecision(3)}`;
    if (now === before || !Number.isFinite(length)) return;
    before = now;
    const degrees = (Math.round(heading) + 360) % 360;
    $("compass-card").setAttribute("transform", `rotate(${(-heading).toFixed(1)})`);
    $("compass").setAttribute("aria-label", `Looking ${degrees}° from north`);
    $("scale-bar").style.width = `${(length * perMetre).toFixed(1)}px`;
    const { per, symbol } = scaleOf("m", length, length);
    setText($("scale-length"), withUnit(String(Number((length * per).toPrecision(2))), symbol));
  }

  setInterval(look, EVERY);
}
