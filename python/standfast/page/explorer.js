// The explorer: a scene to drag and kick, with its verdict, its modes, the map of stable places of the centre of mass, and its motion.
import { Stage, INK, escaped, frictions, nominal } from "./stage.js";
import { Player, few } from "./player.js";
import { PRESETS } from "./presets.js";
import { SLIDERS, firstKick, freed, hasSlopes, moveContact, put, rows, slidersHtml, tableHtml } from "./fields.js";
import { FAILED_RUN, NO_RUN, modesHtml, runHtml, verdictHtml } from "./report.js";
import { legendHtml, placesMap } from "./places.js";
import { decoded, download, encoded, png } from "./files.js";

// Frames of a film. Cells of the coarse map and of the fine one, along each side; the fine map is asked for by rows.
const FRAMES = 1200, COARSE = 60, FINE = 180, ROWS = 20;
// Quiet time before the fine map is computed, ms. Number of steps that can be undone.
const IDLE = 350, MOST_STEPS = 200;
// Speed of a kick along an arrow as long as the body, in units of √(g · size). Arrow shorter than this (px) is no kick.
const KICK = 0.6, LEAST_KICK = 8;
// Step of a key that moves a handle, as a share of the size of the body, or in rad.
const NUDGE = 0.01;
// Parts of the ground are in the first picture of a scene up to this distance from the centre of mass, and the tail of the arrow of the kick up
// to this distance from its head, in sizes of the body.
const NEAR = 4;
// Least extent of a body whose handles can be told apart, px.
const APART = 44;
// Name of a scene that comes with a link, and of one that the page was given.
const LINKED = "scene of the link", GIVEN = "scene given";
// Distance of the handle of a slope from its contact, in sizes of the body.
const KNOB = 0.42;

const LAWS = ["auto", "newton", "poisson", "stronge", "chatterjee-ruina", "moreau"];

const EXPLORER_HTML = `
<header class="sf-bar">
  <strong>standfast</strong>
  <label class="sf-name"><span>scene</span> <select class="sf-preset" aria-label="Scene"></select></label>
  <button class="sf-open" title="Open a scene file">Open</button><input class="sf-file" type="file" accept=".toml,.json" hidden>
  <button class="sf-save" title="Save the scene as a file">Save</button>
  <button class="sf-png" title="Save the picture as PNG">PNG</button>
  <button class="sf-svg" title="Save the picture as SVG">SVG</button>
  <button class="sf-link" title="Copy a link that holds the scene">Link</button>
  <button class="sf-undo" title="Undo (Ctrl+Z)" aria-label="Undo">↶</button>
  <button class="sf-redo" title="Redo (Ctrl+Y)" aria-label="Redo">↷</button>
  <button class="sf-theme" title="Light or dark" aria-label="Light or dark">◐</button>
</header>
<main class="sf-main">
  <section class="sf-left">
    <div class="sf-view"></div>
    <p class="sf-hint">Drag the centre of mass ◕, the contacts and the knobs of their slopes, or type their numbers. Drag from the body to kick it. Dotted: the path of the centre of mass in this run. <span class="sf-keys">Keys: Tab and arrows move, K kicks, space plays.</span></p>
    <div class="sf-film"></div>
  </section>
  <section class="sf-right">
    <div class="sf-said">
      <div class="sf-verdict" role="status"></div>
      <div class="sf-run" aria-live="off">${NO_RUN}</div>
    </div>
    <div class="sf-error" role="alert" hidden></div>
    <div class="sf-legend"></div>
    <div class="sf-sliders">${slidersHtml}</div>
    <div class="sf-fields"></div>
    <div class="sf-choices">
      <label>law of impact <select class="sf-law">${LAWS.map((law) => `<option>${law}</option>`).join("")}</select></label>
      <label>jams <select class="sf-jams"><option>none</option><option>impact</option></select></label>
      <label><input type="checkbox" class="sf-showmap" checked> map of stable places</label>
    </div>
    <div class="sf-modes"></div>
  </section>
</main>`;

