"""Which pulses overturn a block: frequency and amplitude of one cycle of a sine, 24 × 24, and 40 of them again by scipy.

A rigid block on a floor that is shaken by one cycle of a sine rocks about its corners, overturns, or comes back. Above the edge of the region
that overturns there are safe islands: the second half of a pulse may throw a block back. `python examples/overturning_spectrum.py` draws
overturning_spectrum.png, and prints the times of both. Needs scipy (extra `map`) and matplotlib (extra `plot`).
"""

import math
import time
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
import numpy.typing as npt
import standfast as sf
from matplotlib.colors import ListedColormap
from scipy.integrate import solve_ivp
from standfast.colors import COLORS

G = 9.81
WIDTH, HEIGHT = 0.6, 2.4
#: Slope of the line from a corner to the centre of mass, and Housner's p² = 3g/(4R), in 1/s².
SLENDER = math.atan(WIDTH / HEIGHT)
P2 = 3 * G / (2 * math.hypot(WIDTH, HEIGHT))
#: The block rocks without slip.
FRICTION = 1.0
#: Constant accelerations in one cycle of the sine.
STEPS = 48
#: Frequencies in Hz; amplitudes over the least one at which the block rocks, g tan α.
FREQUENCIES = np.linspace(0.3, 3.0, 24)
AMPLITUDES = np.linspace(0.5, 6.0, 24)
#: Points that scipy computes again.
POINTS = 40

Floats = npt.NDArray[np.float64]


def pulse(frequency: float, amplitude: float) -> sf.GroundMotion:
    """One cycle of a sine (Hz, m/s²): in each interval its mean there."""
    times = np.linspace(0, 1 / frequency, STEPS + 1)
    phase = 2 * np.pi * np.linspace(0, 1, STEPS + 1)
    means = (np.cos(phase[:-1]) - np.cos(phase[1:])) / np.diff(phase)
    return sf.GroundMotion(times, [*(amplitude * means), 0.0])


def spectrum() -> tuple[list[sf.GroundMotion], npt.NDArray[np.bool_]]:
    """The pulses, and which of them overturn the block; rows are amplitudes."""
    block = sf.Posture.box(WIDTH, HEIGHT, friction=FRICTION, gravity=G)
    least = G * math.tan(SLENDER)
    pulses = [pulse(f, a * least) for a in AMPLITUDES for f in FREQUENCIES]
    runs = sf.simulate_many(block, (0, 0, 0), (0, 0, 0), ground_motion=pulses)
    overturned = np.abs(runs.q[:, 2]) > 1
    return pulses, overturned.reshape(len(AMPLITUDES), len(FREQUENCIES))


def overturns(motion: sf.GroundMotion) -> bool:
    """The same by scipy: Housner's equation of a block that rocks about one corner or the other without slip.

    θ'' = −p² (sin(±α − θ) − (A/g) cos(±α − θ)); an impact on the other corner leaves the part 1 − 1.5 sin²α of the rate.
    """
    kept = 1 - 1.5 * math.sin(SLENDER) ** 2
    accelerations = np.asarray(motion.acceleration)[:, 0]
    ends = [*motion.times[1:], motion.times[-1] + 60.0]
    theta, omega, side = 0.0, 0.0, 0
    for start, end, a in zip(motion.times, ends, accelerations, strict=True):
        t = start
        while t < end:
            if theta == omega == 0:
                if abs(a) <= G * math.tan(SLENDER):
                    break
                side = int(math.copysign(1, a))
            t, theta, omega, event = rock(t, end, theta, omega, side, a)
            if event == "over":
                return True
            if event == "impact":
                theta, omega, side = 0.0, omega * kept, -side
                if abs(omega) < 1e-9:
                    omega = 0.0
    return False


def rock(
    t: float, end: float, theta: float, omega: float, side: int, a: float
) -> tuple[float, float, float, str]:
    """Rocks on one corner until the end, an impact on the other corner, or a quarter of a turn."""

    def rate(_: float, state: Floats) -> list[float]:
        lean = side * SLENDER - state[0]
        return [state[1], -P2 * (math.sin(lean) - a / G * math.cos(lean))]

    def level(_: float, state: Floats) -> float:
        return float(state[0])

    def over(_: float, state: Floats) -> float:
        return abs(float(state[0])) - math.pi / 2

    level.terminal, level.direction = True, -side  # type: ignore[attr-defined]
    over.terminal = True  # type: ignore[attr-defined]
    found = solve_ivp(rate, (t, end), (theta, omega), rtol=1e-10, atol=1e-13, events=(level, over))  # fmt: skip
    impact, quarter = (len(times) > 0 for times in found.t_events)
    event = "over" if quarter else "impact" if impact else ""
    return found.t[-1], found.y[0, -1], found.y[1, -1], event


def draw(overturned: npt.NDArray[np.bool_], path: Path) -> None:
    figure, axes = plt.subplots(figsize=(4.2, 3.4), dpi=200, layout="constrained")
    colors = ListedColormap([COLORS["stable"], COLORS["unstable"]])
    axes.pcolormesh(FREQUENCIES, AMPLITUDES, overturned, cmap=colors, vmin=0, vmax=1)
    axes.set_xlabel("frequency of the pulse / Hz")
    axes.set_ylabel("amplitude / (g tan α)")
    axes.set_title("orange: the block overturns", loc="left", fontsize="medium")
    figure.savefig(path)


def main() -> None:
    begin = time.perf_counter()
    pulses, overturned = spectrum()
    own = time.perf_counter() - begin
    print(f"standfast: {overturned.size} pulses, {overturned.sum()} overturn, in {own:.2f} s")  # fmt: skip
    chosen = np.random.default_rng(0).choice(overturned.size, POINTS, replace=False)
    begin = time.perf_counter()
    same = sum(overturns(pulses[k]) == overturned.flat[k] for k in chosen)
    other = time.perf_counter() - begin
    print(f"scipy: {POINTS} of them in {other:.2f} s, {same} with the same answer")
    draw(overturned, Path("overturning_spectrum.png"))


if __name__ == "__main__":
    main()
