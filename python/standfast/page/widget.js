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
  // While the scene of the model is on its way into the page, the page has an older one, which does not go back.
  let opening = 0;
  const give = () => {
    if (opening || !explorer.scene) return;
    model.set("_scene", JSON.parse(JSON.stringify(explorer.scene)));
    model.save_changes();
  };
  const follow = async () => {
    const scene = model.get("_scene");
    if (!scene || JSON.stringify(scene) === JSON.stringify(explorer.scene)) return;
    opening += 1;
    await explorer.open(scene);
    opening -= 1;
    give();
  };
  explorer.onchange = give;
  model.on("change:_scene", follow);
  return () => {
    model.off("change:_scene", follow);
    explorer.player.pause();
  };
}
