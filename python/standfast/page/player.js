// The player: a film of a run on a stage, by two clocks, with its gaps, its angle and the motion of the ground over time.
import { Stage, INK, axis, escaped, foot, forceArrows, placed } from "./stage.js";

// Frames of which the places of the body are looked at. A body that moves farther than so many sizes has no picture of its whole way.
const SAMPLES = 400, FAR = 16;
// Duration of a film, in s, when it is first shown: real time, and at most so much for the decades before Zeno points.
const REAL = 5, ZENO = 20;
// Seconds of a film during which an impact and a kick are shown.
const FLASH = 0.25, KICKED = 0.8;
// Colours and dashes of the curves of gaps.
const CURVES = { light: ["#0072B2", "#D55E00", "#009E73", "#CC79A7"], dark: ["#7cc4f0", "#ff8a4c", "#3ddba4", "#e8a5cb"] };
const DASHES = [[], [8, 3], [2, 3], [8, 3, 2, 3]];
// Height of the largest gap of the magnified body, in sizes of the body.
const LIFTED = 0.22;
// Least gap on the logarithmic axis, m.
const LEAST = 1e-13;
// Gaps below this share of the size of the body count as closed; if all are, there is nothing to show.
export const CLOSED = 1e-12;
// Heights of the panels, px.
const HEIGHTS = { gaps: 170, angle: 130, shaking: 130 };
const SUPERSCRIPT = "⁰¹²³⁴⁵⁶⁷⁸⁹";

// Pictures of buttons, which no font has to have.
const icon = (d) => `<svg width="16" height="16" viewBox="0 0 16 16" aria-hidden="true"><path d="${d}" fill="currentColor"/></svg>`;
const ICONS = {
  play: icon("M3 2L14 8L3 14Z"), pause: icon("M3 2H7V14H3ZM9 2H13V14H9Z"),
  before: icon("M2 2H4V14H2ZM14 2V14L5 8Z"), after: icon("M12 2H14V14H12ZM2 2L11 8L2 14Z"),
};

const PLAYER_HTML = `
<div class="sf-stage"></div>
<div class="sf-controls">
  <button class="sf-before" title="Event before (,)" aria-label="Event before">${ICONS.before}</button>
  <button class="sf-play" title="Play or pause (space)" aria-label="Play">${ICONS.play}</button>
  <button class="sf-after" title="Next event (.)" aria-label="Next event">${ICONS.after}</button>
  <input class="sf-seek" type="range" min="0" max="1" step="any" value="0" aria-label="Time of the film">
  <label>clock <select class="sf-clock"><option value="real">real time</option><option value="zeno">Zeno time</option></select></label>
  <label>speed <select class="sf-speed"></select></label>
</div>
<div class="sf-readout" aria-live="off"></div>
<ul class="sf-warnings"></ul>
<div class="sf-panels"></div>`;

// The motion of the ground at a time: its acceleration (x, y), m/s², or its tilt, rad. Before the first time it is 0.
function groundAt({ times, acceleration, tilt, interpolation }, t) {
  const k = times.findLastIndex((time) => time <= t);
  if (tilt?.length) return [k < 0 ? 0 : tilt[k]];
  if (k < 0) return [0, 0];
  if (interpolation !== "linear" || k + 1 === times.length) return acceleration[k];
  const share = (t - times[k]) / (times[k + 1] - times[k]);
  return acceleration[k].map((a, i) => a + share * (acceleration[k + 1][i] - a));
}

// The arrow of the motion of the ground: its acceleration relative to the largest, or the direction of gravity.
function shaking(motion, t) {
  const now = groundAt(motion, t);
  if (now.length === 1) return { arrow: now[0] ? [-Math.sin(now[0]), -Math.cos(now[0])] : [0, 0], label: `gravity on ground tilted by ${few(now[0])} rad` };
  const largest = Math.max(...motion.acceleration.map((a) => Math.hypot(...a)));
  return { arrow: now.map((a) => a / (largest || 1)), label: "the ground accelerates" };
}

