// The stage: an SVG picture, to scale, of a body on its ground. Lengths in m, y upwards; forces in N.

const SVG = "http://www.w3.org/2000/svg";

// Okabe and Ito's colours, which can be distinguished with every kind of colour vision.
export const INK = {
  light: {
    paper: "#ffffff", ink: "#1a1a1a", faint: "#767676", ground: "#d9d9d9", surface: "#7f7f7f", body: "#56B4E9",
    force: "#0072B2", cone: "#0072B2", kick: "#B87700", flash: "#D55E00", region: "#009E73",
  },
  dark: {
    paper: "#15181c", ink: "#f0f0f0", faint: "#a0a0a0", ground: "#3a3f45", surface: "#9aa0a6", body: "#56B4E9",
    force: "#7cc4f0", cone: "#7cc4f0", kick: "#F0B429", flash: "#ff8a4c", region: "#3ddba4",
  },
};

const FONT = "13px system-ui, sans-serif";
// Length of the arrow of a force as large as the weight, and of the sides of the friction cones, in sizes of the body. A force larger than so
// many weights has an arrow of that length.
const ARROW = 0.9, LONGEST = 3;
// Radius of a marker and length of an arrow head, in px.
const MARK = 4, HEAD = 9;
// Width of the rim in which the body can be taken hold of, px.
const GRIP = 22;
// Free share of the picture around the body.
const MARGIN = 0.16;
// Width of a letter and height of a line of the font, and least distance of a text from the edge of the picture, px.
const LETTER = 7, LINE = 13, EDGE = 6;

