// Makes rows from the schema: for each field of the document what kind of row shows it, its unit, limits and help.
// A spec is plain data; fieldrows.js draws it. `value` is the document's, in SI.

import { entryWords, labelOf, wordOf } from "./fieldwords.js";
import { changedKind, first, firstOf, join, kindOf, limitsOf, resolve, valueAt } from "./fieldschema.js";
import { quantityOf } from "./unitchoice.js";

export const group = (label, key, items, { open = false, note = null } = {}) => ({ row: "group", label, key, items, open, note });
export const note = (text) => ({ row: "note", key: `note ${text}`, text });
export const readout = (label, value, unit, pointer = "") => ({
  row: "readout", key: `readout ${label}`, label, value, unit, quantity: quantityOf(unit, pointer, ""), about: "Follows from the other fields.",
});

const replace = (pointer, value) => [{ op: "replace", path: pointer, value }];

// The row of the field `name` of the object at `holder`, whose schema is `schema`.
export function fieldSpec(ctx, holder, schema, name, options = {}) {
  const property = schema.properties[name];
  const pointer = join(holder, name);
  const value = valueAt(ctx.design, pointer);
  const resolved = resolve(ctx.schema, property, value);
  const of = options.of ?? valueAt(ctx.design, holder)?.kind ?? holder.split("/").at(-1);
  const spec = {
    key: pointer, pointer, value, label: options.label ?? labelOf(name, of), about: resolved.description ?? "", symbol: resolved.symbol ?? "",
    unit: options.unit ?? resolved.unit ?? null, nullable: resolved.nullable, write: options.write ?? ((given) => replace(pointer, given)), ...options,
  };
  if (value && Object.hasOwn(value, "entries")) return note(`${spec.label}: ${value.entries} entries, too many to edit here. Export the design as JSON to change them.`);
  return dressed(ctx, spec, resolved, name);
}

function dressed(ctx, spec, resolved, name) {
  const { schema: node, kinds } = resolved;
  if (kinds) return kindSpec(ctx, spec, resolved);
  if (node.enum) return { ...spec, row: "choice", choices: node.enum.map((value) => [value, wordOf(value)]) };
  switch (node.type) {
    case "number":
    case "integer": return numberSpec(spec, node, name);
    case "boolean": return { ...spec, row: "switch" };
    case "string": return textSpec(spec, node, name);
    case "array": return listSpec(ctx, spec, node, name);
    case "object": return objectSpec(ctx, spec, resolved, name);
    default: return note(`${spec.label} is edited in the JSON.`);
  }
}

function numberSpec(spec, node, name) {
  const quantity = quantityOf(spec.unit, spec.pointer, name);
  return { row: "number", quantity, integer: node.type === "integer", ...limitsOf(node), ...spec };
}

function textSpec(spec, node, name) {
  if (name === "color") return { ...spec, row: "color" };
  return { ...spec, row: /notes|source|limits/.test(name) ? "area" : "text", longest: node.maxLength ?? 4000 };
}

function listSpec(ctx, spec, node, name) {
  if (spec.nullable && spec.value === null) return optionalSpec(ctx, spec, node);
  if (node.prefixItems) return vectorSpec(spec, node, name);
  const item = resolve(ctx.schema, node.items, null);
  if (item.schema?.type === "string") return { ...spec, row: "note", text: `${spec.label}: ${(spec.value ?? []).join(", ")}` };
  if (item.kinds) return shapesSpec(ctx, spec, item);
  if (item.schema?.type === "object") return tableSpec(ctx, spec, item);
  if (item.schema?.prefixItems && !item.schema.prefixItems[0].items) return pairsSpec(spec, item.schema, name);
  return note(`${spec.label}: edited in the JSON.`);
}

// A vector that may be missing has a switch; its first value is given by who knows a good one.
function optionalSpec(ctx, spec, node) {
  const there = spec.firstValue ?? first(ctx.schema, node);
  return { ...spec, row: "switch", key: `${spec.key} is given`, value: false, label: spec.label, write: () => replace(spec.pointer, there) };
}

function vectorSpec(spec, node, name) {
  const [entry] = node.prefixItems;
  if (entry.type === "array") return { ...spec, row: "matrix" };
  const words = entryWords(name, node.prefixItems.length);
  return { ...spec, row: "vector", quantity: quantityOf(spec.unit, spec.pointer, name), words, ...limitsOf(entry) };
}

function pairsSpec(spec, schema, name) {
  const column = (k) => ({ label: entryWords(name, 2)[k], unit: spec.unit, quantity: quantityOf(spec.unit, spec.pointer, name), get: (row) => row[k], set: (row, value) => row.map((old, n) => (n === k ? value : old)) });
  const last = spec.value.at(-1);
  return { ...spec, row: "table", columns: [column(0), column(1)], rows: spec.value, least: 1, added: [last[0] + 50, last[1]], writeRows: (rows) => spec.write(rows) };
}