// A time or a length in a few digits.
export function few(value) {
  if (value === 0) return "0";
  const size = Math.abs(value);
  if (size >= 1e-3 && size < 1e4) return Number(value.toPrecision(4)).toString();
  const [digits, power] = value.toExponential(1).split("e");
  return `${digits}·10${[...power.replace("+", "")].map((c) => (c === "-" ? "⁻" : SUPERSCRIPT[c])).join("")}`;
}

export class Player {
  // root: the element that is filled. stage: another element for the picture of the body, or null for one of its own.
  constructor(root, stage = null) {
    root.classList.add("sf-player");
    root.innerHTML = PLAYER_HTML;
    this.root = root;
    this.find = (name) => root.querySelector(`.sf-${name}`);
    if (stage) this.find("stage").remove();
    this.stage = stage ?? new Stage(this.find("stage"), "The body on its ground");
    this.theme = "light";
    this.position = 0;
    this.playing = false;
    // Whether the stage shows the film, and not something else.
    this.live = true;
    this.find("play").onclick = () => this.toggle();
    this.find("before").onclick = () => this.step(-1);
    this.find("after").onclick = () => this.step(1);
    this.find("seek").oninput = (event) => this.seek(Number(event.target.value));
    this.find("clock").onchange = (event) => this.setClock(event.target.value);
    this.find("speed").onchange = (event) => { this.speed = Number(event.target.value); };
    const observer = new ResizeObserver(() => this.resize());
    // Where the page lays out the parts of the player one by one, only they have a size.
    for (const part of [root, this.find("panels")]) observer.observe(part);
  }

  load(film, { play = false, clock = this.clock ?? "real" } = {}) {
    this.pause();
    this.film = film;
    const { frames } = film;
    this.seconds = { real: frames.t.map((t) => t - film.start), zeno: frames.zeno };
    this.largest = Math.max(0, ...frames.forces.flat().map((f) => Math.hypot(f[0] ?? 0, f[1] ?? 0)));
    const times = new Set([film.start, film.end]);
    for (const event of [film.impacts, film.zeno_points].flat()) times.add(event.time);
    for (const phase of film.phases) times.add(phase.start);
    for (const kick of film.kicks ?? []) if (kick.time <= film.end) times.add(kick.time);
    this.impactTimes = film.impacts.map((impact) => impact.time);
    this.events = [...times].sort((a, b) => a - b);
    const far = film.zeno_points.some((point) => point.infinite);
    this.find("clock").querySelector("[value=zeno]").disabled = !far;
    this.find("warnings").innerHTML = film.warnings.map((text) => `<li>${escaped(text)}</li>`).join("");
    this.frame();
    this.setClock(far ? clock : "real", 0);
    if (play) this.play();
  }

  // Places along the film of a point of the body, given at its place in the nominal posture.
  path(point) {
    return this.samples.map((k) => placed(point, this.film.drawing, this.film.frames.q[k], this.frozen));
  }

  // The part of the world that the film shows. Where the body moves far, the picture goes with it.
  frame() {
    const { film } = this;
    const { drawing, frames } = film;
    const shape = drawing.corners.length ? drawing.corners : [[-1, -1], [-1, 1], [1, 1], [1, -1]].map(
      (sign) => sign.map((s, k) => drawing.center_of_mass[k] + s * drawing.gyration_radius));
    const last = frames.q.length - 1;
    const step = Math.max(1, Math.floor(frames.q.length / SAMPLES));
    this.samples = [...frames.q.keys()].filter((k) => k % step === 0 || k === last);
    const all = this.swept = shape.flatMap((point) => this.path(point));
    const spread = Math.max(...[0, 1].map((k) => Math.max(...all.map((p) => p[k])) - Math.min(...all.map((p) => p[k]))));
    this.follows = spread > FAR * drawing.size;
    const tips = this.follows ? [] : this.samples.flatMap((k) => forceArrows(drawing, frames.q[k], this.frozen, frames.forces[k], this.largest)).filter(Boolean).map((arrow) => arrow.tip);
    const size = drawing.size;
    const near = this.follows ? [[-3, -2], [3, 3]].map((s) => s.map((v, k) => drawing.center_of_mass[k] + v * size)) : [...all, ...tips];
    // With room for the ground.
    const low = Math.min(...near.map((p) => p[1]));
    this.view = this.stage.fitted([...near, [near[0][0], low - 0.25 * size]]);
  }

