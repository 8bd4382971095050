// What is known of a posture, as HTML: the verdict in words, and the contact modes at rest; and what its run does.
import { escaped } from "./stage.js";
import { CLOSED, few } from "./player.js";

const MARKS = { stable: "✓", unstable: "✗", undecided: "?", none: "–" };
const TITLES = { stable: "Stable posture", unstable: "Unstable posture", undecided: "Undecided posture", none: "No verdict" };
// What a verdict says.
const MEANINGS = {
  stable: "At rest here, the body comes back to rest near its place after every kick that is small enough",
  unstable: "At rest here, there are kicks, however small, after which the body need not come back",
  undecided: "At rest here, nothing is proved about small kicks",
};
// What the outcomes of runs mean.
const OUTCOMES = {
  rest: "comes to rest", zeno: "arrives at its first Zeno point", escape: "moves away for ever", sliding: "slides without end",
  inconsistent: "ends where no contact mode is consistent", ambiguous: "ends where several contact modes are consistent",
  "time-limit": "reaches the time limit", "event-limit": "reaches the event limit", "sensitivity-limit": "reaches the sensitivity limit",
};
// Kicks of a run that are named one by one.
const KICKS = 3;
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
  if (state === "stable") rows.push(["proved for impacts by", verdict.laws.join(", ")]);
  const by = verdict.by ?? verdict.reason;
  return `<h2><span aria-hidden="true">${MARKS[state]}</span> ${TITLES[state]}${by ? `<small title="${escaped(verdict.in_words)}">${escaped(by)}</small>` : ""}</h2>`
    + `<p>${[MEANINGS[state], by && `Why (${by}): ${verdict.in_words}`].filter(Boolean).map((text) => escaped(`${text}.`)).join(" ")}</p><dl>${rows.map(([name, text]) => `<dt>${escaped(name)}</dt><dd>${escaped(text)}</dd>`).join("")}</dl>`;
}

// While the film is computed: style.css shows it.
const WAIT = "<small class=\"sf-wait\">computing …</small>";
export const NO_RUN = `<h3>This run${WAIT}</h3>`;
export const FAILED_RUN = "<h3>This run</h3><p>It could not be computed: see the message.</p>";

// How a run starts that does not start at rest in the posture of the picture.
function starts({ q = [0, 0, 0], qdot = [0, 0, 0] } = {}) {
  const parts = [];
  if (q[0] || q[1]) parts.push(`displaced by ${vector(q.slice(0, 2))} m`);
  if (q[2]) parts.push(`turned by ${few(q[2])} rad`);
  if (qdot[0] || qdot[1]) parts.push(`with the velocity ${vector(qdot.slice(0, 2))} m/s`);
  if (qdot[2]) parts.push(`with ω = ${few(qdot[2])} rad/s`);
  return parts.length ? `started ${parts.join(", ")}` : null;
}

// What the run of the scene does, which is no part of the verdict. start: of the scene, how it starts. now: the instant of the film that is
// shown; null while none is shown.
export function runHtml(film, start, now) {
  const { kicks = [], frames, ground_motion: shaken } = film;
  const { size } = film.drawing;
  // Without what is only rounding.
  const [dx, dy, turn] = [size, size, 1].map((unit, k) => (q) => (Math.abs(q[k]) < CLOSED * unit ? 0 : q[k]));
  const moved = (q) => `centre of mass moved by ${vector([dx(q), dy(q)])} m, turned by ${few(turn(q))} rad`;
  const pushes = kicks.map(({ impulse }) => Math.hypot(...impulse)).filter((size) => size > 0).map((size) => `kicked with ${few(size)} N s`);
  const ground = shaken && (shaken.tilt?.length ? "on ground that tilts" : "on ground that shakes");
  const causes = [starts(start), ...pushes.slice(0, KICKS), pushes.length > KICKS && "…", ground].filter(Boolean);
  const from = causes.length ? `${causes.join(", ")}: ` : "";
  const end = OUTCOMES[film.outcome] ?? film.outcome;
  const ends = `${from}the body ${end}${film.outcome === "rest" ? "" : ","} at t = ${few(film.end)} s, ${moved(frames.q.at(-1))}.`;
  if (!now) return `<h3>This run${WAIT}</h3><p>${escaped(ends[0].toUpperCase() + ends.slice(1))}</p>`;
  const title = now.t >= film.end ? `This run ${end}` : "This run moves";
  return `<h3>${escaped(title)}<small>t = ${few(now.t)} s</small>${WAIT}</h3><p>Now: ${escaped(moved(now.q))}.</p>`
    + `<p class="sf-small">${escaped(ends[0].toUpperCase() + ends.slice(1))} The verdict is about small kicks of the posture at rest, and not about this run.</p>`;
}

export function modesHtml(modes) {
  if (modes.error) return `<p>${escaped(modes.error)}</p>`;
  const list = [...modes.modes].sort((a, b) => b.consistent - a.consistent).slice(0, Math.max(modes.consistent.length, MODES));
  const row = ({ word, consistent, acceleration, forces }) =>
    `<tr class="${consistent ? "yes" : "no"}"><td>${consistent ? "✓" : "✗"} ${escaped(word)}</td><td>${vector(acceleration)}</td><td>${forces.map((force) => `<span>${vector(force)}</span>`).join(" ")}</td></tr>`;
  return `<h3>Contact modes at rest: ${escaped(modes.status)}</h3><table>`
    + `<thead><tr><th>mode</th><th>q̈ / (m/s², rad/s²)</th><th>forces (t, n) / N</th></tr></thead><tbody>${list.map(row).join("")}</tbody></table>`
    + "<p class=\"sf-small\">S separate, F fixed, R and L slide right and left; ✗ contradicts Coulomb's law.</p>";
}