const copied = (value) => JSON.parse(JSON.stringify(value));

export class Explorer {
  // root: the element that is filled. ask: question → promise of its answer. scene: to begin with. colors: of the words of a map.
  constructor(root, { ask, scene, colors, link = true }) {
    root.classList.add("sf-root", "sf-explorer");
    root.innerHTML = EXPLORER_HTML;
    root.tabIndex = -1;
    Object.assign(this, { root, ask, colors, link });
    this.find = (name) => root.querySelector(`.sf-${name}`);
    this.past = [];
    this.future = [];
    this.turn = 0; // of the questions about the scene
    this.opening = 0; // scenes that are being opened
    this.known = { posture: "awaited", film: "awaited" };
    this.stage = new Stage(this.find("view"), "The body on its ground");
    this.player = new Player(this.find("film"), this.stage);
    this.player.live = false;
    this.player.onshow = () => this.tell();
    this.find("preset").innerHTML = ["", ...Object.keys(PRESETS)].map((name) => `<option value="${name}">${name}</option>`).join("");
    this.build();
    this.setTheme(matchMedia("(prefers-color-scheme: dark)").matches ? "dark" : "light");
    matchMedia("(prefers-color-scheme: dark)").addEventListener("change", (event) => this.setTheme(event.matches ? "dark" : "light"));
    this.begin(scene);
  }

  async begin(scene) {
    const held = this.link ? this.held() : null;
    const [first] = Object.keys(PRESETS);
    if (held) await this.open(held, LINKED);
    else if (scene) await this.open(scene);
    else await this.open(PRESETS[first], first);
    if (this.link) addEventListener("hashchange", () => { const again = this.held(); if (again && JSON.stringify(again) !== JSON.stringify(this.scene)) this.open(again, LINKED); });
  }

  // ---- The scene and its history.

  // Opens a scene, as an object or as a text in TOML. One that is wrong changes nothing but the message.
  async open(scene, title = GIVEN) {
    this.opening += 1;
    this.mark();
    const answer = await this.question({ ask: "scene", scene });
    this.opening -= 1;
    this.mark();
    if (answer.error) {
      this.complain(answer.error);
      if (this.scene) {
        this.entitle();
      } else {
        this.known.posture = "none";
        this.fail();
      }
      return;
    }
    this.remember();
    this.scene = freed(answer.scene);
    this.origin = { title, text: JSON.stringify(this.scene) };
    await this.changed({ fit: true });
  }

  // What the styles show: whether something is asked, and whether the posture and the film of the scene are "shown", "awaited", or "none".
  mark() {
    const { root, known, opening } = this;
    root.setAttribute("aria-busy", Boolean(opening || this.asking));
    for (const name of ["posture", "film"]) root.dataset[name] = opening ? "awaited" : known[name];
  }

  // Shows the name of the scene. The list has a place, its first one, for the name of a scene that is none to begin with.
  entitle() {
    const { title, text } = this.origin;
    const same = text === JSON.stringify(this.scene);
    const listed = same && title in PRESETS;
    const list = this.find("preset");
    const [other] = list.options;
    other.textContent = listed ? "" : same ? title : `${title}, changed`;
    other.hidden = other.disabled = listed;
    list.value = listed ? title : "";
  }

  // What undo goes back to.
  get moment() {
    return JSON.stringify([this.origin, this.scene]);
  }

  remember() {
    if (!this.scene) return;
    this.past.push(this.moment);
    if (this.past.length > MOST_STEPS) this.past.shift();
    this.future = [];
  }

  async undo(from = this.past, to = this.future) {
    if (!from.length) return;
    to.push(this.moment);
    [this.origin, this.scene] = JSON.parse(from.pop());
    await this.changed({ fit: true });
  }

  async question(question) {
    try {
      return await this.ask(question);
    } catch (error) {
      return { error: String(error.message ?? error) };
    }
  }

  complain(text) {
    const box = this.find("error");
    box.hidden = !text;
    box.textContent = text ?? "";
  }