  get frozen() {
    return this.film.model === "local";
  }

  setClock(clock, at = null) {
    const t = this.time;
    this.clock = clock;
    this.find("clock").value = clock;
    this.column = this.seconds[clock];
    this.whole = this.column.at(-1);
    this.normal = this.whole > 0 ? this.whole / (clock === "real" ? REAL : Math.min(ZENO, this.whole)) : 1;
    this.setSpeed(this.normal);
    this.find("seek").max = this.whole || 1;
    this.plot();
    this.seek(at ?? this.clockOf(t));
  }

  // The speed of the film, and others to choose.
  setSpeed(speed) {
    this.speed = speed;
    const unit = this.clock === "real" ? (v) => `${few(v)} × real` : (v) => `${few(v)} decades/s`;
    const choices = new Set([speed, ...[0.1, 0.25, 0.5, 1, 2, 5].map((factor) => factor * this.normal)]);
    this.find("speed").innerHTML = [...choices].sort((a, b) => a - b)
      .map((v) => `<option value="${v}"${v === speed ? " selected" : ""}>${unit(v)}</option>`).join("");
  }

  // The time of the film at a time of the run.
  clockOf(t) {
    const { t: times } = this.film.frames;
    const k = this.placeIn(times, t);
    const share = k + 1 < times.length ? (t - times[k]) / (times[k + 1] - times[k]) : 0;
    return this.column[k] + share * ((this.column[k + 1] ?? this.column[k]) - this.column[k]);
  }

  // The last place in a sorted column with an entry that is not above the value.
  placeIn(column, value) {
    let [low, high] = [0, column.length - 1];
    while (low < high) {
      const middle = (low + high + 1) >> 1;
      if (column[middle] <= value) low = middle;
      else high = middle - 1;
    }
    return low;
  }

  seek(position) {
    this.position = Math.min(Math.max(position, 0), this.whole);
    this.find("seek").value = this.position;
    this.show();
  }

  toggle() {
    if (this.playing) this.pause();
    else this.play();
  }
  play() {
    if (this.position >= this.whole) this.seek(0);
    this.playing = true;
    this.last = null;
    this.find("play").innerHTML = ICONS.pause;
    this.find("play").setAttribute("aria-label", "Pause");
    const tick = (now) => {
      if (!this.playing) return;
      if (this.last !== null) this.seek(this.position + (now - this.last) / 1000 * this.speed);
      this.last = now;
      if (this.position >= this.whole) this.pause();
      else requestAnimationFrame(tick);
    };
    requestAnimationFrame(tick);
  }
  pause() {
    this.playing = false;
    this.find("play").innerHTML = ICONS.play;
    this.find("play").setAttribute("aria-label", "Play");
  }

  // To the next event, or to the one before.
  step(way) {
    this.pause();
    const now = this.time;
    const next = way > 0 ? this.events.find((t) => t > now) : this.events.findLast((t) => t < now);
    if (next === undefined) return;
    const k = this.film.frames.t.indexOf(next);
    this.seek(k >= 0 ? this.column[k] : this.clockOf(next));
    this.exact = next;
    this.show();
  }

  // The time of the run that is shown.
  get time() {
    return this.now?.t ?? this.film?.start ?? 0;
  }

