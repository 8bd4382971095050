"""The film at the top of the site: one throw of a box, exact and by an engine with steps of 1/60 s (pymunk, extra `peers`).

`python site/beside_an_engine.py` draws docs/beside_an_engine.gif and prints the largest errors of the engine, for shorter steps too. The engine has the law of impact of the
run: Moreau's, contact by contact. Its collision_slop is 0 (the default, 0.1, is a length for pictures in pixels); all other
settings are its own. Its world starts with the same numbers.
"""

import math
from pathlib import Path

import numpy as np
import numpy.typing as npt
import pymunk
import standfast as sf
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from standfast.film import Gif

DOCS = Path(__file__).parents[1] / "docs"
WIDTH, HEIGHT = 0.3, 0.5
START, VELOCITY = (0, 0.6, 0.4), (1.5, 0.5, -3)
FRAME = 1 / 60
#: The centre of mass of the box that stands, m, and its angle.
STANDING = np.array([0, HEIGHT / 2, 0])
#: Frames of the film per second, seconds of motion per second of film, and where it ends, s.
FPS, SPEED, END = 20, 0.4, 2.3
BLUE, ORANGE = "#0072B2", "#D55E00"


def engine(step: float) -> npt.NDArray[np.float64]:
    """x, y, θ of the centre of mass after each step, the start first."""
    space = pymunk.Space()
    space.gravity, space.collision_slop = (0, -9.81), 0
    body = pymunk.Body(1, (WIDTH**2 + HEIGHT**2) / 12)
    body.position, body.angle = (START[0], START[1] + HEIGHT / 2), START[2]
    body.velocity, body.angular_velocity = VELOCITY[:2], VELOCITY[2]
    box = pymunk.Poly.create_box(body, (WIDTH, HEIGHT))
    floor = pymunk.Poly(space.static_body, [(-9, 0), (-9, -9), (9, -9), (9, 0)])
    box.friction, box.elasticity = 0.5, 0.3
    floor.friction, floor.elasticity = 1, 1
    space.add(body, box, floor)
    states = [(*body.position, body.angle)]
    for _ in range(math.ceil(END / step)):
        space.step(step)
        states.append((*body.position, body.angle))
    return np.array(states)


def corners(state: npt.NDArray[np.float64]) -> npt.NDArray[np.float64]:
    """The outline of the box, first corner repeated."""
    x, y, angle = state
    cos, sin = math.cos(angle), math.sin(angle)
    signs = np.array([(-1, -1), (1, -1), (1, 1), (-1, 1), (-1, -1)])
    turned = signs * (WIDTH / 2, HEIGHT / 2) @ [[cos, sin], [-sin, cos]]
    return np.add((x, y), turned)


def away(run: sf.Run, step: float) -> tuple[npt.NDArray[np.float64], ...]:
    """Distance (m) and angle (rad) of the engine from the run, at the ends of its steps, the start first."""
    states = engine(step)
    x, y, angle = (states - run.at(step * np.arange(len(states)))[0] - STANDING).T
    return np.hypot(x, y), abs(angle)


def main() -> None:
    box = sf.Posture.box(WIDTH, HEIGHT, friction=0.5, restitution=0.3)
    run = sf.simulate(box, START, VELOCITY)
    for step in (FRAME, 1e-3, 1e-4):
        distances, angles = away(run, step)
        print(
            f"step {step:.2g} s: at most {100 * distances.max():.2g} cm"
            f" and {math.degrees(angles.max()):.2g} degrees off"
        )
    stepped = engine(FRAME)
    times = FRAME * np.arange(len(stepped))
    errors = 100 * away(run, FRAME)[0]  # cm

    figure = Figure(figsize=(5.6, 4.4), dpi=100, layout="constrained")
    FigureCanvasAgg(figure)
    panels = figure.subplot_mosaic(
        [["exact", "engine"], ["error", "error"]], height_ratios=(5, 3)
    )
    left, right, lower = (panels[name] for name in ("exact", "engine", "error"))
    shapes, words = [], []
    for axes, title, color in (
        (left, "standfast: exact", BLUE),
        (right, "engine, step 1/60 s", ORANGE),
    ):
        axes.set(
            xlim=(-0.4, 1.75), ylim=(-0.12, 1.3), aspect="equal", xticks=[], yticks=[]
        )
        axes.set_title(title, color=color, fontweight="bold")
        axes.axhspan(-0.12, 0, color="0.75")
        shapes.append(
            axes.fill(
                *corners(stepped[0]).T,
                facecolor=color,
                alpha=0.5,
                edgecolor=color,
                linewidth=2,
            )[0]
        )
        words.append(axes.text(-0.33, 1.18, "", va="top", fontsize=11))
    ghost = right.plot([], [], "--", color=BLUE, linewidth=1.2)[0]
    lower.set(
        xlim=(0, END),
        ylim=(0, 1.15 * errors.max()),
        xlabel="time / s",
        ylabel="error / cm",
    )
    curve = lower.plot([], [], color=ORANGE, linewidth=2)[0]
    lower.axvline(run.time, color=BLUE, linestyle=":")
    lower.text(
        run.time - 0.03, errors.max(), "at rest", color=BLUE, ha="right", va="center"
    )

    writer = Gif(fps=FPS)
    with writer.saving(figure, str(DOCS / "beside_an_engine.gif"), dpi=100):
        for t in np.arange(0, END, SPEED / FPS):
            k = min(int(t / FRAME + 1e-9), len(stepped) - 1)
            exact = run.at(t)[0] + STANDING
            shapes[0].set_xy(corners(exact))
            shapes[1].set_xy(corners(stepped[k]))
            ghost.set_data(*corners(exact).T)
            done = np.searchsorted(run.impacts["time"], t, side="right")
            words[0].set_text(
                f"at rest at {run.time:.9f} s" if t >= run.time else f"impacts: {done}"
            )
            words[1].set_text(f"error {errors[k]:.1f} cm")
            curve.set_data(times[: k + 1], errors[: k + 1])
            writer.grab_frame()


if __name__ == "__main__":
    main()
