// Which fields stand in which section of the left panel, and in which order: the selected part first, then the rest of the
// document. Fields that nobody placed here follow under "More", so that none is ever missing.

import { columnsSpec, definition, fieldSpec, fieldsOf, group, note, readout } from "./fieldspecs.js";
import { join } from "./fieldschema.js";
import { wordOf } from "./fieldwords.js";

const DEFINITIONS = { rigid: "Rigid", bellows: "Bellows", piston: "Piston", bladder: "Bladder", movable_mass: "MovableMass", rolling_mass: "RollingMass" };

// What people look for first, in their order; * stands for a row that is no field of the schema.
const FIRST = [
  "mass", "*extension", "*volumes", "volume", "volume_range", "area", "pleats", "inner_radius", "outer_radius", "fixed_volume", "*table",
  "extension_range", "neutral_extension", "angle_range", "neutral_angle", "pivot", "rate_limit", "lag", "*axis",
];
const GROUPS = [
  ["Mass distribution", ["center_of_mass", "inertia"]],
  ["Volume in detail", ["pleat_volume", "gap_volume", "as_printed", "bulk_modulus", "height"]],
  ["Energy", ["efficiency", "recovery"]],
  ["Looks and notes", ["color", "shapes", "notes"]],
];

const AXES = [["forward", [1, 0, 0]], ["aft", [-1, 0, 0]], ["down", [0, 0, 1]], ["up", [0, 0, -1]], ["starboard", [0, 1, 0]], ["port", [0, -1, 0]]];

const replace = (pointer, value) => [{ op: "replace", path: pointer, value }];
const inSpace = (ctx) => ctx.design.mission.solver.model === "spatial";
const millimetre = (value) => Math.round(value * 1e3) / 1e3;

function positions(ctx, holder, schema) {
  const long = millimetre(0.6 * ctx.facts.length);
  const outermost = Math.max(...ctx.design.vehicle.components.flatMap(({ position: [, y, z] }) => [Math.abs(y), Math.abs(z)]));
  const wide = Math.max(millimetre(0.1 * ctx.facts.length), millimetre(1.5 * outermost), 0.02);
  const place = ctx.design.vehicle.components[ctx.index].position;
  const axes = [["x", "forward", long], ["y", "to starboard", wide], ["z", "down", wide]];
  const whole = fieldSpec(ctx, holder, schema, "position");
  return axes.filter(([axis], k) => axis !== "y" || inSpace(ctx) || place[k] !== 0).map(([axis, words, reach]) => {
    const k = "xyz".indexOf(axis);
    const pointer = join(whole.pointer, k);
    return { ...whole, row: "number", key: pointer, pointer, value: place[k], label: `Position ${axis}`, about: `${whole.about} Here ${axis}: ${words}.`, slider: [-reach, reach], write: (value) => replace(pointer, value) };
  });
}

function extensionAtStart(ctx, part) {
  const turns = part.kind === "rolling_mass";
  const pointer = join("/mission/initial/extensions", part.name);
  return {
    row: "number", key: pointer, pointer, label: turns ? "Angle at start" : "Extension at start", value: ctx.facts.start[part.name], unit: turns ? "rad" : "m", quantity: turns ? "angle" : "length",
    symbol: "e", about: "Extension at time zero, before any command.", slider: ctx.facts.stroke[part.name], low: null, high: null, write: (value) => [{ op: "add", path: pointer, value }],
  };
}

const SAME = 1e-3; // of a stroke: nearer, two extensions read the same

// Said where it differs, as the lane begins at it.
function commandAtStart(ctx, part) {
  const first = ctx.design.mission.control.schedules.find(({ cell }) => cell === part.name)?.points[0];
  const [low, high] = ctx.facts.stroke[part.name] ?? [0, 0];
  return first?.time === 0 && Math.abs(first.extension - ctx.facts.start[part.name]) > SAME * (high - low) ? [readout("Commanded at 0 s", first.extension, part.kind === "rolling_mass" ? "rad" : "m")] : [];
}

