// What is known of a posture, as HTML: the verdict in words, and the contact modes at rest.
import { escaped } from "./stage.js";
import { few } from "./player.js";

const MARKS = { stable: "✓", unstable: "✗", undecided: "?", none: "–" };
const TITLES = { stable: "Stable", unstable: "Unstable", undecided: "Undecided", none: "No verdict" };
// Rows of the table of modes, if not more are consistent.
const MODES = 6;

const plain = (value) => (typeof value === "number" ? few(value) : escaped(value ?? "–"));
const vector = (values) => `(${values.map(plain).join(", ")})`;

export function verdictHtml({ verdict, region, friction_margin: margin }, scene) {
  const state = verdict.frictional_stability ?? "none";
  const [x] = scene.body.center_of_mass;
  const rows = [];
  if (verdict.error) rows.push(["why not", verdict.error]);
  rows.push(["equilibrium", region ? `centre of mass at ${few(x)} m, region ${region.map(plain).join(" … ")} m` : "no position of the centre of mass is held"]);
  if (margin !== null && margin >= 0) rows.push(["friction margin", few(margin)]);
  if (verdict.amplification) rows.push(["amplification", `no later motion is faster than ${few(verdict.amplification)} times the kick`]);
  if (state === "stable") rows.push(["impact laws", verdict.laws.join(", ")]);
  const by = verdict.by ?? verdict.reason;
  return `<h2><span aria-hidden="true">${MARKS[state]}</span> ${TITLES[state]}${by ? `<small>${escaped(by)}</small>` : ""}</h2>`
    + `<p>${escaped(verdict.in_words ?? "")}</p><dl>${rows.map(([name, text]) => `<dt>${escaped(name)}</dt><dd>${escaped(text)}</dd>`).join("")}</dl>`;
}

export function modesHtml(modes) {
  if (modes.error) return `<p>${escaped(modes.error)}</p>`;
  const list = [...modes.modes].sort((a, b) => b.consistent - a.consistent).slice(0, Math.max(modes.consistent.length, MODES));
  const row = ({ word, consistent, acceleration, forces }) =>
    `<tr class="${consistent ? "yes" : "no"}"><td>${consistent ? "✓" : "✗"} ${escaped(word)}</td><td>${vector(acceleration)}</td><td>${forces.map(vector).join(" ")}</td></tr>`;
  return `<h3>Contact modes at rest: ${escaped(modes.status)}</h3><div class="sf-table"><table>`
    + `<thead><tr><th>mode</th><th>q̈ / (m/s², rad/s²)</th><th>forces (t, n) / N</th></tr></thead><tbody>${list.map(row).join("")}</tbody></table></div>`
    + "<p class=\"sf-small\">S separate, F fixed, R and L slide right and left; ✗ contradicts Coulomb's law.</p>";
}