  // The frame between two frames of the film.
  between(position) {
    const { frames } = this.film;
    const k = this.placeIn(this.column, position);
    const next = Math.min(k + 1, frames.t.length - 1);
    const gap = this.column[next] - this.column[k];
    const share = gap > 0 ? (position - this.column[k]) / gap : 0;
    const mixed = (a, b) => a + share * (b - a);
    return {
      k,
      t: mixed(frames.t[k], frames.t[next]),
      q: frames.q[k].map((v, i) => mixed(v, frames.q[next][i])),
      gaps: frames.gaps[k].map((v, i) => (v === null || frames.gaps[next][i] === null ? v : mixed(v, frames.gaps[next][i]))),
      forces: frames.forces[k],
    };
  }

  show() {
    if (!this.film) return;
    const { film } = this;
    const now = this.between(this.position);
    if (this.exact !== undefined && this.exact !== null) now.t = this.exact;
    this.exact = null;
    this.now = now;
    const phase = film.phases.findLast((p) => p.start <= now.t) ?? film.phases[0];
    const near = (time, length) => {
      const since = this.position - this.clockOf(time);
      return now.t >= time && since <= length * this.speed;
    };
    const flash = new Set();
    const last = this.placeIn(this.impactTimes, now.t);
    for (let k = last; k >= 0 && film.impacts[k] && near(film.impacts[k].time, FLASH); k--) flash.add(film.impacts[k].contact);
    const { drawing } = film;
    const kick = (film.kicks ?? []).findLast((kick) => near(kick.time, KICKED) && Math.hypot(...kick.impulse) > 0);
    const head = kick && placed(kick.point ?? drawing.center_of_mass, drawing, now.q, this.frozen);
    const hardest = Math.max(0, ...(film.kicks ?? []).map((k) => Math.hypot(...k.impulse)));
    const motion = film.ground_motion;
    if (this.live) {
      this.stage.view = this.view;
      this.stage.shift = this.follows ? [now.q[0], now.q[1]] : null;
      this.stage.draw({
        drawing, q: now.q, frozen: this.frozen, magnified: this.magnified(now), letters: phase?.mode, forces: now.forces, largest: this.largest, flash,
        kick: kick && { from: head.map((v, i) => v - kick.impulse[i] / hardest * drawing.size), to: head },
        shaking: motion ? shaking(motion, now.t) : null,
      });
    }
    this.read(phase);
    this.mark();
    this.onshow?.();
  }

  // By the Zeno clock, the body lifted off the ground by a multiple of its gaps, so that the largest of them can be seen: a displacement
  // δ = Nᵀ(N Nᵀ)⁻¹ h more for each multiple, with the rows N of the normal velocities and the gaps h of the contacts that come to rest.
  // null where the gaps can be seen anyway.
  magnified(now) {
    if (this.clock !== "zeno") return null;
    const { film } = this;
    const { drawing, frames } = film;
    const point = film.zeno_points.find((z) => z.infinite && z.time > now.t);
    if (!point) return null;
    const contacts = point.contacts.slice(0, 2).map((number) => number - 1);
    // The largest gap in a decade around now.
    const [from, to] = [-0.5, 0.5].map((s) => this.placeIn(this.column, this.position + s));
    let largest = 0;
    for (let k = from; k <= to; k++) if (frames.t[k] < point.time) largest = Math.max(largest, ...contacts.map((c) => frames.gaps[k][c] ?? 0));
    const factor = LIFTED * drawing.size / largest;
    if (!(factor > 2) || !Number.isFinite(factor)) return null;
    const center = placed(drawing.center_of_mass, drawing, now.q, this.frozen);
    const rows = contacts.map((c) => {
      const at = foot(c, drawing, now.q, this.frozen);
      const [tx, ty] = axis(c, drawing, now.q, this.frozen);
      const [dx, dy] = [at[0] - center[0], at[1] - center[1]];
      return [-ty, tx, (dx * tx + dy * ty) / drawing.size];
    });
    const gaps = contacts.map((c) => now.gaps[c] ?? 0);
    const dot = (u, v) => u.reduce((sum, value, k) => sum + value * v[k], 0);
    let weights = [gaps[0] / dot(rows[0], rows[0])];
    if (rows.length === 2) {
      const [a, b, d] = [dot(rows[0], rows[0]), dot(rows[0], rows[1]), dot(rows[1], rows[1])];
      const det = a * d - b * b;
      if (!(det > 1e-9 * a * d)) return null;
      weights = [(d * gaps[0] - b * gaps[1]) / det, (a * gaps[1] - b * gaps[0]) / det];
    }
    const lift = [0, 1, 2].map((k) => (factor - 1) * weights.reduce((sum, w, i) => sum + w * rows[i][k], 0));
    return { q: [now.q[0] + lift[0], now.q[1] + lift[1], now.q[2] + lift[2] / drawing.size], factor };
  }