function axisSpec(ctx, holder, schema, part) {
  const verb = { rolling_mass: "Turns about", movable_mass: "Slides" }[part.kind] ?? "Grows";
  const spec = fieldSpec(ctx, holder, schema, "axis");
  const same = ([, axis]) => axis.every((v, k) => v === part.axis[k]);
  const known = AXES.find(same);
  const choices = [...AXES.map(([label]) => [label, label]), ["oblique", "another way"]];
  const write = (label) => (label === "oblique" ? [] : replace(spec.pointer, AXES.find(([word]) => word === label)[1]));
  const choice = { ...spec, row: "choice", key: `${spec.pointer} choice`, label: verb, choices: known ? choices.slice(0, -1) : choices, value: known?.[0] ?? "oblique", write };
  return known ? [choice, group("Direction", spec.pointer, [spec])] : [choice, spec];
}

function special(ctx, name, { holder, schema, part }) {
  const volumes = ctx.facts.volumes[part.name];
  switch (name) {
    case "*extension": return part.kind === "rigid" ? [] : [extensionAtStart(ctx, part), ...commandAtStart(ctx, part)];
    case "*volumes": return volumes ? [readout("Volume at start", volumes.start, "m3"), ...(part.kind === "piston" ? [] : [readout("Neutral volume", volumes.neutral, "m3")])] : [];
    case "*table": return part.kind === "bladder" ? [columnsSpec(ctx, holder, schema, ["extensions", "volumes"], { label: "Table" })] : [];
    default: return part.kind === "rigid" ? [] : axisSpec(ctx, holder, schema, part);
  }
}

export function partItems(ctx) {
  const part = ctx.design.vehicle.components[ctx.index];
  const holder = join("/vehicle/components", ctx.index);
  const schema = definition(ctx, DEFINITIONS[part.kind]);
  const place = { holder, schema, part };
  const one = (name) => {
    if (name.startsWith("*")) return special(ctx, name, place);
    if (!(name in schema.properties)) return [];
    return [fieldSpec(ctx, holder, schema, name, name === "center_of_mass" ? { firstValue: part.position } : undefined)];
  };
  const groups = GROUPS.map(([label, names]) => [label, names.flatMap(one)]).filter(([, items]) => items.length).map(([label, items]) => group(label, `part ${label}`, items));
  const placed = new Set([...FIRST, ...GROUPS.flatMap(([, names]) => names), "kind", "name", "position", "axis", "extensions", "volumes"]);
  const rest = Object.keys(schema.properties).filter((name) => !placed.has(name));
  const schedule = part.kind === "rigid" ? [] : [scheduleGroup(ctx, part)];
  return [...positions(ctx, holder, schema), ...FIRST.flatMap(one), ...schedule, ...groups, ...(rest.length ? [group("More", "part more", rest.flatMap(one))] : [])];
}

function scheduleGroup(ctx, part) {
  const { schedules } = ctx.design.mission.control;
  const index = schedules.findIndex(({ cell }) => cell === part.name);
  const holder = "/mission/control/schedules";
  if (index < 0) {
    const value = { cell: part.name, points: [{ time: 0, extension: ctx.facts.start[part.name] }] };
    const start = { row: "buttons", key: "schedule start", buttons: [["Add a schedule", () => [{ op: "add", path: `${holder}/-`, value }]]] };
    return group("Schedule", "part schedule", [note("It holds its extension at start."), start]);
  }
  const pointer = join(holder, index);
  const unit = part.kind === "rolling_mass" ? "rad" : "m";
  const writeRows = (rows) => (rows.length ? replace(`${pointer}/points`, rows) : [{ op: "remove", path: pointer }]);
  const points = fieldSpec(ctx, pointer, definition(ctx, "Schedule"), "points", { units: { extension: unit }, writeRows });
  return group("Schedule", "part schedule", [points]);
}

function hydrodynamics(ctx) {
  const source = ctx.design.vehicle.hydrodynamics;
  const pointer = "/vehicle/hydrodynamics";
  const [title, ...sentences] = ctx.facts.forces;
  const show = { row: "buttons", key: "show forces", buttons: [["Show the force data", "forces"]] };
  const about = [{ row: "note", key: "forces title", text: title, strong: true }, ...sentences.map(note), show];
  const schema = definition(ctx, { polar_table: "PolarTable", angle_table: "AngleTable", coefficients: "CoefficientForm" }[source.kind]);
  const skip = ["row_speed", "row_alpha_deg", "row_lift", "row_drag", "row_moment", "alpha_deg", "beta_deg", "surge", "sway", "heave", "roll", "pitch", "yaw"];
  const speeds = ctx.facts.speeds;
  const options = source.kind === "polar_table" ? { speed: { row: "choice", label: "Data speed", choices: [[null, "average"], ...speeds.map((v) => [v, `${v} m/s`])] } } : {};
  const other = note("Other data come in by ‘glider-studio attach’, or by opening a design file.");
  return group("Hydrodynamics", pointer, [...about, ...fieldsOf(ctx, pointer, schema, { skip, options }), other], { open: true });
}