  // Asks again about the scene that has changed. While an answer is awaited, later changes replace each other.
  async changed({ fit = false, play = false, settled = true } = {}) {
    this.turn += 1;
    this.wanted = { fit: fit || this.wanted?.fit, play: play || this.wanted?.play, settled };
    this.entitle();
    this.known.film = "awaited";
    if (fit) this.known.posture = "awaited";
    this.asking ??= this.answer().finally(() => {
      this.asking = null;
      this.mark();
    });
    this.mark();
    return this.asking;
  }

  async answer() {
    while (this.wanted) {
      const { fit, play, settled } = this.wanted;
      this.wanted = null;
      this.player.pause();
      const scene = copied(this.scene);
      const about = await this.question({ ask: "posture", scene });
      if (this.wanted) { this.wanted.fit ||= fit; continue; }
      this.complain(about.error);
      this.known.posture = about.error ? "none" : "shown";
      this.mark();
      this.controls(settled);
      if (about.error) {
        this.fail();
        continue;
      }
      this.about = about;
      if (fit) {
        this.map = null;
        this.fit();
      }
      this.arrange();
      this.report();
      if (this.find("showmap").checked) await this.drawMap(COARSE);
      if (settled && !this.wanted) await this.settle(scene, { fit, play });
    }
  }

  // What takes longer: the film, then the fine map.
  async settle(scene, { fit, play }) {
    if (this.link) history.replaceState(null, "", `#${encoded(this.scene)}`);
    this.onchange?.();
    const film = await this.question({ ask: "motion", scene, frames: FRAMES });
    if (this.wanted) return;
    if (film.error) {
      this.complain(film.error);
      this.fail();
    } else {
      await this.load(film, scene, { fit, play });
    }
    const turn = this.turn;
    clearTimeout(this.idle);
    if (this.find("showmap").checked) this.idle = setTimeout(() => { if (turn === this.turn) this.drawMap(FINE); }, IDLE);
  }

  async load(film, scene, { fit, play }) {
    const { watching, player: { playing } } = this; // since the film before was awaited
    this.start = scene.start;
    this.player.load(film);
    this.known.film = "shown";
    this.mark();
    // The picture stays as it is under a pointer that drags.
    if (fit && !this.grip && !this.kicking) this.fit();
    this.arrange();
    if (play || watching) this.watch();
    if (play || playing) this.player.play();
    if (fit && this.find("showmap").checked) await this.drawMap(COARSE);
  }

  // There is no film of the scene.
  fail() {
    this.known.film = "none";
    this.mark();
    this.find("run").innerHTML = FAILED_RUN;
  }

  // Whether the film is that of the scene.
  get filmed() {
    return this.known.film === "shown";
  }

  // ---- The picture of the posture.

  fit() {
    const { drawing } = this.about;
    const { size, center_of_mass: [x, y] } = drawing;
    const points = [...drawing.corners, ...drawing.contacts, [x, y]];
    const low = Math.min(...points.map((p) => p[1]));
    const high = Math.max(...points.map((p) => p[1]));
    const left = Math.min(...points.map((p) => p[0]));
    const right = Math.max(...points.map((p) => p[0]));
    const near = (p, from) => Math.hypot(p[0] - from[0], p[1] - from[1]) < NEAR * size;
    const ground = (this.scene.terrain ?? []).filter((p) => near(p, [x, y]));
    const kick = this.drawnKick();
    const tail = kick && near(kick.from, kick.to) ? [kick.from] : [];
    const close = [[left - 0.3 * size, low - 0.35 * size], [right + 0.3 * size, high + 0.35 * size], ...ground, ...tail];
    const way = this.filmed && !this.player.follows ? this.player.swept : [];
    const whole = this.stage.fitted([...close, ...way]);
    const extent = Math.max(right - left, high - low, size);
    this.view = extent * this.stage.scaleOf(whole) >= APART ? whole : this.stage.fitted(close);
  }

