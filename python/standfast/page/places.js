// The map of the places of the centre of mass: an image with a colour for each argument of the verdict there.
import { escaped } from "./stage.js";

// Opacity of the colour of a word, on the map and in its legend. Where the body is not held the paper is seen; grey has to be told from it.
const SHARES = { "not-equilibrium": 0, undecided: 0.8 };
const SHARE = 0.5;
const share = (word) => SHARES[word] ?? SHARE;

// ask: question → promise of its answer. box: the lower left and the upper right corner in the world, m. cells: along each side; rows: of
// them in one question. valid: whether the map is still wanted. null if there is no map, or it is not wanted any more.
export async function placesMap(ask, scene, box, { cells, rows, colors, valid }) {
  const [low, high] = box;
  const middles = (axis) => Array.from({ length: cells }, (_, k) => low[axis] + (k + 0.5) / cells * (high[axis] - low[axis]));
  const [xs, ys] = [middles(0), middles(1)];
  const image = new ImageData(cells, cells);
  const words = new Set();
  for (let from = 0; from < cells; from += rows) {
    const over = [{ path: "center_of_mass.y", values: ys.slice(from, from + rows) }, { path: "center_of_mass.x", values: xs }];
    const answer = await ask({ ask: "map", scene, over, quantity: ["by"] });
    if (answer.error || !valid()) return null;
    const [{ codes, words: names }] = answer.quantity;
    codes.forEach((code, k) => {
      const word = names[code];
      words.add(word);
      // Images count rows from above.
      const place = (cells - 1 - from - Math.floor(k / cells)) * cells + k % cells;
      image.data.set([...rgb(colors[word]), Math.round(255 * share(word))], 4 * place);
    });
  }
  const canvas = document.createElement("canvas");
  [canvas.width, canvas.height] = [cells, cells];
  canvas.getContext("2d").putImageData(image, 0, 0);
  return { url: canvas.toDataURL(), box, words };
}

// The colours of the words that occur on a map, in the order of `colors`.
export function legendHtml({ words }, colors) {
  const shown = Object.keys(colors).filter((word) => words.has(word));
  return `<h3>If the centre of mass were there</h3>${shown.map((word) => `<span><i><b style="background:${colors[word]};opacity:${share(word)}"></b></i>${escaped(word)}</span>`).join("")}`;
}

const rgb = (color) => [1, 3, 5].map((k) => Number.parseInt(color.slice(k, k + 2), 16));