// A list of plain objects (points of a schedule, set points): a column a field.
function tableSpec(ctx, spec, item) {
  const fields = Object.entries(item.schema.properties);
  if (fields.some(([, part]) => resolve(ctx.schema, part, null).schema?.type === "array")) return note(`${spec.label}: ${spec.value.length} of them, edited in the JSON.`);
  const columns = fields.map(([field, part]) => {
    const { schema: node, unit, description } = resolve(ctx.schema, part, null);
    const itsUnit = spec.units?.[field] ?? unit;
    return {
      label: labelOf(field), about: description, unit: itsUnit, quantity: quantityOf(itsUnit, join(spec.pointer, field), field), choices: node.enum?.map((value) => [value, wordOf(value)]),
      get: (row) => row[field], set: (row, value) => ({ ...row, [field]: value }),
    };
  });
  const last = spec.value.at(-1);
  const added = last ? { ...last, ...("time" in last ? { time: last.time + 1 } : {}) } : firstOf(ctx.schema, item);
  return { ...spec, row: "table", columns, rows: spec.value, least: spec.least ?? 0, added, writeRows: spec.writeRows ?? ((rows) => spec.write(rows)) };
}

// Two or more columns of one length, each a list of its own in the document (the table of a bladder, a profile).
export function columnsSpec(ctx, holder, schema, names, { label, least = 2, step }) {
  const values = names.map((name) => valueAt(ctx.design, join(holder, name)));
  if (values.some((column) => !Array.isArray(column))) return note(`${label}: too long to edit here. Export the design as JSON to change it.`);
  const rows = values[0].map((_, k) => values.map((column) => column[k]));
  const columns = names.map((name, n) => {
    const { unit, description } = resolve(ctx.schema, schema.properties[name], null);
    return { label: labelOf(name), about: description, unit, quantity: quantityOf(unit, join(holder, name), name), get: (row) => row[n], set: (row, value) => row.map((old, k) => (k === n ? value : old)) };
  });
  const last = rows.at(-1);
  const before = rows.at(-2) ?? last.map((value) => value - 1);
  const whole = valueAt(ctx.design, holder);
  const pointer = join(holder, names[0]);
  // The whole object at once: the columns must not differ in length meanwhile.
  const writeRows = (list) => replace(holder, { ...whole, ...Object.fromEntries(names.map((name, n) => [name, list.map((row) => row[n])])) });
  return { row: "table", key: pointer, pointer, label, columns, rows, least, added: last.map((value, n) => value + (step?.[n] ?? value - before[n])), writeRows, about: resolve(ctx.schema, schema.properties[names[0]], null).description };
}

function shapesSpec(ctx, spec, item) {
  const items = spec.value.map((shape, k) => {
    const kind = kindOf(item, shape);
    const pointer = join(spec.pointer, k);
    const remove = { row: "buttons", key: `${pointer} remove`, buttons: [["Remove this shape", () => [{ op: "remove", path: pointer }]]] };
    return group(labelOf(shape.kind), pointer, [...fieldsOf(ctx, pointer, kind.schema), remove]);
  });
  const choices = [[null, "Add a shape…"], ...item.kinds.map(({ kind }) => [kind, labelOf(kind)])];
  const add = { row: "choice", key: `${spec.pointer} add`, pointer: join(spec.pointer, "-"), label: "New", choices, value: null, about: spec.about,
    write: (kind) => [{ op: "add", path: join(spec.pointer, "-"), value: firstOf(ctx.schema, item.kinds.find((one) => one.kind === kind)) }] };
  return group(spec.label, spec.pointer, [...items, add]);
}

const NONE = "none";

// An object of one of several kinds, or of one kind that may be missing: a choice, and the fields of what is chosen.
function kindSpec(ctx, spec, resolved) {
  const offered = resolved.kinds.filter(({ kind }) => kind === spec.value?.kind || !(spec.without ?? []).includes(kind));
  const choices = offered.map(({ kind }) => [kind, wordOf(kind)]);
  if (resolved.nullable) choices.unshift([NONE, NONE]);
  const write = (kind) => {
    if (kind === (spec.value?.kind ?? NONE)) return [];
    return replace(spec.pointer, kind === NONE ? null : changedKind(ctx.schema, resolved.kinds.find((one) => one.kind === kind), spec.value));
  };
  const choice = { ...spec, row: "choice", key: `${spec.pointer} kind`, choices, value: spec.value?.kind ?? NONE, write: spec.writeKind ?? write };
  const kind = kindOf(resolved, spec.value);
  if (!kind) return choice;
  return { row: "items", key: spec.pointer, items: [choice, ...(spec.fields ?? fieldsOf)(ctx, spec.pointer, kind.schema)] };
}

function objectSpec(ctx, spec, resolved, name) {
  if (!resolved.schema.properties) return note(`${spec.label}: by name, in the JSON.`);
  const items = spec.value ? fieldsOf(ctx, spec.pointer, resolved.schema) : [];
  if (!resolved.nullable) return group(spec.label, spec.pointer, items, { note: spec.about });
  const made = () => firstOf(ctx.schema, { name: resolved.name, schema: resolved.schema });
  const given = { ...spec, row: "switch", key: `${spec.pointer} is given`, value: Boolean(spec.value), label: "Given", write: (on) => replace(spec.pointer, on ? made() : null) };
  return group(spec.label, spec.pointer, [given, ...items], { note: spec.about });
}

// All fields of an object in the order of its schema, but for those named in `skip` (and its kind, which a choice shows).
export function fieldsOf(ctx, holder, schema, { skip = [], options = {} } = {}) {
  return Object.keys(schema.properties)
    .filter((name) => name !== "kind" && !skip.includes(name))
    .map((name) => fieldSpec(ctx, holder, schema, name, options[name]));
}

export const definition = (ctx, name) => ctx.schema.$defs[name];