  // Shows the posture at rest with its handles, and not the film.
  arrange() {
    this.watching = this.player.live = false;
    this.stage.shift = null;
    const { about, stage } = this;
    stage.view = this.view;
    const q = [0, 0, 0];
    const word = about.modes.consistent?.length === 1 ? about.modes.consistent[0] : null;
    const mode = about.modes.modes?.find((m) => m.word === word);
    const path = this.filmed ? this.player.path(about.drawing.center_of_mass) : null;
    // Forces at rest where they are one.
    this.seen = [stage.toWorld([0, stage.height]), stage.toWorld([stage.width, 0])];
    stage.draw({ path, drawing: about.drawing, q, frozen: false, letters: this.touching(word), forces: this.touching(mode?.forces), region: about.region, kick: this.drawnKick(), flash: null });
    this.showMap();
    this.handles();
    this.tell();
  }

  // Of each contact, sides on corners of the ground included, what a list has for those that touch.
  touching(list) {
    if (!list) return null;
    const all = frictions(this.about.drawing);
    if (list.length === all.length) return list;
    const touch = this.about.verdict.contacts ?? [];
    return all.map((_, k) => (touch.includes(k + 1) ? list[touch.indexOf(k + 1)] : null));
  }

  drawnKick() {
    const kick = this.dragged ?? this.scene.kick?.[0];
    if (!kick || !Math.hypot(...kick.impulse)) return null;
    const to = kick.point ?? this.scene.body.center_of_mass;
    const unit = this.kickUnit();
    return { to, from: to.map((v, k) => v - kick.impulse[k] / unit), label: `kick ${few(Math.hypot(...kick.impulse))} N s` };
  }

  // Impulse of an arrow of one metre, N s.
  kickUnit() {
    const { drawing } = this.about;
    const gravity = this.scene.gravity || 9.81;
    return this.scene.body.mass * KICK * Math.sqrt(gravity * drawing.size) / drawing.size;
  }

  handles() {
    const { stage, scene } = this;
    const own = hasSlopes(scene);
    const knob = KNOB * this.about.drawing.size;
    const list = [{ name: "centre of mass", at: scene.body.center_of_mass, move: (p) => { scene.body.center_of_mass = p; } }];
    scene.contact.forEach((contact, k) => {
      list.push({ name: `contact ${k + 1}`, at: contact.point, move: (p) => moveContact(scene, k, p) });
      const slope = contact.slope ?? 0;
      const place = [contact.point[0] + knob * Math.cos(slope), contact.point[1] + knob * Math.sin(slope)];
      if (own) {
        list.push({ name: `slope of contact ${k + 1}`, at: place, small: true, angle: slope, from: contact.point,
          move: ([x, y]) => { contact.slope = Math.atan2(y - contact.point[1], x - contact.point[0]); } });
      }
    });
    (scene.terrain ?? []).forEach((vertex, k) => list.push({ name: `vertex ${k + 1} of the ground`, at: vertex, small: true, move: (p) => { scene.terrain[k] = p; } }));
    const ink = INK[this.theme];
    const active = document.activeElement?.dataset?.handle;
    stage.layers.handles.innerHTML = list.map(({ name, at, small, from }, k) => {
      const [x, y] = stage.toScreen(at);
      const line = from ? `<path d="M${stage.toScreen(from).join(" ")}L${x} ${y}" stroke="${ink.faint}" stroke-dasharray="3 3" pointer-events="none"/>` : "";
      return `${line}<circle data-handle="${k}" tabindex="0" role="button" aria-label="${name}: arrow keys move it" cx="${x}" cy="${y}" r="${small ? 6 : 11}"`
        + ` fill="${small ? ink.paper : "transparent"}" stroke="${ink.faint}" stroke-opacity="${small ? 1 : 0.55}" style="cursor:grab"><title>${name}</title></circle>`;
    }).join("");
    this.list = list;
    if (active !== undefined) stage.svg.querySelector(`[data-handle="${active}"]`)?.focus();
  }

  // ---- Pointers and keys.

