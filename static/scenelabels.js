// Which labels in the water can be read where they are: from some views they would lie over each other.

const NODES = /^\/world\/(rungs|grid|room)\/label\d+$/;
const APART = { x: 64, y: 22 }; // px between the places of two labels
const MOST = 12;

// The names to show of labels { name, x, y, depth, shown }: those that stay first, or they would come and go, then the
// nearer ones, as many as there is room for.
export function labelsApart(labels) {
  const kept = [];
  for (const label of [...labels].sort((a, b) => b.shown - a.shown || a.depth - b.depth)) {
    if (kept.length === MOST) break;
    if (kept.every(({ x, y }) => Math.abs(x - label.x) >= APART.x || Math.abs(y - label.y) >= APART.y)) kept.push(label);
  }
  return new Set(kept.map(({ name }) => name));
}

// Where the client's camera sees the labels, px; without those that it does not see, or that the fog hides.
export function labelsSeen({ camera, canvas, nodeRefFromName, nodePoseData, scene }, tree) {
  const world = nodeRefFromName?.["/world"];
  if (!world || !camera || !canvas) return null;
  const [width, height, sight] = [canvas.clientWidth, canvas.clientHeight, scene?.fog?.far ?? Infinity];
  const seen = [];
  for (const [name, node] of Object.entries(tree)) {
    const position = NODES.test(name) && nodePoseData[name]?.position;
    if (!position) continue;
    const place = world.localToWorld(camera.position.clone().set(...position));
    const depth = place.distanceTo(camera.position);
    const { x, y, z } = place.project(camera);
    if (depth > sight || Math.abs(x) > 1 || Math.abs(y) > 1 || Math.abs(z) > 1) continue;
    seen.push({ name, x: ((1 + x) / 2) * width, y: ((1 - y) / 2) * height, depth, shown: node.visibility ?? true });
  }
  return seen;
}

// Whether a label is to be shown, by name; null for all else, and where the camera is not known.
export function labelChoice(mutable, tree) {
  const seen = labelsSeen(mutable, tree);
  const chosen = seen && labelsApart(seen);
  return (name) => (chosen && NODES.test(name) ? chosen.has(name) : null);
}
