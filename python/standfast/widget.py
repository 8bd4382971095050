"""The explorer as a widget of a notebook. Needs anywidget."""

import json
from typing import Any

import anywidget
import traitlets

from standfast._core import Posture, Scene, ask
from standfast.colors import COLORS
from standfast.page import EXPLORER, PATIENCE, data, script, style


class Widget(anywidget.AnyWidget, metaclass=traitlets.MetaHasTraits):
    """The explorer in a cell. See `explore`."""

    _esm = f"""{script((*EXPLORER, "widget.js"))}
export default {{ render: ({{ model, el }}) => cell(model, el, {data(COLORS)}) }};
"""
    _css = style()

    #: The scene that the cell shows, as an object in the form of the scene files; None: the page has not chosen its example yet.
    _scene = traitlets.Dict(None, allow_none=True).tag(sync=True)

    def __init__(self, scene: object = None):
        super().__init__(_scene=None if scene is None else written(scene))
        self.on_msg(self._answer)

    def _answer(self, _: object, content: Any, buffers: object) -> None:
        """Answers a question of the page: {"id", "question"} by {"id", "answer"}."""
        answer = ask(content["question"], seconds=PATIENCE)
        self.send({"id": content["id"], "answer": answer})

    @property
    def scene(self) -> Scene:
        """The scene that the cell shows."""
        if self._scene is None:
            raise ValueError("the cell has not been shown yet")
        return Scene.from_json(json.dumps(self._scene))

    @scene.setter
    def scene(self, scene: Scene) -> None:
        self._scene = written(scene)

    @property
    def posture(self) -> Posture:
        """The posture that the cell shows."""
        return self.scene.posture

    @posture.setter
    def posture(self, posture: Posture) -> None:
        self._scene = written(posture)


def written(scene: object) -> dict[str, Any]:
    """A scene, or a posture at rest, as an object in the form of the scene files."""
    if isinstance(scene, Posture):
        scene = Scene(scene, q=(0, 0, 0), qdot=(0, 0, 0))
    if not isinstance(scene, Scene):
        raise TypeError(
            f"scene = {scene!r} cannot be used: a Posture or a Scene is needed"
        )
    answer: dict[str, Any] = json.loads(scene.to_json())
    return answer
