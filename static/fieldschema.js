// Reads the JSON Schema of the design: what a field is, its limits, and a first value for what is not there yet.

export const token = (text) => String(text).replaceAll("~", "~0").replaceAll("/", "~1");
export const join = (pointer, ...names) => names.reduce((path, name) => `${path}/${token(name)}`, pointer);
const tokens = (pointer) => pointer.split("/").slice(1).map((text) => text.replaceAll("~1", "/").replaceAll("~0", "~"));

export const valueAt = (document, pointer) => tokens(pointer).reduce((node, name) => node?.[name], document);

const definitionName = (schema) => schema.$ref?.split("/").at(-1) ?? null;

// One schema to go by: references followed, the null of an optional field told apart, of several kinds that of the value.
export function resolve(root, schema, value) {
  let node = schema;
  let nullable = false;
  let name = null;
  const about = {};
  for (let k = 0; k < 8; k += 1) {
    for (const key of ["description", "unit", "symbol", "default"]) if (key in node && !(key in about)) about[key] = node[key];
    if (node.$ref) {
      name = definitionName(node);
      node = root.$defs[name];
      continue;
    }
    const choices = node.oneOf ?? node.anyOf;
    if (!choices) break;
    const given = choices.filter((choice) => choice.type !== "null");
    nullable ||= given.length < choices.length;
    if (given.length > 1) return { ...about, kinds: kindsOf(root, given), nullable, name, schema: null };
    [node] = given;
  }
  return { ...about, nullable, name, kinds: null, schema: node };
}

function kindsOf(root, choices) {
  return choices.map((choice) => {
    const name = definitionName(choice);
    const schema = root.$defs[name];
    return { kind: schema?.properties?.kind?.const, name, schema };
  });
}

export const kindOf = (resolved, value) => resolved.kinds?.find(({ kind }) => kind === value?.kind) ?? null;

// Where a minimal value would be refused or say nothing, a useful one; by the name of the definition.
const FIRST = {
  DepthBand: { kind: "depth_band", top: 1, bottom: 5, dive_heave: -0.05, climb_heave: 0.05 },
  Station: { kind: "station", center: [0, 0], radius: 50 },
  Waypoints: { kind: "waypoints", points: [[50, 0]] },
  DensityProfile: { kind: "density_profile", depths: [0, 10], densities: [999, 1000] },
  Teos10Water: { kind: "teos10", depths: [0, 10], temperatures: [18, 8], latitude: 45 },
  HullShape: { kind: "hull", length: 0.6, radius: 0.04, nose_length: 0.08, tail_length: 0.12 },
  CylinderShape: { kind: "cylinder", length: 0.05, radius: 0.01 },
  WingShape: { kind: "wing", span: 0.4, chord: 0.06 },
  FinShape: { kind: "fin", span: 0.06, chord: 0.05 },
  BellowsShape: { kind: "bellows", length: 0.05, inner_radius: 0.016, outer_radius: 0.024, pleats: 8 },
  LateralCoefficients: { source: "Stated by hand." },
};

export function first(root, schema) {
  const { schema: node, kinds, name, default: given } = resolve(root, schema);
  if (given !== undefined && given !== null) return given;
  if (name in FIRST) return FIRST[name];
  if (kinds) return firstOf(root, kinds[0]);
  if ("const" in node) return node.const;
  if (node.enum) return node.enum[0];
  switch (node.type) {
    case "object": return firstOf(root, { name, schema: node });
    case "array": return node.prefixItems ? node.prefixItems.map((item) => first(root, item)) : Array.from({ length: node.minItems ?? 0 }, () => first(root, node.items));
    case "boolean": return false;
    case "string": return "";
    default: return "exclusiveMinimum" in node ? node.exclusiveMinimum + 1 : Math.min(Math.max(0, node.minimum ?? 0), node.maximum ?? 0);
  }
}

// Only what has no default: the server fills in the rest.
export function firstOf(root, { name, schema }) {
  if (name in FIRST) return FIRST[name];
  const needed = new Set([...(schema.required ?? []), ...("kind" in schema.properties ? ["kind"] : [])]);
  return Object.fromEntries(Object.entries(schema.properties).filter(([field]) => needed.has(field)).map(([field, part]) => [field, first(root, part)]));
}

// Of the old value what the new kind knows too, so that changing a kind keeps what both have.
export function changedKind(root, kind, before) {
  const made = firstOf(root, kind);
  if (kind.kind) made.kind = kind.kind;
  for (const [field, value] of Object.entries(before ?? {})) if (field in kind.schema.properties && field !== "kind" && value !== null) made[field] = value;
  return made;
}

export const limitsOf = (node) => ({
  low: node.minimum ?? node.exclusiveMinimum ?? null,
  high: node.maximum ?? node.exclusiveMaximum ?? null,
  aboveLow: "exclusiveMinimum" in node,
});