  build() {
    const { svg } = this.stage;
    // A swipe that begins beside the body and its handles scrolls the page; parts of a picture have no touch-action of their own.
    svg.addEventListener("touchstart", (event) => { if (this.under(event.touches[0])?.matches(".body, [data-handle]")) event.preventDefault(); }, { passive: false });
    svg.addEventListener("pointerdown", (event) => this.press(event));
    svg.addEventListener("pointermove", (event) => this.drag(event));
    svg.addEventListener("pointerup", (event) => this.release(event));
    svg.addEventListener("pointercancel", () => this.cancel());
    svg.addEventListener("keydown", (event) => this.nudge(event));
    this.root.addEventListener("keydown", (event) => this.key(event));
    this.find("preset").onchange = ({ target: { value } }) => { if (value) this.open(PRESETS[value], value); };
    this.find("open").onclick = () => this.find("file").click();
    this.find("file").onchange = (event) => this.read(event.target.files[0]);
    this.root.addEventListener("dragover", (event) => event.preventDefault());
    this.root.addEventListener("drop", (event) => { event.preventDefault(); this.read(event.dataTransfer.files[0]); });
    this.find("save").onclick = () => this.save();
    this.find("svg").onclick = () => download("standfast.svg", new Blob([this.stage.picture()], { type: "image/svg+xml" }));
    this.find("png").onclick = () => png(this.stage).then((blob) => download("standfast.png", blob));
    this.find("link").onclick = () => this.copyLink();
    this.find("undo").onclick = () => this.undo();
    this.find("redo").onclick = () => this.undo(this.future, this.past);
    this.find("theme").onclick = () => this.setTheme(this.theme === "dark" ? "light" : "dark");
    this.find("showmap").onchange = () => this.changed();
    this.find("law").onchange = (event) => this.edit((scene) => { scene.run = { ...scene.run, impact: event.target.value }; if (!["auto", "newton", "moreau"].includes(event.target.value) && ["together", "newton"].includes(scene.run.simultaneous)) delete scene.run.simultaneous; });
    this.find("jams").onchange = (event) => this.edit((scene) => { scene.run = { ...scene.run, jams: event.target.value }; });
    const [sliders, fields] = [this.find("sliders"), this.find("fields")];
    sliders.addEventListener("pointerdown", (event) => { if (event.target.dataset.slider) this.remember(); });
    sliders.addEventListener("keydown", (event) => { if (event.target.dataset.slider && event.key.startsWith("Arrow")) this.remember(); });
    for (const [box, change] of [[sliders, (input, settled) => this.slide(input, settled)], [fields, (input, settled) => settled && this.type(input, this.cell(input))]]) {
      box.addEventListener("input", ({ target }) => {
        if (target.type === "number") target.dataset.typed = "yes";
        else change(target, false);
      });
      box.addEventListener("change", ({ target }) => {
        if (target.dataset.number) this.type(target, SLIDERS[target.dataset.number]);
        else change(target, true);
      });
    }
    if (!this.link) this.find("link").hidden = true;
    new ResizeObserver(() => { this.stage.resize(); if (this.about && !this.watching) this.arrange(); }).observe(this.find("view"));
    // A press on play, or on a time, shows the film.
    this.find("film").addEventListener("pointerdown", () => this.watch(), true);
    this.find("film").addEventListener("keydown", () => this.watch(), true);
  }

  // Shows the film and not the posture at rest.
  watch() {
    if (this.known.film === "none") return;
    this.watching = this.player.live = true;
    this.stage.layers.handles.innerHTML = "";
    this.stage.drawMap(null);
    this.player.show();
  }

  edit(change, options) {
    this.remember();
    change(this.scene);
    return this.changed(options);
  }

  slide(input, settled) {
    const slider = SLIDERS[input.dataset.slider];
    slider.set(this.scene, Number(input.value));
    this.changed({ settled });
  }

  // Takes a number that has been typed. What is no number is replaced by the one before.
  type(input, { get, set }) {
    delete input.dataset.typed;
    const value = input.valueAsNumber;
    if (Number.isFinite(value)) this.edit((scene) => set(scene, value));
    else put(input, get(this.scene));
  }