  // Marks the time in the panels.
  mark() {
    for (const chart of this.charts ?? []) chart.setCursor({ left: chart.valToPos(this.position, "x"), top: -1 }, false);
  }

  read(phase) {
    const { film, now } = this;
    const parts = [`t = ${now.t.toPrecision(7)} s`];
    const next = film.zeno_points.find((point) => point.infinite && point.time > now.t);
    if (next) parts.push(`${few(next.time - now.t)} s before the ${escaped(next.kind)} point`);
    parts.push(`θ = ${few(now.q[2])} rad`);
    if (phase) parts.push(`mode ${escaped(phase.mode)}`);
    if (this.position >= this.whole) parts.push(`end: ${escaped(film.outcome)}`);
    this.find("readout").innerHTML = parts.map((text) => `<span>${text}</span>`).join("");
  }

  setTheme(theme) {
    this.theme = theme;
    this.stage.ink = INK[theme];
    if (this.film) {
      this.plot();
      this.show();
    }
  }

  resize() {
    this.stage.resize();
    if (!this.film) return;
    for (const chart of this.charts) chart.setSize({ width: this.wide, height: chart.height });
    this.show();
  }

  // Width of a panel, px.
  get wide() {
    return Math.max(this.find("panels").clientWidth, 80);
  }

  // The panels over the time of the film: the gaps, logarithmic by the Zeno clock; the angle; the motion of the ground. One with nothing
  // to show is left out.
  plot() {
    for (const chart of this.charts ?? []) chart.destroy();
    this.charts = [];
    const { drawing, frames, ground_motion: motion } = this.film;
    const logarithmic = this.clock === "zeno";
    if (frames.gaps.some((gaps) => gaps.some((gap) => gap > CLOSED * drawing.size))) {
      const gaps = drawing.contacts.map((_, c) => [`contact ${c + 1}`, frames.gaps.map((all) => (all[c] === null || (logarithmic && !(all[c] > LEAST)) ? null : all[c]))]);
      const least = (u, low, high) => [LEAST, Math.max(high ?? 1, 10 * LEAST) * 3];
      this.panel("gaps", "gap / m", gaps, logarithmic
        ? { scale: { distr: 3, range: least }, axis: { splits: powers, filter: (u, values) => values, values: (u, values) => values.map((value) => value.toExponential(0)) } }
        : { scale: { range: (u, low, high) => [Math.min(low ?? 0, 0), (high ?? 1) * 1.05 || 1] } });
    }
    const angles = frames.q.map((q) => q[2]);
    if (angles.some((angle) => angle !== angles[0])) this.panel("angle", "θ / rad", [["angle θ", angles]]);
    if (motion) {
      const ground = frames.t.map((t) => groundAt(motion, t));
      const names = motion.tilt?.length ? ["tilt of the ground"] : ["acceleration of the ground, x", "y"];
      const columns = names.map((name, i) => [name, ground.map((values) => values[i])]).filter(([, values]) => values.some((value) => value !== 0));
      const steps = motion.interpolation === "linear" ? {} : { paths: uPlot.paths.stepped({ align: 1 }) };
      if (columns.length) this.panel("shaking", motion.tilt?.length ? "tilt / rad" : "a / (m/s²)", columns, { legend: true, series: steps });
    }
    this.mark();
  }

