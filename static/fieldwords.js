// How the document's fields are called on the page, where their names in the document do not say it well.

const WORDS = {
  center_of_mass: "Centre of mass",
  extension_range: "Stroke",
  angle_range: "Angles",
  neutral_extension: "Neutral",
  neutral_angle: "Neutral",
  volume_range: "Volumes",
  as_printed: "As the paper prints",
  bulk_modulus: "Bulk modulus",
  hotel_power: "Hotel load",
  color: "Colour",
  bed_depth: "Bed depth",
  bed_contact: "Bed contact",
  output_interval: "Output interval",
  sample_time: "Sample time",
  reference_density: "Density of data",
  reference_point: "Moments about",
  includes_munk_moment: "Holds Munk moment",
  alpha_limit_deg: "Attack up to",
  beta_limit_deg: "Sideslip up to",
  unwind_time: "Unwind time",
  angular_velocity: "Turning",
  surface_velocity: "At the surface",
  salinity_kind: "Salinity kind",
  rate_scaling: "Rates times",
  scaling: "Rates times",
  tip_chord: "Tip chord",
  xx: "Roll xx", yy: "Pitch yy", zz: "Yaw zz", xy: "Product xy", xz: "Product xz", yz: "Product yz",
  heave_pitch: "Heave by pitch", pitch_pitch: "Pitch by pitch", sway_roll: "Sway by roll", sway_yaw: "Sway by yaw",
  roll_roll: "Roll by roll", roll_yaw: "Roll by yaw", yaw_roll: "Yaw by roll", yaw_yaw: "Yaw by yaw",
  seed: "Seed",
};

// Where one name means different things, by what it belongs to.
const PLACED = {
  "piston.volume": "Neutral volume",
  "damping.pitch": "Pitch C33",
  "initial.position": "Start",
  "solver.model": "Model",
};

const VALUES = {
  end: "ends the run", float: "it floats there", slide: "it slides on it", adaptive: "adaptive 5(4)", rk4: "Runge-Kutta 4",
  pchip: "PCHIP", composite: "composed", uniform: "uniform", density_profile: "density by depth", teos10: "by temperature",
  sheared: "linear in depth", tabulated: "table", heave: "one heave", depth_band: "yo-yo", roll: "one bank", heading: "one heading",
  speed_squared: "V²", speed: "V", practical: "practical", state_feedback: "state feedback",
};

const AXES = ["x", "y", "z"];

const sentence = (name) => name.charAt(0).toUpperCase() + name.slice(1).replaceAll("_", " ");

export const labelOf = (name, of = "") => PLACED[`${of}.${name}`] ?? WORDS[name] ?? sentence(name);
export const wordOf = (value) => (typeof value === "string" ? (VALUES[value] ?? value.replaceAll("_", " ")) : String(value));

// The entries of a vector by their axes, those of a range by its ends, those of a place by the compass.
export function entryWords(name, count, of) {
  if (count === 3) return AXES;
  if (name.endsWith("_range")) return ["from", "to"];
  if (count === 2 && /velocity|shear|center|point/.test(name)) return ["north", "east"];
  return Array.from({ length: count }, (_, k) => String(k + 1));
}

const VECTOR = /position|center_of_mass|pivot|axis|offset|direction$/;

// What a pointer leads to, as the page calls it, without its first `skip` names: "position y", "mass", "Front at start".
export function fieldWords(pointer, skip = 0) {
  const names = pointer.split("/").slice(1 + skip).map((name) => name.replaceAll("~1", "/").replaceAll("~0", "~"));
  const last = names.findLastIndex((name) => !/^\d+$/.test(name));
  if (last < 0) return "";
  const [of, name] = [names[last - 1] ?? "", names[last]];
  if (of === "extensions") return `${name} at start`;
  if (of === "effort") return `${name}: effort`;
  const label = labelOf(name, of);
  const words = /^[A-Z][a-z]/.test(label) ? label.charAt(0).toLowerCase() + label.slice(1) : label;
  const entry = names[last + 1];
  if (entry === undefined) return words;
  const axis = name.endsWith("_range") ? entryWords(name, 2, of)[entry] : VECTOR.test(name) ? AXES[entry] : null;
  return axis ? `${words} ${axis}` : `${words}, entry ${Number(entry) + 1}`;
}