  // What a field of the table reads and writes.
  cell(input) {
    const [row, column] = input.dataset.field.split(",");
    return this.rows[row][1][column];
  }

  // The part of the picture that is under a pointer: the target of a touch can be a handle beside it.
  under({ clientX, clientY }) {
    return this.root.getRootNode().elementFromPoint(clientX, clientY);
  }

  press(event) {
    const target = this.under(event) ?? event.target;
    const { handle } = target.dataset;
    this.stage.svg.setPointerCapture(event.pointerId);
    this.beside = false;
    if (handle !== undefined && !this.watching) {
      target.focus();
      this.remember();
      const at = this.stage.pointer(event);
      this.grip = { index: Number(handle), off: this.list[handle].at.map((v, k) => v - at[k]) };
    } else if (target.classList.contains("body")) {
      const { drawing } = this.about;
      const q = this.watching ? this.player.now.q : [0, 0, 0];
      this.kicking = { from: this.stage.pointer(event), point: nominal(this.stage.pointer(event), drawing, q) };
    } else {
      this.beside = true; // or the beginning of a swipe, which is cancelled
    }
  }

  drag(event) {
    const at = this.stage.pointer(event);
    if (this.grip) {
      const { index, off } = this.grip;
      this.list[index].move(at.map((v, k) => v + off[k]));
      this.changed({ settled: false });
    } else if (this.kicking) {
      this.player.pause();
      const { from, point } = this.kicking;
      const unit = this.kickUnit();
      this.dragged = { impulse: at.map((v, k) => (v - from[k]) * unit), point };
      this.arrange();
    }
  }

  release() {
    if (this.grip) {
      this.grip = null;
      this.changed();
    } else if (this.kicking) {
      const kick = this.dragged;
      this.kicking = this.dragged = null;
      if (kick && Math.hypot(...kick.impulse) / this.kickUnit() * this.stage.scale >= LEAST_KICK) this.kick(kick);
      else this.arrange();
    } else if (this.beside && this.watching) {
      this.player.pause();
      this.arrange();
    }
  }

  cancel() {
    const { grip, kicking } = this;
    this.grip = this.kicking = this.dragged = null;
    if (grip) this.changed();
    else if (kicking) this.arrange();
  }

  // Gives the scene this kick as its first one, as if its numbers were typed, and shows what follows.
  kick(kick) {
    return this.edit((scene) => Object.assign(firstKick(scene), kick), { fit: true, play: true });
  }

