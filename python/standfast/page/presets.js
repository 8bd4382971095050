// Scenes to begin with, in the form of the scene files.

const ground = { gravity: 9.81, restitution: 0.1 };
const box = (width, height, x = 0, y = 0) => [[x - width / 2, y], [x + width / 2, y], [x + width / 2, y + height], [x - width / 2, y + height]];
const corners = (points, friction) => points.map((point) => ({ point, friction }));

// A box on level ground, with the middle of its lower side at x.
function block(width, height, friction, x = 0) {
  const outline = box(width, height, x);
  return { body: { mass: 1, gyration_radius: Math.hypot(width, height) / Math.sqrt(12), center_of_mass: [x, height / 2], outline }, contact: corners(outline, friction) };
}

export const PRESETS = {
  "Legs on two slopes": {
    ...ground,
    body: { mass: 1, gyration_radius: 0.4, center_of_mass: [0.1, 0.9] },
    contact: [{ point: [-1, 0.5333333333333333], slope: -0.4899573262537283, friction: 0.5 }, { point: [1, 0.5333333333333333], slope: 0.4899573262537283, friction: 0.5 }],
    kick: [{ time: 0, impulse: [1.2, 0.8] }],
  },
  "A box and a push": { ...ground, restitution: 0.2, ground: "shared", ...block(1, 1.6, 0.6), kick: [{ time: 0, impulse: [1.6, 0], point: [-0.5, 1.4] }] },
  "Clattering rod": {
    ...ground,
    body: { mass: 1, gyration_radius: 0.2, center_of_mass: [0, 0] },
    contact: [{ point: [-0.5, 0], friction: 0.5 }, { point: [0.5, 0], friction: 0.5 }],
    start: { q: [0, 0.011, 0.0020000013333345333] },
    run: { model: "full" },
  },
  "Box over a table edge": {
    ...ground,
    terrain: [[-5, 0], [0, 0], [0, -2], [5, -2]],
    ...block(1, 0.5, 0.5, 0.01),
  },
  "Bouncing ball": {
    gravity: 9.81,
    restitution: 0.7,
    body: { mass: 1, gyration_radius: 0.3, center_of_mass: [0, 0.4] },
    contact: [{ point: [0, 0] }],
    start: { q: [0, 1, 0] },
  },
  "Ball with backspin": {
    gravity: 9.81,
    restitution: 0.5,
    ground: "shared",
    body: { mass: 1, gyration_radius: 0.3 * Math.SQRT1_2, center_of_mass: [0, 0.3] },
    contact: [{ point: [0, 0], radius: 0.3, friction: 0.3 }],
    start: { q: [0, 0.4, 0], qdot: [2, 0, 20] },
    run: { stop: "time", time_limit: 4 },
  },
  "Three feet": {
    ...ground,
    body: { mass: 1, gyration_radius: 0.4, center_of_mass: [0.1, 0.5] },
    contact: [{ point: [-0.6, 0], friction: 0.5 }, { point: [0, 0], friction: 0.5 }, { point: [0.6, 0.2], slope: 0.3, friction: 0.5 }],
  },
  "Ladder at a wall": {
    ...ground,
    restitution: 0,
    body: { mass: 10, gyration_radius: 1.15, center_of_mass: [0.85, 1.8] },
    contact: [{ point: [0, 0], friction: 0.4 }, { point: [1.7, 3.6], slope: 1.5707963267948966, friction: 0.2 }],
  },
  "Box on stairs": {
    gravity: 9.81,
    restitution: 0.2,
    terrain: [[-3, 1.2], [0, 1.2], [0, 0.8], [0.8, 0.8], [0.8, 0.4], [1.6, 0.4], [1.6, 0], [6, 0]],
    body: { mass: 2, gyration_radius: 0.2041241452319315, center_of_mass: [-1, 1.45], outline: box(0.5, 0.5, -1, 1.2) },
    contact: corners(box(0.5, 0.5, -1, 1.2), 0.3),
    start: { qdot: [3, 0, 0] },
    run: { impact: "chatterjee-ruina", time_limit: 20 },
  },
  "Shaking ground": {
    ...ground,
    ground: "shared",
    ...block(0.5, 2, 0.7),
    ground_motion: { times: [0.2, 0.5, 0.8, 1.1], acceleration: [[5, 0], [-7, 0], [5, 0], [0, 0]] },
  },
};