const escapes = { "&": "&amp;", "<": "&lt;", ">": "&gt;", '"': "&quot;" };
export const escaped = (text) => String(text).replace(/[&<>"]/g, (c) => escapes[c]);

// The turn of a vector by an angle; in the local model, which keeps the geometry frozen, by first order.
export function turned([x, y], theta, frozen) {
  const [c, s] = frozen ? [1, theta] : [Math.cos(theta), Math.sin(theta)];
  return [c * x - s * y, s * x + c * y];
}

// The place in the world of a point of the body, given at its place in the nominal posture.
export function placed(point, drawing, q, frozen) {
  const [cx, cy] = drawing.center_of_mass;
  const [x, y] = turned([point[0] - cx, point[1] - cy], q[2], frozen);
  return [cx + q[0] + x, cy + q[1] + y];
}

// The point of the body, at its place in the nominal posture, that is at a place in the world. The inverse of `placed`.
export function nominal(place, drawing, q) {
  const [cx, cy] = drawing.center_of_mass;
  const [x, y] = turned([place[0] - cx - q[0], place[1] - cy - q[1]], -q[2], false);
  return [cx + x, cy + y];
}

// The tangent of the ground under a point: that of the piece on which it stands, or of the nearest piece.
export function tangent(point, ground) {
  let best = [Infinity, [1, 0]];
  for (const { point: from, direction: [tx, ty], ends } of ground) {
    const [dx, dy] = [point[0] - from[0], point[1] - from[1]];
    const [low, high] = limits(ends);
    const along = Math.min(Math.max(dx * tx + dy * ty, low), high);
    const away = Math.hypot(dx - along * tx, dy - along * ty);
    if (away < best[0]) best = [away, [tx, ty]];
  }
  return best[1];
}

// The side of the body that is contact k, if it is one: sides on corners of the ground come after the contacts of the posture.
const side = (k, drawing) => drawing.sides?.[k - drawing.contacts.length];

// The tangent of a contact in the world. Along a side it turns with the body.
export function axis(k, drawing, q, frozen) {
  const on = side(k, drawing);
  if (on) return frozen ? on.along : turned(on.along, q[2], false);
  return tangent(foot(k, drawing, q, frozen), drawing.ground);
}

// The coefficients of friction of all contacts.
export const frictions = ({ friction, sides }) => [...friction, ...(sides ?? []).map((on) => on.friction)];

// Where a contact is in the world: of a disc, the point below its centre; of a side, the corner of the ground.
export function foot(k, drawing, q, frozen) {
  const on = side(k, drawing);
  if (on) return on.corner;
  const radius = drawing.radii?.[k] ?? 0;
  if (!radius) return placed(drawing.contacts[k], drawing, q, frozen);
  const [x, y] = placed(drawing.centers[k], drawing, q, frozen);
  const [tx, ty] = tangent([x, y], drawing.ground);
  return [x + radius * ty, y - radius * tx];
}

// Limits as numbers: JSON has the strings "inf" and "-inf".
export function limits(ends) {
  return ends.map((end) => (end === "inf" ? Infinity : end === "-inf" ? -Infinity : end));
}

// The interval along a piece of ground that is inside a box; null if there is none.
function clipped(piece, low, high) {
  let [first, last] = limits(piece.ends);
  for (const k of [0, 1]) {
    const [p, t] = [piece.point[k], piece.direction[k]];
    if (Math.abs(t) < 1e-300) {
      if (p < low[k] || p > high[k]) return null;
      continue;
    }
    const ends = [(low[k] - p) / t, (high[k] - p) / t];
    first = Math.max(first, Math.min(...ends));
    last = Math.min(last, Math.max(...ends));
  }
  return first < last ? [first, last] : null;
}

// The arrows of contact forces: foot, tip, and the vector of a force (tangential, normal) there. Without weight, the largest force sets the
// scale. null for a contact without a force.
export function forceArrows(drawing, q, frozen, forces, largest) {
  const weight = drawing.weight || largest || 1;
  return frictions(drawing).map((_, k) => {
    const force = forces?.[k];
    if (!force || force[0] === null || force[1] === null || !(Math.hypot(...force) > 1e-9 * (largest || 1))) return null;
    const at = foot(k, drawing, q, frozen);
    const [tx, ty] = axis(k, drawing, q, frozen);
    const vector = ([ft, fn]) => [ft * tx - fn * ty, ft * ty + fn * tx];
    const unit = ARROW * drawing.size / Math.max(weight, Math.hypot(...force) / LONGEST);
    return { foot: at, vector, tip: vector(force).map((f, i) => at[i] + f * unit) };
  });
}

const path = (points, closed) => points.map(([x, y], k) => `${k ? "L" : "M"}${x.toFixed(2)} ${y.toFixed(2)}`).join("") + (closed ? "Z" : "");

export class Stage {
  // parent: the element that gets the picture. The picture has its size.
  constructor(parent, label) {
    this.svg = document.createElementNS(SVG, "svg");
    this.svg.setAttribute("role", "group");
    this.svg.setAttribute("aria-label", label);
    this.svg.style.cssText = "display:block;width:100%;height:100%";
    this.layers = {};
    for (const name of ["back", "map", "ground", "scene", "handles"]) {
      this.layers[name] = this.svg.appendChild(document.createElementNS(SVG, "g"));
    }
    parent.append(this.svg);
    this.ink = INK.light;
    this.view = { low: [-1, -1], high: [1, 1] };
    this.resize();
  }

  resize() {
    const box = this.svg.parentElement.getBoundingClientRect();
    [this.width, this.height] = [Math.max(box.width, 50), Math.max(box.height, 50)];
    this.svg.setAttribute("viewBox", `0 0 ${this.width} ${this.height}`);
  }

  // The part of the world to see: the box of these points, with a margin.
  fitted(points) {
    const low = [0, 1].map((k) => Math.min(...points.map((p) => p[k])));
    const high = [0, 1].map((k) => Math.max(...points.map((p) => p[k])));
    const room = MARGIN * Math.max(high[0] - low[0], high[1] - low[1], 1e-9);
    return { low: low.map((v) => v - room), high: high.map((v) => v + room) };
  }

  // Pixels in a metre, and the world point at the middle of the picture.
  get scale() {
    return this.scaleOf(this.view);
  }
  scaleOf({ low, high }) {
    return Math.min(this.width / (high[0] - low[0]), this.height / (high[1] - low[1]));
  }
  get middle() {
    const { low, high } = this.view;
    return [0.5 * (low[0] + high[0]) + (this.shift?.[0] ?? 0), 0.5 * (low[1] + high[1]) + (this.shift?.[1] ?? 0)];
  }
  toScreen([x, y]) {
    const [mx, my] = this.middle;
    return [0.5 * this.width + (x - mx) * this.scale, 0.5 * this.height - (y - my) * this.scale];
  }
  toWorld([px, py]) {
    const [mx, my] = this.middle;
    return [mx + (px - 0.5 * this.width) / this.scale, my - (py - 0.5 * this.height) / this.scale];
  }
  // The place in the world of a pointer event.
  pointer(event) {
    const box = this.svg.getBoundingClientRect();
    return this.toWorld([event.clientX - box.left, event.clientY - box.top]);
  }

  // scene: { drawing, q, frozen, letters, forces, largest, kick, flash, path, shaking, region }
  draw(scene) {
    this.scene = scene;
    this.layers.back.innerHTML = `<rect width="${this.width}" height="${this.height}" fill="${this.ink.paper}"/>`;
    this.drawGround(scene.drawing);
    this.layers.scene.innerHTML = [
      scene.region === undefined ? "" : this.region(scene),
      scene.magnified ? this.ghost(scene) : "",
      scene.path ? this.trace(scene.path) : "",
      this.body(scene),
      this.contacts(scene),
      this.arrows(scene),
    ].join("");
  }

  drawGround(drawing) {
    const [low, high] = [this.toWorld([0, this.height]), this.toWorld([this.width, 0])];
    const depth = 14 / this.scale;
    const seen = drawing.ground.map((piece) => [piece, clipped(piece, low, high)]).filter(([, ends]) => ends);
    const at = ({ point: [x, y], direction: [tx, ty] }, s, down) => this.toScreen([x + s * tx + down * ty, y + s * ty - down * tx]);
    const strips = seen.map(([piece, [a, b]]) => path([at(piece, a, 0), at(piece, b, 0), at(piece, b, depth), at(piece, a, depth)], true));
    const lines = seen.map(([piece, [a, b]]) => path([at(piece, a, 0), at(piece, b, 0)]));
    this.layers.ground.innerHTML =
      `<path d="${strips.join("")}" fill="${this.ink.ground}"/><path d="${lines.join("")}" stroke="${this.ink.surface}" stroke-width="1.5" fill="none"/>`;
  }

  body({ drawing, q, frozen }) {
    const { ink } = this;
    const at = (point) => this.toScreen(placed(point, drawing, q, frozen));
    const center = at(drawing.center_of_mass);
    const look = `fill="${ink.body}" fill-opacity="0.22" stroke="${ink.ink}" stroke-width="1.8" stroke-linejoin="round"`;
    const parts = [];
    if (drawing.corners.length) {
      parts.push(`<path d="${path(drawing.corners.map(at), true)}" ${look}/>`);
    } else {
      parts.push(`<circle cx="${center[0]}" cy="${center[1]}" r="${drawing.gyration_radius * this.scale}" ${look}/>`);
    }
    if (!drawing.has_outline) {
      // Of a disc, its circle and a radius that turns with it.
      const rim = (k) => {
        const [x, y] = at(drawing.centers[k]), r = drawing.radii[k] * this.scale;
        return `M${x - r} ${y}a${r} ${r} 0 1 0 ${2 * r} 0a${r} ${r} 0 1 0 ${-2 * r} 0`;
      };
      const line = (point, k) => (drawing.radii?.[k] ? path([center, at(drawing.centers[k]), at(point)]) + rim(k) : path([center, at(point)]));
      const arms = drawing.contacts.map(line).join("");
      parts.push(`<path d="${arms}" stroke="${ink.ink}" stroke-width="0.8" fill="none" pointer-events="none"/>`);
    }
    // Where the body can be taken hold of: a little around its shape and its centre of mass.
    const shape = drawing.corners.length ? [...drawing.corners.map(at), center] : [center];
    parts.push(`<path class="body" d="${path(shape, true)}" fill="transparent" stroke="transparent" stroke-width="${GRIP}" stroke-linejoin="round" stroke-linecap="round"/>`);
    if (!drawing.corners.length) parts.push(`<circle class="body" cx="${center[0]}" cy="${center[1]}" r="${drawing.gyration_radius * this.scale}" fill="transparent"/>`);
    // The sign of a centre of mass: a quartered disc.
    const [x, y] = center, r = 7;
    parts.push(
      `<g pointer-events="none"><circle cx="${x}" cy="${y}" r="${r}" fill="${ink.paper}" stroke="${ink.ink}"/>`
      + `<path d="M${x} ${y}L${x} ${y - r}A${r} ${r} 0 0 1 ${x + r} ${y}ZM${x} ${y}L${x} ${y + r}A${r} ${r} 0 0 1 ${x - r} ${y}Z" fill="${ink.ink}"/></g>`,
    );
    return parts.join("");
  }

  // The path of the centre of mass.
  trace(points) {
    return `<path class="sf-path" d="${path(points.map((p) => this.toScreen(p)))}" fill="none" stroke="${this.ink.ink}" stroke-width="1.2" stroke-dasharray="2 4" pointer-events="none"/>`;
  }

  // The body with magnified gaps.
  ghost({ drawing, magnified: { q, factor } }) {
    const { ink } = this;
    const at = (point) => this.toScreen(placed(point, drawing, q, true));
    const [x, y] = at(drawing.center_of_mass);
    const look = `fill="none" stroke="${ink.flash}" stroke-width="1.8" stroke-dasharray="7 4" stroke-linejoin="round"`;
    const shape = drawing.corners.length
      ? `<path d="${path(drawing.corners.map(at), drawing.corners.length > 2)}" ${look}/>`
      : `<circle cx="${x}" cy="${y}" r="${drawing.gyration_radius * this.scale}" ${look}/>`;
    const feet = drawing.contacts.map((_, k) => this.toScreen(foot(k, drawing, q, true))).map(([px, py]) => `<circle cx="${px}" cy="${py}" r="3" fill="${ink.flash}"/>`).join("");
    const power = Math.floor(Math.log10(factor));
    const text = factor < 1000 ? `${Math.round(factor)} ` : `${(factor / 10 ** power).toFixed(1)}·10<tspan dy="-5" font-size="10">${power}</tspan><tspan dy="5"> </tspan>`;
    return `<g pointer-events="none">${shape}${feet}<text x="12" y="24" style="font:${FONT}" fill="${ink.flash}">dashed: gaps ${text}times as large</text></g>`;
  }

  contacts({ drawing, q, frozen, letters, flash }) {
    const { ink } = this;
    const center = this.toScreen(placed(drawing.center_of_mass, drawing, q, frozen));
    return frictions(drawing).map((_, k) => {
      const letter = letters?.[k] && letters[k] !== "S" ? letters[k] : "";
      const hit = flash?.has(k + 1);
      // A side that does not touch its corner is no point of the picture.
      if (k >= drawing.contacts.length && letters?.[k] === "S" && !hit) return "";
      const [x, y] = this.toScreen(foot(k, drawing, q, frozen));
      const away = Math.hypot(x - center[0], y - center[1]) || 1;
      const [ux, uy] = away > 1 ? [(x - center[0]) / away, (y - center[1]) / away] : [0, 1];
      const ring = hit ? `<circle cx="${x}" cy="${y}" r="13" fill="none" stroke="${ink.flash}" stroke-width="3"/>` : "";
      const text = `${k + 1}${letter && `<tspan font-weight="700" dx="3">${escaped(letter)}</tspan>`}`;
      return `${ring}<circle cx="${x}" cy="${y}" r="${MARK}" fill="${ink.ink}" pointer-events="none"/>`
        + `<text x="${x + 20 * ux}" y="${y + 20 * uy + 4}" text-anchor="middle" style="font:${FONT}" fill="${ink.ink}" pointer-events="none"`
        + ` stroke="${ink.paper}" stroke-width="3" paint-order="stroke">${text}</text>`;
    }).join("");
  }

  arrows({ drawing, q, frozen, letters, forces, largest, kick, shaking }) {
    const { ink } = this;
    const parts = [];
    forceArrows(drawing, q, frozen, forces, largest).forEach((arrow, k) => {
      if (!arrow) return;
      const { foot, vector, tip } = arrow;
      const mu = frictions(drawing)[k];
      if (mu > 0 && letters?.[k] !== "S") {
        const reach = ARROW * drawing.size / Math.hypot(1, mu);
        const edge = (side) => vector([side * mu * reach, reach]).map((v, i) => v + foot[i]);
        parts.push(`<path d="${path([edge(-1), foot, edge(1)].map((p) => this.toScreen(p)), true)}" fill="${ink.cone}" fill-opacity="0.25" stroke="${ink.cone}" stroke-opacity="0.8" pointer-events="none"/>`);
      }
      parts.push(this.arrow(foot, tip, ink.force));
    });
    if (kick) {
      parts.push(this.arrow(kick.from, kick.to, ink.kick, 3));
      // On the side of the tail that is away from the head.
      parts.push(this.text(kick.from, kick.label ?? "kick", ink.kick, kick.from[1] < kick.to[1] ? 10 + LINE : -10));
    }
    if (shaking && Math.hypot(...shaking.arrow) > 0) {
      const at = this.toWorld([60, 96]);
      const tip = shaking.arrow.map((a, i) => at[i] + a * 45 / this.scale);
      parts.push(this.arrow(at, tip, ink.kick, 3), this.text(this.toWorld([12, 46]), shaking.label, ink.kick, 0, "start"));
    }
    return parts.join("");
  }

  arrow(from, to, color, width = 2.2) {
    const [a, b] = [this.toScreen(from), this.toScreen(to)];
    const length = Math.hypot(b[0] - a[0], b[1] - a[1]);
    if (length < 2) return "";
    const [ux, uy] = [(b[0] - a[0]) / length, (b[1] - a[1]) / length];
    const head = Math.min(HEAD, length);
    const base = [b[0] - head * ux, b[1] - head * uy];
    const side = 0.42 * head;
    const wings = [[base[0] - side * uy, base[1] + side * ux], b, [base[0] + side * uy, base[1] - side * ux]];
    return `<path d="${path([a, base])}" stroke="${color}" stroke-width="${width}" pointer-events="none"/><path d="${path(wings, true)}" fill="${color}" pointer-events="none"/>`;
  }

  // A text at a place, or as near to it as the picture has room.
  text(at, text, color, dy, anchor = "middle") {
    const inside = (value, low, high) => Math.max(low, Math.min(value, high));
    const [px, py] = this.toScreen(at);
    const wide = LETTER * text.length;
    const before = anchor === "middle" ? 0.5 * wide : 0;
    const x = inside(px, EDGE + before, this.width - EDGE - wide + before);
    const y = inside(py + dy, EDGE + LINE, this.height - EDGE);
    return `<text x="${x}" y="${y}" text-anchor="${anchor}" style="font:${FONT}" fill="${color}" stroke="${this.ink.paper}" stroke-width="3" paint-order="stroke" pointer-events="none">${escaped(text)}</text>`;
  }

  // The strip of equilibrium: where the centre of mass may be above.
  region({ region, drawing }) {
    if (!region) return "";
    const { ink } = this;
    const [low, high] = limits(region);
    const [left, right] = [low, high].map((x) => Math.min(Math.max(this.toScreen([x, 0])[0], 0), this.width));
    const inside = low <= drawing.center_of_mass[0] && drawing.center_of_mass[0] <= high;
    const plumb = this.toScreen(drawing.center_of_mass);
    const bar = this.height - 8;
    // Not filled: the colours of the map below mean something.
    return `<path d="M${left} 0V${this.height}M${right} 0V${this.height}" stroke="${ink.region}" stroke-dasharray="5 4" pointer-events="none"/>`
      + `<path d="M${plumb[0]} ${plumb[1]}V${bar}" stroke="${inside ? ink.region : ink.flash}" stroke-width="1.2" stroke-dasharray="2 3" pointer-events="none"/>`
      + `<path d="M${left} ${bar}H${right}" stroke="${ink.region}" stroke-width="5" pointer-events="none"/>`
      + `<path d="M${plumb[0] - 6} ${bar + 7}L${plumb[0]} ${bar - 5}L${plumb[0] + 6} ${bar + 7}Z" fill="${inside ? ink.region : ink.flash}" stroke="${ink.paper}" pointer-events="none"/>`;
  }

  // An image over a box of the world, behind the body.
  drawMap(url, low, high) {
    if (!url) {
      this.layers.map.innerHTML = "";
      return;
    }
    const [left, top] = this.toScreen([low[0], high[1]]);
    const [right, bottom] = this.toScreen([high[0], low[1]]);
    this.layers.map.innerHTML =
      `<image href="${url}" x="${left}" y="${top}" width="${right - left}" height="${bottom - top}" preserveAspectRatio="none" style="image-rendering:pixelated"/>`;
  }

  // The picture as the text of an SVG file, without the handles.
  picture() {
    const copy = this.svg.cloneNode(true);
    copy.lastChild.remove();
    copy.setAttribute("xmlns", SVG);
    copy.setAttribute("width", this.width);
    copy.setAttribute("height", this.height);
    copy.removeAttribute("style");
    return new XMLSerializer().serializeToString(copy);
  }
}