  nudge(event) {
    const handle = this.list?.[event.target.dataset?.handle];
    const way = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] }[event.key];
    if (!handle || !way) return;
    event.preventDefault();
    const step = NUDGE * (event.shiftKey ? 10 : 1);
    const turned = handle.angle !== undefined;
    const size = this.about.drawing.size;
    const angle = handle.angle + step * (way[0] + way[1]);
    const to = turned ? [handle.from[0] + Math.cos(angle), handle.from[1] + Math.sin(angle)] : handle.at.map((v, k) => v + step * size * way[k]);
    this.edit(() => handle.move(to));
  }

  key(event) {
    if (event.ctrlKey || event.metaKey) {
      const key = event.key.toLowerCase();
      if (key === "z" && !event.shiftKey) this.undo();
      else if (key === "y" || key === "z") this.undo(this.future, this.past);
      else return;
      event.preventDefault();
      return;
    }
    if (event.target.matches("input:not([type=checkbox]):not([type=range]), select")) return;
    if (event.key.toLowerCase() === "k") {
      const { drawing } = this.about;
      this.kick({ impulse: [0.5 * drawing.size * this.kickUnit(), 0], point: this.scene.body.center_of_mass });
    } else if (!(event.key === " " && event.target.matches("button, input")) && [" ", ",", "."].includes(event.key)) {
      this.watch();
      this.player.key(event);
      event.preventDefault();
    }
  }

  // ---- The report.

  report() {
    const box = this.find("verdict");
    box.dataset.state = this.about.verdict.frictional_stability ?? "none";
    box.innerHTML = verdictHtml(this.about, this.scene);
    this.find("modes").innerHTML = modesHtml(this.about.modes);
  }

  // Says what the run does: beside the verdict of the posture, and above it while the film is shown.
  tell() {
    const { film } = this.player;
    if (!film || !this.about || this.known.film === "none") return;
    this.find("said").dataset.watching = Boolean(this.watching);
    this.find("run").innerHTML = runHtml(film, this.start, this.watching ? this.player.now : null);
  }

  // Shows the scene in the sliders and in the fields. settled: sliders are not moved while one of them is dragged.
  controls(settled) {
    const { scene } = this;
    const list = rows(scene);
    // The fields stay the same ones as long as they have the same names, so that the focus stays.
    const html = tableHtml(list, hasSlopes(scene));
    if (html !== this.table) this.find("fields").innerHTML = this.table = html;
    this.rows = list;
    for (const input of this.find("fields").querySelectorAll("[data-field]")) put(input, this.cell(input).get(scene));
    for (const input of this.root.querySelectorAll("[data-number]")) put(input, SLIDERS[input.dataset.number].get(scene));
    for (const input of settled ? this.root.querySelectorAll("[data-slider]") : []) {
      const slider = SLIDERS[input.dataset.slider];
      const value = slider.get(scene);
      if (slider.scaled) input.max = Math.max(Number(input.max), 2 * value);
      else if (value > Number(input.max)) input.max = value;
      if (value < Number(input.min)) input.min = value;
      input.value = value;
    }
    this.find("law").value = scene.run?.impact ?? "auto";
    this.find("jams").value = scene.run?.jams ?? "none";
    this.find("undo").disabled = !this.past.length;
    this.find("redo").disabled = !this.future.length;
  }

  // ---- The map of the centre of mass.

  // The map over the part of the world that the picture of the posture shows, with as many cells along each side. The fine map is given up if the scene changes.
  async drawMap(cells) {
    const { turn } = this;
    const rows = cells > COARSE ? ROWS : cells;
    const valid = () => cells === COARSE || turn === this.turn;
    const map = await placesMap((question) => this.question(question), copied(this.scene), this.seen, { cells, rows, colors: this.colors, valid });
    if (!valid()) return;
    this.map = map;
    this.showMap();
    this.find("legend").innerHTML = map ? legendHtml(map, this.colors) : "";
  }

  showMap() {
    if (this.watching) return;
    this.find("legend").hidden = !this.find("showmap").checked;
    if (this.map && this.find("showmap").checked) this.stage.drawMap(this.map.url, ...this.map.box);
    else this.stage.drawMap(null);
  }

  // ---- Files, links, look.

  async read(file) {
    if (!file) return;
    if (file.size > 1 << 20) return this.complain(`${file.name} is larger than 1 MiB`);
    const text = await file.text();
    let scene = text;
    if (/\.json$/i.test(file.name)) {
      try {
        scene = JSON.parse(text);
      } catch (error) {
        return this.complain(`${file.name}: ${error.message}`);
      }
    }
    this.find("file").value = "";
    return this.open(scene, file.name);
  }

  async save() {
    const answer = await this.question({ ask: "scene", scene: this.scene });
    if (answer.error) this.complain(answer.error);
    else download("scene.toml", new Blob([answer.toml], { type: "text/plain" }));
  }

  async copyLink() {
    const url = new URL(location.href); // with the token, without which the server refuses the page
    url.hash = encoded(this.scene);
    const button = this.find("link");
    try {
      await navigator.clipboard.writeText(url.href);
      button.textContent = "Copied";
    } catch {
      button.textContent = "See address bar";
    }
    setTimeout(() => { button.textContent = "Link"; }, 1500);
  }

  // The scene that the address holds; null if it holds none.
  held() {
    try {
      return decoded(location.hash);
    } catch {
      this.complain("the link holds no scene");
      return null;
    }
  }

  setTheme(theme) {
    this.theme = theme;
    this.root.dataset.theme = theme;
    this.stage.ink = INK[theme];
    this.player.setTheme(theme);
    if (this.about && !this.watching) this.arrange();
  }
}
