// The explorer in a cell of a notebook.
import { Explorer } from "./explorer.js";
import { kernelAsk } from "./ask.js";

// Fills the cell `el` with an explorer of the scene that the model has. Either side may change the scene. Returns what ends it.
export function cell(model, el, colors) {
  // The letters that are keys of the explorer are none of the notebook while the cell has the focus.
  el.dataset.lmSuppressShortcuts = "true";
  const explorer = new Explorer(el.appendChild(document.createElement("div")), { ask: kernelAsk(model), scene: model.get("_scene"), colors, link: false });
  const theme = document.body.dataset.jpThemeLight;
  if (theme) explorer.setTheme(theme === "true" ? "light" : "dark");
  explorer.onchange = (scene) => {
    model.set("_scene", JSON.parse(JSON.stringify(scene)));
    model.save_changes();
  };
  const follow = () => {
    const scene = model.get("_scene");
    if (scene && JSON.stringify(scene) !== JSON.stringify(explorer.scene)) explorer.open(scene);
  };
  model.on("change:_scene", follow);
  return () => {
    model.off("change:_scene", follow);
    explorer.player.pause();
  };
}
