// The numbers of a scene that can be set: sliders with a number beside each, and a table of places, slopes, the kick and the start.
import { escaped } from "./stage.js";

// Step of the arrow keys in a field of the table, in its unit.
const STEP = 0.01;
// Digits that a field shows; its tooltip has all of them.
const DIGITS = 4;

export const SLIDERS = [
  { name: "friction μ, all contacts", low: 0, high: 2, step: 0.01, get: (s) => s.contact[0].friction ?? 0, set: (s, v) => s.contact.forEach((c) => { c.friction = v; }) },
  { name: "restitution e", low: 0, high: 0.95, step: 0.01, get: (s) => s.restitution, set: (s, v) => { s.restitution = v; s.contact.forEach((c) => delete c.restitution); } },
  { name: "tangential restitution e_t", low: 0, high: 0.95, step: 0.01, get: (s) => s.contact[0].tangential_restitution ?? 0, set: (s, v) => s.contact.forEach((c) => { c.tangential_restitution = v; }) },
  { name: "radius of gyration ρ / m", low: 0.02, high: 2, step: 0.01, scaled: true, get: (s) => s.body.gyration_radius, set: (s, v) => { s.body.gyration_radius = v; } },
  { name: "mass m / kg", low: 0.1, high: 20, step: 0.1, get: (s) => s.body.mass, set: (s, v) => { s.body.mass = v; } },
];

export const slidersHtml = SLIDERS.map(({ name, low, high, step }, k) =>
  `<div class="sf-slider"><span>${escaped(name)}</span>`
  + `<input type="range" data-slider="${k}" min="${low}" max="${high}" step="${step}" aria-label="${escaped(name)}: slider">`
  + `<input type="number" data-number="${k}" step="${step}" aria-label="${escaped(name)}"></div>`).join("");

// Whether each contact has a line of its own as its ground, whose slope can be set.
export const hasSlopes = (scene) => !scene.terrain && scene.ground !== "shared";

// Leaves out of a scene what its terrain determines, which changes when a contact or a vertex is moved.
export function freed(scene) {
  for (const contact of scene.terrain ? scene.contact : []) {
    delete contact.slope;
    delete contact.segment;
  }
  return scene;
}

// A contact at a corner of the outline takes the corner along.
export function moveContact(scene, k, p) {
  const contact = scene.contact[k];
  const corner = scene.body.outline?.findIndex((c) => c[0] === contact.point[0] && c[1] === contact.point[1]) ?? -1;
  if (corner >= 0) scene.body.outline[corner] = [...p];
  contact.point = [...p];
}

// The first kick of a scene, which gets one that does nothing if it has none. Local models and certified runs have no kicks.
export function firstKick(scene) {
  if (!scene.kick?.length) scene.kick = [{ time: scene.run?.time ?? 0, impulse: [0, 0] }];
  if (scene.run?.model === "local") delete scene.run.model;
  delete scene.run?.certify;
  return scene.kick[0];
}

// The rows of the table: a name, for each column how to read and to write its number in a scene, and the headings from this row on, if they change.
export function rows(scene) {
  const pair = (name, get, set) => ["x", "y"].map((axis, i) => ({
    name: `${name}, ${axis}`,
    get: (s) => get(s)[i],
    set: (s, v) => { const p = [...get(s)]; p[i] = v; set(s, p); },
  }));
  const slope = (k) => ({ name: `contact ${k + 1}, slope`, get: (s) => s.contact[k].slope ?? 0, set: (s, v) => { s.contact[k].slope = v; } });
  const friction = (k) => ({ name: `contact ${k + 1}, friction`, get: (s) => s.contact[k].friction ?? 0, set: (s, v) => { s.contact[k].friction = v; } });
  const start = (name, key) => ["x", "y", "turn"].map((axis, i) => ({
    name: `${name}, ${axis}`,
    get: (s) => s.start?.[key]?.[i] ?? 0,
    set: (s, v) => { const p = [...s.start?.[key] ?? [0, 0, 0]]; p[i] = v; s.start = { ...s.start, [key]: p }; },
  }));
  const point = (s) => s.kick?.[0]?.point ?? s.body.center_of_mass;
  return [
    ["centre of mass", pair("centre of mass", (s) => s.body.center_of_mass, (s, p) => { s.body.center_of_mass = p; })],
    ...scene.contact.map((_, k) => [`contact ${k + 1}`,
      [...pair(`contact ${k + 1}`, (s) => s.contact[k].point, (s, p) => moveContact(s, k, p)), friction(k), ...(hasSlopes(scene) ? [slope(k)] : [])]]),
    ...(scene.terrain ?? []).map((_, k) => [`vertex ${k + 1}`, pair(`vertex ${k + 1} of the ground`, (s) => s.terrain[k], (s, p) => { s.terrain[k] = p; })]),
    ["kick at", pair("point of the kick", point, (s, p) => { firstKick(s).point = p; })],
    ["kick / N s", pair("impulse of the kick", (s) => s.kick?.[0]?.impulse ?? [0, 0], (s, p) => { firstKick(s).impulse = p; })],
    ["displaced by", start("start, displaced by", "q"), ["start", "x / m", "y / m", "θ / rad"]],
    ["velocity", start("start, velocity", "qdot"), ["start", "x / (m/s)", "y / (m/s)", "ω/(rad/s)"]],
  ];
}

// The table with an empty field for each number. `data-field`: its row and its column.
export function tableHtml(list, slopes) {
  const cell = ({ name }, row, column) => `<td><input type="number" step="${STEP}" data-field="${row},${column}" aria-label="${escaped(name)}"></td>`;
  const heads = (texts) => `<tr class="sf-heads">${texts.map((text) => `<th>${text}</th>`).join("")}</tr>`;
  return `<h3>Places, kick and start</h3><table><thead>${heads(["", "x / m", "y / m", "μ", ...(slopes ? ["slope/rad"] : [])])}</thead><tbody>`
    + list.map(([name, cells, own], row) => `${own ? heads(own) : ""}<tr><th scope="row">${escaped(name)}</th>${cells.map((one, column) => cell(one, row, column)).join("")}</tr>`).join("")
    + "</tbody></table>";
}

// Shows a number in a field, unless something has been typed there that is not yet taken.
export function put(input, value) {
  if (input.dataset.typed) return;
  input.value = Number(value.toPrecision(DIGITS));
  input.title = value;
}