function vehicle(ctx) {
  const schema = definition(ctx, "Vehicle");
  const linear = definition(ctx, "Damping");
  const damping = fieldsOf(ctx, "/vehicle/damping", linear);
  const counts = inSpace(ctx) ? damping : damping.filter(({ pointer = "" }) => /(surge|heave|pitch)$/.test(pointer));
  return [hydrodynamics(ctx), fieldSpec(ctx, "/vehicle", schema, "added_mass", { label: "Added mass" }), group("Damping", "/vehicle/damping", counts), fieldSpec(ctx, "/vehicle", schema, "hotel_power")];
}

const INERTIAS = ["Roll inertia", "Pitch inertia", "Yaw inertia"];

function mass(ctx) {
  const { kind } = ctx.design.vehicle.mass_properties;
  const pointer = "/vehicle/mass_properties";
  const choice = {
    row: "choice", key: `${pointer} kind`, pointer, label: "Properties", value: kind, choices: [["composite", "composed"], ["declared", "declared"]],
    about: "Whether mass, centre of mass and inertia are composed from the components or stated.", call: (value) => ["mass-properties", { kind: value }],
  };
  if (kind === "declared") return [choice, ...fieldsOf(ctx, pointer, definition(ctx, "DeclaredMass"))];
  const { mass: total, center_of_mass: center, inertia } = ctx.facts.mass;
  return [choice, readout("Total mass", total, "kg"), ...center.map((value, k) => readout(`Centre of mass ${"xyz"[k]}`, value, "m")), ...inertia.map((value, k) => readout(INERTIAS[k], value, "kg m2"))];
}

const COLUMNS = { density_profile: ["depths", "densities"], teos10: ["depths", "temperatures"] };

function waterFields(ctx, holder, schema) {
  const water = ctx.design.mission.environment.water;
  const names = COLUMNS[water.kind];
  if (!names) return fieldsOf(ctx, holder, schema);
  const columns = water.salinities ? [...names, "salinities"] : names;
  const words = ctx.facts.water ? [note(ctx.facts.water)] : [];
  return [...words, columnsSpec(ctx, holder, schema, columns, { label: "Levels", step: [10, 0, 0] }), ...fieldsOf(ctx, holder, schema, { skip: ["depths", "densities", "temperatures", "salinities"] })];
}

function water(ctx) {
  const schema = definition(ctx, "Environment");
  const pointer = "/mission/environment";
  const kept = ctx.design.mission.environment.current?.kind;
  const one = (name, options) => fieldSpec(ctx, pointer, schema, name, options);
  const spatial = inSpace(ctx) ? [one("surface"), one("bed_contact"), one("current", { label: "Current", without: kept === "tabulated" ? [] : ["tabulated"] })] : [];
  return [
    one("water", { fields: waterFields, label: "Water" }),
    one("gravity", { placeholder: String(ctx.facts.gravity) }), one("bed_depth", { placeholder: "no bed" }), ...spatial,
    note("Long profiles and tables of currents come in by ‘glider-studio attach’, or by opening a design file."),
  ];
}

const FLAT = /\/(pitch|position|velocity)$/;

function start(ctx) {
  const fields = fieldsOf(ctx, "/mission/initial", definition(ctx, "Initial"), { skip: ["extensions"] });
  const turned = fields.map((spec) => (/\/(roll|pitch|yaw)$/.test(spec.pointer) ? { ...spec, slider: /pitch$/.test(spec.pointer) ? [-Math.PI / 2, Math.PI / 2] : [-Math.PI, Math.PI] } : spec));
  const counts = inSpace(ctx) ? turned : turned.filter(({ pointer }) => FLAT.test(pointer));
  const cells = ctx.design.vehicle.components.filter(({ kind }) => kind !== "rigid").map((part) => ({ ...extensionAtStart(ctx, part), label: part.name, slider: null }));
  return [...counts, ...(cells.length ? [group("Extensions", "/mission/initial/extensions", cells)] : [])];
}