  // A panel with curves: their names and their values at the frames.
  panel(name, label, columns, { scale = {}, axis = {}, series = {}, legend = columns.length > 1 && columns.length <= 8 } = {}) {
    const ink = INK[this.theme];
    const look = { stroke: ink.ink, grid: { stroke: ink.ground, width: 1 }, ticks: { stroke: ink.ground, width: 1 }, font: "12px system-ui", labelFont: "12px system-ui" };
    const box = Object.assign(document.createElement("div"), { className: `sf-${name}` });
    this.find("panels").append(box);
    const chart = new uPlot({
      width: this.wide,
      height: HEIGHTS[name],
      // Without it, curves have steps of a pixel.
      pxAlign: false,
      legend: { show: legend, live: false },
      cursor: { y: false, points: { show: false }, drag: { x: false, y: false }, lock: true },
      scales: { x: { time: false, range: [0, this.whole || 1] }, y: scale },
      axes: [
        { ...look, label: this.clock === "zeno" ? "decades of the time left" : "time / s", labelSize: 18, size: 32 },
        { ...look, label, labelSize: 18, size: 74, space: 20, values: (u, values) => values.map(few), ...axis },
      ],
      series: [{ label: "time" }, ...columns.map(([text], c) => ({
        label: text, stroke: CURVES[this.theme][c % 4], dash: DASHES[c % 4], width: 1.6, spanGaps: false, points: { show: false }, ...series,
      }))],
      hooks: { ready: [(u) => this.scrub(u)], setSize: [() => queueMicrotask(() => this.mark())], destroy: [() => box.remove()] },
    }, [this.column, ...columns.map(([, values]) => values)], box);
    this.charts.push(chart);
  }

  // Pressing or dragging in a panel goes to that time.
  scrub(chart) {
    const go = (event) => {
      const box = chart.over.getBoundingClientRect();
      this.pause();
      this.seek(chart.posToVal(event.clientX - box.left, "x"));
    };
    chart.over.addEventListener("pointerdown", (event) => {
      chart.over.setPointerCapture(event.pointerId);
      go(event);
    });
    chart.over.addEventListener("pointermove", (event) => { if (event.buttons) go(event); });
    chart.over.style.cursor = "ew-resize";
    chart.over.style.touchAction = "pan-y";
  }

  // Keys: space, comma, full stop. Returns whether the key was one of them.
  key(event) {
    const act = { " ": () => this.toggle(), ",": () => this.step(-1), ".": () => this.step(1) }[event.key];
    if (!act || !this.film) return false;
    act();
    return true;
  }
}

// Every third power of ten in the range of an axis.
function powers(chart, axis, low, high) {
  const found = [];
  for (let k = 3 * Math.ceil(Math.log10(low) / 3); k <= Math.log10(high); k += 3) found.push(10 ** k);
  return found;
}
// Fills a page or a cell with a player of a film. speed: of the film, as a share of real time, or in decades of the time left per second.
export function play(root, film, { clock = "real", speed = null } = {}) {
  root.classList.add("sf-root");
  const box = root.appendChild(document.createElement("div"));
  const player = new Player(box);
  const dark = matchMedia("(prefers-color-scheme: dark)");
  const look = () => {
    root.dataset.theme = dark.matches ? "dark" : "light";
    player.setTheme(root.dataset.theme);
  };
  dark.addEventListener("change", look);
  look();
  player.load(film, { clock });
  if (speed) player.setSpeed(speed);
  root.tabIndex = 0;
  root.addEventListener("keydown", (event) => {
    if (!event.target.matches("button, input, select") && player.key(event)) event.preventDefault();
  });
  return player;
}