function mission(ctx) {
  const solver = definition(ctx, "Solver");
  const { method } = ctx.design.mission.solver;
  const skip = method === "adaptive" ? ["step"] : ["tolerance"];
  return [fieldSpec(ctx, "/mission", definition(ctx, "Mission"), "duration"), ...fieldsOf(ctx, "/mission/solver", solver, { skip, options: { tolerance: { unit: "1", scale: "log" } } })];
}

function controlledCells(ctx, holder, schema) {
  const { allocation } = ctx.design.mission.control.controller;
  const moving = ctx.design.vehicle.components.filter(({ kind }) => kind !== "rigid").map(({ name }) => name);
  const pointer = join(holder, "effort");
  const efforts = moving.map((name) => ({
    row: "number", key: join(pointer, name), pointer: join(pointer, name), label: name, value: allocation.effort[name] ?? null, unit: "1", quantity: null, nullable: true,
    placeholder: "1", symbol: "r_i", about: "How unwillingly this cell leaves neutral beside the others.", low: 0, high: 1e6, aboveLow: true,
    write: (value) => (value === null ? [{ op: "remove", path: join(pointer, name) }] : [{ op: "add", path: join(pointer, name), value }]),
  }));
  return [
    { row: "names", key: `${holder}/cells`, pointer: `${holder}/cells`, label: "Cells", value: allocation.cells, all: moving, about: "Cells under control; none chosen means all that move.", write: (names) => replace(`${holder}/cells`, names) },
    ...fieldsOf(ctx, holder, schema, { skip: ["cells", "effort"] }), group("Effort", pointer, efforts),
  ];
}

function cascadeFields(ctx, holder, schema) {
  if (ctx.design.mission.control.controller.kind !== "cascade") return fieldsOf(ctx, holder, schema);
  const fields = fieldsOf(ctx, holder, schema, { skip: ["allocation"] });
  const wrapped = fields.map((spec) => (spec.row === "items" ? group(spec.items[0].label, spec.key, spec.items, { open: true }) : spec));
  return [...wrapped, group("Allocation", `${holder}/allocation`, controlledCells(ctx, `${holder}/allocation`, definition(ctx, "AllocationRule")))];
}

function control(ctx) {
  const { controller } = ctx.design.mission.control;
  const without = controller?.kind === "state_feedback" ? [] : ["state_feedback"];
  const chosen = fieldSpec(ctx, "/mission/control", definition(ctx, "Control"), "controller", { label: "Controller", without, fields: cascadeFields });
  const told = controller ? [] : [note("Cells follow their schedules. State feedback comes from ‘glider-studio control’, or by opening a design file.")];
  return [chosen, ...told];
}

const design = (ctx) => [
  { row: "text", key: "/name", pointer: "/name", label: "Name", value: ctx.design.name, about: "Name of the design.", longest: 200, write: (value) => replace("/name", value) },
  { row: "area", key: "/notes", pointer: "/notes", label: "Notes", value: ctx.design.notes, about: "What it is, where its numbers come from, and what it is not.", longest: 20_000, write: (value) => replace("/notes", value) },
];

export const SECTIONS = [
  { id: "vehicle", label: "Vehicle", items: vehicle, holds: /^\/vehicle\/(hydrodynamics|added_mass|damping|hotel_power)/, briefOf: ({ facts }) => facts.forces[0] },
  { id: "mass", label: "Mass", items: mass, holds: /^\/vehicle\/mass_properties/, briefOf: ({ design: { vehicle: { mass_properties: { kind } } } }) => wordOf(kind) },
  { id: "water", label: "Water", items: water, holds: /^\/mission\/environment/, briefOf: ({ design: { mission: { environment } } }) => wordOf(environment.water.kind) },
  { id: "start", label: "Start", items: start, holds: /^\/mission\/initial/, briefOf: ({ design: { mission: { initial } } }) => `depth ${initial.position[2]} m` },
  { id: "mission", label: "Mission and solver", items: mission, holds: /^\/mission\/(duration|solver)/, briefOf: ({ design: { mission: { solver } } }) => solver.model },
  { id: "control", label: "Control", items: control, holds: /^\/mission\/control/, briefOf: ({ design: { mission: { control: { controller } } } }) => (controller ? wordOf(controller.kind) : "schedules") },
  { id: "design", label: "Design", items: design, holds: /^\/(name|notes)/, briefOf: () => "" },
];
