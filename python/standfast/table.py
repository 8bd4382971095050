"""Tables as text: contact modes, verdicts and maps."""

import math
from collections.abc import Sequence
from decimal import ROUND_CEILING, ROUND_FLOOR, Context, Decimal
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

import standfast._core as sf
from standfast.units import described, plain, quantities

if TYPE_CHECKING:
    import xarray

#: Largest number of rows of a table that are printed.
ROWS = 20
#: Part of a coordinate in a direction of length 1, above which the coordinate moves. Rounding errors are some 1e-15.
MOVED = 1e-9
#: Largest acceleration of a System that holds, in those of gravity and of its forces: errors of programmes, some 1e-10.
HELD = 1e-7
#: Largest number of forces of a word that are printed.
FORCES = 3
#: Largest number of coordinates of an acceleration that are printed.
COORDINATES = 8


def counted(number: int, noun: str) -> str:
    """A count with its noun.

    >>> counted(1, "impact"), counted(3, "impact")
    ('1 impact', '3 impacts')
    """
    return f"{number} {noun}{'' if number == 1 else 's'}"


def listed(numbers: Sequence[int]) -> str:
    """Numbers in rising order; three or more consecutive ones are "first to last".

    >>> listed([2]), listed([1, 2]), listed([1, 2, 4, 5, 6, 7])
    ('2', '1 and 2', '1, 2 and 4 to 7')
    """
    runs: list[list[int]] = []
    for number in numbers:
        if runs and number == runs[-1][-1] + 1:
            runs[-1].append(number)
        else:
            runs.append([number])
    parts: list[str] = []
    for run in runs:
        parts += [f"{run[0]} to {run[-1]}"] if len(run) > 2 else map(str, run)
    return " and ".join(filter(None, [", ".join(parts[:-1]), parts[-1]]))


def contacts_named(numbers: Sequence[int]) -> str:
    """Contacts by their numbers, which are in rising order.

    >>> contacts_named([2]), contacts_named([1, 2, 3])
    ('contact 2', 'contacts 1 to 3')
    """
    return f"contact{'' if len(numbers) == 1 else 's'} {listed(numbers)}"


def system_holds(mode: sf.SystemMode) -> bool:
    """Whether no body of a mode of a System moves.

    >>> stack = sf.System([sf.Block(1, 0.5), sf.Block(1, 0.5, at=(0.3, 0.5))])
    >>> system_holds(sf.onset(stack)), system_holds(sf.onset(stack, acceleration=(9, 0)))
    (True, False)
    """
    system = mode.system
    lightest = min(body.mass for body in system.bodies.values())
    pulls = [system.gravity, float(abs(mode.forces).max(initial=0.0)) / lightest]
    still = float(abs(mode.acceleration).max()) <= HELD * max(pulls)
    return set(mode.word) <= {"F"} and still


def system_mode_in_words(mode: sf.SystemMode) -> str:
    """What a mode of a System does.

    >>> stack = sf.System([sf.Block(1, 0.5), sf.Block(1, 0.5, at=(0.6, 0.5))])
    >>> system_mode_in_words(sf.onset(stack))
    'begins to move: 1 contact opens'
    """
    if system_holds(mode):
        return "holds"
    opening = mode.word.count("S")
    sliding = len(mode.word) - opening - mode.word.count("F")
    parts: list[str] = []
    for count, verb in ((opening, "open"), (sliding, "slide")):
        if count:
            noun = "" if parts else " contact" if count == 1 else " contacts"
            parts.append(f"{count}{noun} {verb}{'s' if count == 1 else ''}")
    return f"begins to move: {', '.join(parts) or 'all contacts hold'}"


def factor_in_words(factor: sf.LoadFactor) -> tuple[str, str]:
    """What a LoadFactor says of forces, and of motion.

    >>> brick = sf.System([sf.Block(2, 1)], gravity=10)
    >>> factor_in_words(sf.load_factor(brick, acceleration=(1, 0)))
    ('forces hold up to 5 times the load', 'moves from 5 times the load on')
    >>> tower = sf.System([sf.Block(1, 1, at=(0, k)) for k in range(5)], gravity=10)
    >>> factor_in_words(sf.load_factor(tower, acceleration=(10, 0)))      # ten contacts: lesser loads were not tried
    ('forces hold up to 0.2 times the load', 'moves at 0.2 times the load')
    """
    bounded = math.isfinite(factor.static)
    limit = f"up to {factor.static:.4g} times" if bounded else "any multiple of"
    if math.isfinite(factor.moves):
        times = f"{factor.moves:.4g} times the load"
        moves = f"moves from {times} on" if factor.complete else f"moves at {times}"
    elif factor.complete:
        moves = "no contact mode moves"
    else:
        moves = "no contact mode that moves was found"
    return f"forces hold {limit} the load", moves


def side_named(contact: sf.RunContact) -> str:
    """A side of the body on a corner of the ground, in words. Sides are counted from 1.

    >>> box = sf.Posture.box(1.0, 0.5, terrain=[(-5, 0), (0, 0), (0, -5)])
    >>> side_named(sf.simulate(box, (-0.1, 0, 0), (0, 0, 0)).contacts[4])
    'side 1 on the corner of the ground at (0, 0) m'
    """
    x, y = contact.corner or (math.nan, math.nan)
    return f"side {contact.index + 1} on the corner of the ground at ({plain(x)}, {plain(y)}) m"


def without_posture(run: sf.Run) -> str:
    """What a run without a posture is of."""
    return "LocalModel" if run.mechanism is None else "Mechanism"


def mechanism_named(mechanism: sf.Mechanism) -> str:
    """A mechanism in words.

    >>> rod = sf.Posture.rod(half_length=0.5, gyration_radius=0.5)
    >>> mechanism_named(sf.Mechanism.of_posture(rod))
    '3 coordinates, 2 contacts'
    """
    words = [
        counted(mechanism.dof, "coordinate"),
        counted(len(mechanism.contacts), "contact"),
    ]
    if locked := sorted(set(mechanism.locked)):
        words.insert(1, f"{listed(locked)} of them locked (counted from 0)")
    if mechanism.armature is not None and mechanism.armature.any():
        words.append("with armature")
    return ", ".join(words)


def is_infinite(point: sf.ZenoPoint) -> bool:
    """Whether infinitely many impacts end at this point. They do not where contacts rest from the start or land without rebound."""
    return point.method != "rest" and not point.plastic


def aligned(rows: Sequence[tuple[str, ...]]) -> list[str]:
    """Rows in aligned columns; the first row is the header."""
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    return ["    " + "  ".join(map(str.ljust, row, widths)).rstrip() for row in rows]


def modes_table(modes: sf.Modes) -> str:
    """The table of contact modes: consistent words first, then the others, those that fail by least first.

    >>> ball = sf.Posture(mass=1, gyration_radius=1, center_of_mass=(0, 1), restitution=0,
    ...                   gravity=10, contacts=[sf.Contact(point=(0, 0), friction=0.5)])
    >>> print(sf.contact_modes(ball))
      contact modes (a letter for each contact: S separate, F fixed, R, L slides right, left)
        word  consistent                   acceleration / (m/s^2, rad/s^2)  forces (tangential, normal) / N
        F     yes                          (0, 0, 0)                        1: (0, 10)
        S     no: contact 1: a_n > 0 by 1  (0, -10, 0)                      none
        R     no: contact 1: a_t > 0 by 1  (-5, 0, -5)                      1: (-5, 10)
        L     no: contact 1: a_t < 0 by 1  (5, 0, 5)                        1: (5, 10)
      status  unique: F
    """
    solved = [modes[word] for word in modes]
    solved.sort(key=_failure)
    shown = max(ROWS, len(modes.consistent))
    body = isinstance(modes.problem, sf.ContactProblem)
    units = (
        (acceleration_named(body), "forces (tangential, normal) / N")
        if modes.level == "acceleration"
        else ("velocity after / (m/s, rad/s)", "impulses (tangential, normal) / (N s)")
    )
    rows = [("word", "consistent", *units)]
    rows += [_row(mode) for mode in solved[:shown]]
    lines = [
        "  contact modes (a letter for each contact: S separate, F fixed, R, L slides right, left)",
        *aligned(rows),
    ]
    if len(solved) > shown:
        left = len(solved) - shown
        none = "none of them" if left > 1 else "not"
        lines.append(f"    ... and {left} more, {none} consistent")
    if any(mode.near_degenerate for mode in solved[:shown]):
        lines.append(
            "    tie: a test holds or fails by so little that rounding may decide"
        )
    lines += [
        f"  {mode.word}  holds with any compression from {low:.6g} N to {high:.6g} N along the line"
        " between the contacts"
        for mode in solved
        if mode.consistent and mode.force_interval is not None
        for low, high in [np.add(mode.force_interval, 0.0)]
    ]
    lines += [
        f"  {mode.word}  the motion depends on how the contacts share their forces; that of the smallest is given"
        for mode in solved
        if mode.consistent and mode.determined == "undetermined"
    ]
    words = ", ".join(modes.consistent)
    lines.append(f"  status  {modes.status}{': ' if words else ''}{words}")
    lines += [
        f"  jams    contact {number} while it slides {'right' if way == 'R' else 'left'}:"
        f" friction is above {critical:.6g}"
        for number, way, margin, critical in modes.problem.jamming
        if margin <= 0.0
    ]
    if isinstance(modes.problem, sf.MechanismProblem):
        mechanism = modes.problem.mechanism
        for mode in solved:
            free = np.linalg.norm(mechanism.contact_space.b)
            if mode.consistent and np.abs(mode.acceleration).max() > STILL * free:
                begins = _begins(mode.word, mode.acceleration, mechanism, float(free))
                lines += [f"  {mode.word}  begins so:", *begins] if begins else []
        lines += _contact_names(mechanism)
    return "\n".join(lines)


#: What a contact does, by its letter.
DOES = {"S": "opens", "F": "holds", "R": "slides right", "L": "slides left"}
#: Share of the largest acceleration, with or without contact forces, below which a coordinate does not move: rounding.
STILL = 1e-9


def _begins(
    word: str,
    acceleration: npt.NDArray[np.float64],
    of: sf.Mechanism | sf.System,
    free: float,
) -> list[str]:
    """How a mode begins to move, by the names of the contacts and the coordinates, if they have names; `free` is an acceleration without contact forces."""
    lines = []
    if names := of.contact_names:
        for letter, what in DOES.items():
            if found := [n for n, own in zip(names, word, strict=True) if own == letter]:  # fmt: skip
                lines.append((what, _some(found)))
    if names := of.coordinate_names:
        least = STILL * max(np.abs(acceleration).max(), free)
        moved = [
            f"{name} {value:.4g}"
            for name, value in zip(names, acceleration, strict=True)
            if abs(value) > least
        ]
        lines.append(("accelerates", _some(moved)))
    return [f"    {what:<12}  {text}" for what, text in lines]


def system_mode_table(mode: sf.SystemMode) -> str:
    """A contact mode of a System in words.

    >>> print(sf.onset(sf.System([sf.Block(1, 1), sf.Block(1, 1, at=(0.6, 1))])))
    1 contact opens, 3 hold: the system begins to move
        opens         2 on 1 at (0.1, 1)
        holds         1 on the ground at (-0.5, 0); 1 on the ground at (0.5, 0); 2 on 1 at (0.5, 1)
        accelerates   2.x 1.15; 2.y -0.2299; 2.theta -2.299
    """
    if system_holds(mode):
        return f"{counted(len(mode.word), 'contact')}, none opens or slides: forces hold the system"
    numbers = {
        "open": mode.word.count("S"),
        "slide": mode.word.count("R") + mode.word.count("L"),
        "hold": mode.word.count("F"),
    }
    (first, count), *others = [(what, count) for what, count in numbers.items() if count]  # fmt: skip
    begun = f"{counted(count, 'contact')} {first}{'s' if count == 1 else ''}"
    rest = "".join(f", {count} {what}{'s' if count == 1 else ''}" for what, count in others)  # fmt: skip
    lines = _begins(mode.word, mode.acceleration, mode.system, mode.system.gravity)
    return "\n".join([f"{begun}{rest}: the system begins to move", *lines])


def _some(texts: Sequence[str]) -> str:
    left = len(texts) - ROWS
    return "; ".join([*texts[:ROWS], *([f"and {left} more"] if left > 0 else [])])


def _contact_names(mechanism: sf.Mechanism) -> list[str]:
    """The numbers of the contacts with their names, if they have names."""
    names = mechanism.contact_names
    lines = [f"    {k:>3}  {name}" for k, name in enumerate(names[:ROWS], start=1)]
    if len(names) > ROWS:
        lines.append(f"    ... and {len(names) - ROWS} more: mechanism.contact_names")
    return ["  contacts", *lines] if names else []


def acceleration_named(body: bool) -> str:
    """The head of a column of accelerations, of a body or of the coordinates of a mechanism."""
    return "acceleration / (m/s^2, rad/s^2)" if body else "acceleration of q"


#: What to try where no argument decides.
TRY = "try stability(posture, trials=1000): random small kicks, which are evidence and no proof"


#: Number of coordinates of the base of a mechanism, (x, y, theta); those that follow are taken as joints.
BASE = 3

#: Text of the report for each reason why a verdict has no bound on the amplification of a kick.
NO_BOUND = {
    "not-stable": "the posture is not proved stable",
    "energy": "energy does not bound the frictionless motion (lambda > 0 fails)",
    "falls": "gravity does not pull the body onto the terrain of each contact",
    "modes": "the motion after a slide or a landing is not certain",
    "cells": "the corner map does not bound the growth",
    "rounding": "the bound is above 1e300, or rounding decides whether it is finite",
    "pairs": "the bound of a pair of contacts does not hold for the whole body",
    "joints": "for contacts that slide independently only their rest is proved",
}
#: Gap of a contact that is named, because it was probably meant to touch. Unit: size of the body.
ALMOST = 1e-4
#: Amplification above which a verdict warns: displacements then grow more than 1e4 times.
WARNED = 100.0


def verdict_table(verdict: sf.Verdict) -> str:
    """A verdict on a posture, with its evidence.

    >>> rod = sf.Posture.rod(half_length=0.5, gyration_radius=0.2, restitution=0.1, friction=0.5)
    >>> print(sf.stability(rod))
      stability         stable, by theorem-3
        kinematic-strong (strict reading) and clattering converges: Theorem 3 of Or and Rimon
      equilibrium       yes: centre of mass at 0 m, region from -0.5 to 0.5 m, friction margin 1
      modes at rest (a letter for each contact: S separate, F fixed, R, L slides right, left)
        word  kinematics                                        forces  acceleration / (m/s^2, rad/s^2)  forces (tangential, normal) / N
        SS    fail at 1: a_n > 0 by 0.371, 2: a_n > 0 by 0.371  fit     (0, -9.81, 0)                    none
        SF    fail at 1: a_n > 0 by 0.64                        fit     (0, -8.4569, 16.9138)            2: (0, 1.3531)
        SR    fail at 1: a_n > 0 by 0.64, 2: a_t > 0 by 0.0256  fit     (-0.676552, -8.4569, 16.9138)    2: (-0.676552, 1.3531)
        SL    fail at 1: a_n > 0 by 0.64, 2: a_t < 0 by 0.0256  fit     (0.676552, -8.4569, 16.9138)     2: (0.676552, 1.3531)
        FS    fail at 2: a_n > 0 by 0.64                        fit     (0, -8.4569, -16.9138)           1: (0, 1.3531)
        FF    fit                                               fit     (0, 0, 0)                        1: (0, 4.905)  2: (0, 4.905)
        RS    fail at 1: a_t > 0 by 0.0256, 2: a_n > 0 by 0.64  fit     (-0.676552, -8.4569, -16.9138)   1: (-0.676552, 1.3531)
        RR    fail at 1: a_t > 0 by 0.186, 2: a_t > 0 by 0.186  fit     (-4.905, -4.35652e-15, 0)        1: (-2.4525, 4.905)  2: (-2.4525, 4.905)
        LS    fail at 1: a_t < 0 by 0.0256, 2: a_n > 0 by 0.64  fit     (0.676552, -8.4569, -16.9138)    1: (0.676552, 1.3531)
        LL    fail at 1: a_t < 0 by 0.186, 2: a_t < 0 by 0.186  fit     (4.905, -4.35652e-15, 0)         1: (2.4525, 4.905)  2: (2.4525, 4.905)
      kinematic-strong  yes, margin 0.1857; strict reading: yes; FF alone consistent: yes
      clattering        coupling 0.724138; converges: yes, margin 0.1063; endless without gravity: yes, margin 0.1492
      impact laws       newton
      amplification     at most 1.47: no later motion is faster than the kick times this
    """
    argument = "" if verdict.by is None else f", by {verdict.by}"
    lines = [f"  stability         {verdict.frictional_stability}{argument}"]
    lines.append(f"    {verdict.in_words}")
    if verdict.reason is not None and verdict.trials is None:
        lines.append(f"    {TRY}")
    lines += _jams(verdict)
    if verdict.posture is not None:
        lines += _of_posture(verdict, verdict.posture)
    if verdict.mechanism is not None:
        lines += _of_mechanism(verdict, verdict.mechanism)
    lines += (
        _on_two_contacts(verdict)
        if verdict.kinematic_margin is not None
        else _on_many_contacts(verdict)
    )
    if verdict.frictional_stability == "stable":
        lines.append(f"  impact laws       {', '.join(verdict.laws)}")
    if verdict.flight == "drift":
        lines.append(
            "  flights           end by drift: lambda < 0 at one contact, which is not hit any more after a time of the size of the kick"
        )
    if (bound := verdict.amplification) is not None:
        lines.append(
            f"  amplification     at most {_rounded_up(bound)}: no later motion is faster than the kick times this"
        )
        if bound > WARNED:
            lines.append(
                f"    warning: above {WARNED:g}; the body may move far before it rests, and the verdict holds for very"
                " small kicks only"
            )
    else:
        reason = NO_BOUND[str(verdict.amplification_reason)]
        lines.append(f"  amplification     no bound: {reason}")
    if (speed := verdict.safe_speed) is not None:
        lines.append(
            f"  safe speed        {rounded_down(speed)} m/s: in the full model the body comes back from every slower kick"
        )
    if (trials := verdict.trials) is not None:
        others = "".join(
            f", {count} {name}" for name, count in trials["others"].items()
        )
        unfelt = verdict.free_motion
        rest = "ended with all contacts at rest" if unfelt else "came to rest"
        lines.append(
            f"  trials            {counted(trials['kicks'], 'random small kick')} (seed {trials['seed']}): {trials['rest']} {rest}"
            f"{others}; evidence, no proof"
        )
        if unfelt:
            lines.append("    the motions that no contact feels are not kicked")
    if verdict.mechanism is not None and verdict.free_motion:
        lines += _free_motion(verdict.mechanism, verdict.free_motion)
    if verdict.delicate:
        lines.append(
            f"  delicate          it is decided with the numbers exactly as given, but not for all scenes within {verdict.width:g} of them"
        )
    return "\n".join(lines)


def _jams(verdict: sf.Verdict) -> list[str]:
    """The contacts that jam, each in a line, and what happens there.

    >>> foot = sf.Contact(point=(0, 0), friction=2)
    >>> rod = sf.Posture(mass=1, gyration_radius=3**-0.5, center_of_mass=(0.5, 0.75**0.5), contacts=[foot], restitution=0)
    >>> print(*_jams(sf.stability(rod)))
      jams              contact 1 while it slides left, from friction 1.34715 on
    """
    found = verdict.jams
    lines = [jam_in_words(jam) for jam in found[:ROWS]]
    if len(found) > ROWS:
        lines.append(f"... and {len(found) - ROWS} more")
    if verdict.after_jam == "impact":
        lines.append(
            "end by plastic impacts without collision, under every law of impact"
        )
    titles = ["jams", *[""] * len(lines)]
    return [f"  {title:<18}{line}" for title, line in zip(titles, lines, strict=False)]


def jam_in_words(jam: dict[str, Any]) -> str:
    """A contact that jams, or two that jam together, with the friction from which on they do.

    >>> jam_in_words({"contacts": [1, 3], "slides": "RL", "friction": [0.5, 0.25]})
    'contacts 1 and 3 only together while they slide right and left, from friction 0.5 and 0.25 on'
    """
    ways = " and ".join("right" if way == "R" else "left" for way in jam["slides"])
    friction = " and ".join(f"{value:.6g}" for value in jam["friction"])
    alone = len(jam["contacts"]) == 1
    who = "while it slides" if alone else "only together while they slide"
    return (
        f"{contacts_named(jam['contacts'])} {who} {ways}, from friction {friction} on"
    )


def _free_motion(mechanism: sf.Mechanism, count: int) -> list[str]:
    """The motions that no contact feels: the kernel of the rows of all contacts in the coordinates that are not locked."""
    free = [k for k in range(mechanism.dof) if k not in mechanism.locked]
    rows = [row for c in mechanism.contacts for row in (c.tangential, c.normal)]
    _, _, directions = np.linalg.svd(np.array(rows)[:, free])
    moved = np.abs(directions[-count:]).max(axis=0) > MOVED
    names = [k for k, part in zip(free, moved, strict=True) if part]
    every = "it goes" if count == 1 else "they go"
    return [
        f"  free motion       {counted(count, 'motion')} that no contact feels, of coordinate{'s' if len(names) > 1 else ''} {listed(names)}"
        f" (from 0): after a kick {every} on for ever at constant speed",
        "    the verdict is about the contacts: whether all of them are at rest from some time on",
    ]


def _size(posture: sf.Posture) -> float:
    """The largest distance of a contact from the centre of mass, in m."""
    return max(
        math.dist(contact.point, posture.center_of_mass) for contact in posture.contacts
    )


def _of_posture(verdict: sf.Verdict, posture: sf.Posture) -> list[str]:
    """The contacts and the equilibrium of a body."""
    lines = []
    own, sides = posture.contacts, posture.side_contacts
    if len(own) + len(sides) > len(verdict.contacts):
        lines.append(
            f"  contacts          {listed(verdict.contacts)} touch; the others have no effect on small motions"
        )
        lines += [
            f"  contact {number:<9} is {gap:.3g} m above the ground: almost on it, but not on it"
            for number, gap in enumerate(posture.gaps((0, 0, 0)), start=1)
            if number not in verdict.contacts and 0 < gap < ALMOST * _size(posture)
        ]
    for number, side in enumerate(sides, start=len(own) + 1):
        place = ", ".join(plain(x) for x in side.point)
        lines.append(
            f"  contact {number:<9} is a side of the body on the corner of the ground at ({place}) m"
        )
    where = f"centre of mass at {plain(posture.center_of_mass[0], '.6g')} m, "
    region = verdict.equilibrium_region
    where += (
        "region empty"
        if region is None
        else f"region from {region[0]:.6g} to {region[1]:.6g} m"
    )
    spare = sf.friction_margin(posture)
    if spare >= 0:
        where += f", friction margin {spare:.3g}"
    lines.append(f"  equilibrium       {_yes(verdict.equilibrium)}: {where}")
    return lines


def _of_mechanism(verdict: sf.Verdict, mechanism: sf.Mechanism) -> list[str]:
    """The coordinates and the equilibrium of a mechanism, and its verdicts with joints locked."""
    space = mechanism.contact_space
    lines = [
        f"  mechanism         {mechanism_named(mechanism)}; rank {space.rank} of the contacts",
        f"  equilibrium       {_yes(verdict.equilibrium)}",
    ]
    if not verdict.equilibrium:
        lines[-1] += (
            ": no contact forces balance the load; it contains the torques of the joints and minus the bias h"
        )
    lines += _contact_names(mechanism)
    joints = sorted(set(range(BASE, mechanism.dof)) - set(mechanism.locked))
    # The coordinates of the bodies of an assembly are no joints.
    several = sum(name.endswith(".theta") for name in mechanism.coordinate_names) > 1
    if not joints or not verdict.equilibrium or several:
        return lines
    title = "joints            "
    every = [*joints] if len(joints) > 1 else []
    for chosen in [every, *([joint] for joint in joints[:ROWS])]:
        if chosen and (text := _with_locked(mechanism, chosen, verdict.after_jam)):
            lines.append(f"  {title:<18}{text}")
            title = ""
    return lines


def _with_locked(mechanism: sf.Mechanism, joints: Sequence[int], jams: str) -> str:
    """The verdict with more coordinates locked; empty if they cannot be locked."""
    try:
        locked = sf.Mechanism(
            mechanism.mass_matrix,
            mechanism.load,
            mechanism.contacts,
            restitution=mechanism.restitution,
            locked=sorted({*mechanism.locked, *joints}),
            armature=mechanism.armature,
        )
        verdict = sf.stability(locked, jams="impact" if jams == "impact" else "none")
    except ValueError:
        return ""
    argument = "" if verdict.by is None else f", by {verdict.by}"
    names = f"coordinate{'' if len(joints) == 1 else 's'} {listed(joints)}"
    return f"with {names} locked: {verdict.frictional_stability}{argument}"


def _on_two_contacts(verdict: sf.Verdict) -> list[str]:
    return [
        "  modes at rest (a letter for each contact: S separate, F fixed, R, L slides right, left)",
        *aligned(
            [
                (
                    "word",
                    "kinematics",
                    "forces",
                    acceleration_named(verdict.posture is not None),
                    "forces (tangential, normal) / N",
                ),
                *(
                    _tests(verdict.modes[word], verdict.contacts)
                    for word in verdict.modes
                ),
            ]
        ),
        *(
            ["  the paper's conditions, sufficient but not necessary:"]
            if verdict.frictional_stability == "stable" and verdict.by != "theorem-3"
            else []
        ),
        f"  kinematic-strong  {_yes(verdict.kinematic_strong)}, margin {verdict.kinematic_margin:.4g};"
        f" strict reading: {_yes(verdict.kinematic_strong_strict)}; FF alone consistent:"
        f" {_yes(verdict.unambiguous)}",
        f"  clattering        coupling {verdict.coupling:.6g}; converges: {_yes(verdict.clattering)},"
        f" margin {verdict.clattering_margin:.4g}; endless without gravity: {_yes(verdict.chatter)},"
        f" margin {verdict.chatter_margin:.4g}",
    ]


def _on_many_contacts(verdict: sf.Verdict) -> list[str]:
    """The rays on which exactly two contacts stay closed, and the verdicts on their pairs."""
    lines = []
    evidence = verdict.evidence
    rays = evidence.get("rays", []) if isinstance(evidence, dict) else []
    if rays:
        lines.append(
            "  rays (two contacts stay closed while the others open; a displacement of length 1 m)"
        )
        pairs = {tuple(pair.contacts): pair for pair in verdict.pairs}
        rows = [("contacts", "(x, y, theta) / (m, m, rad)", "y", "alone, the pair")]
        for ray in rays:
            pair = pairs.get(tuple(ray["contacts"]))
            alone = (
                "does not hold the body"
                if pair is None
                else f"holds it: {pair.frictional_stability}"
                + ("" if pair.by is None else f", by {pair.by}")
            )
            rise = "ascends" if ray["direction"][1] > 0 else "descends"
            direction = _vector(np.array(ray["direction"]))
            rows.append((listed(ray["contacts"]), direction, rise, alone))
        lines += aligned(rows)
    elif isinstance(evidence, dict) and evidence.get("pairs"):
        (pair,) = evidence["pairs"]
        lines.append(
            f"  line              contacts {listed(pair['contacts'])} carry those between them, alone: "
            f"{pair['frictional_stability']}, by {pair['by']}"
        )
    largest = evidence.get("largest", []) if isinstance(evidence, dict) else []
    if largest:
        text = ", ".join(
            f"{number}: {force:.6g}"
            for number, force in zip(verdict.contacts, largest, strict=True)
            if force > 0
        )
        lines.append(
            f"  gaps              at most E/force for ever, E the energy of the kick; largest forces without friction / N: {text}"
        )
        if level := evidence["level"]:
            lines.append(
                f"  levels            {counted(level, 'slide')} on a level, which friction ends"
            )
    if verdict.stays:
        lines.append(
            f"  stays             within {verdict.radius(1.0):.4g} m for each joule of the kick (largest of |x|, |y|, rho |theta|)"
        )
    return lines


def _rounded_up(value: float) -> str:
    """The value rounded up to three digits.

    >>> _rounded_up(1.0), _rounded_up(1.23001), _rounded_up(1234.0)
    ('1', '1.24', '1240')
    """
    exact = Decimal(value)
    return f"{float(Context(prec=3, rounding=ROUND_CEILING).plus(exact)):.6g}"


def rounded_down(value: float) -> str:
    """The value rounded down to three digits.

    >>> rounded_down(1.0), rounded_down(1.23999)
    ('1', '1.23')
    """
    exact = Decimal(value)
    return f"{float(Context(prec=3, rounding=ROUND_FLOOR).plus(exact)):.6g}"


def _yes(answer: bool | None) -> str:
    return "yes" if answer else "no"


def _tests(
    mode: sf.ContactMode, numbers: Sequence[int]
) -> tuple[str, str, str, str, str]:
    """A row for a word at rest, with separate columns for its kinematic tests and its force tests. `numbers`: of the contacts that touch."""
    if mode.determined == "impossible":
        return mode.word, "no motion", "", "", ""
    words = {}
    for kind in ("a_", "f_"):
        failed = [
            f"{numbers[number - 1]}: {test} by {abs(value):.3g}"
            for number, test, value in mode.margins
            if kind in test and f"contact {number}: {test}" in mode.violated
        ]
        words[kind] = f"fail at {', '.join(failed)}" if failed else "fit"
    return (
        mode.word,
        words["a_"],
        words["f_"],
        _vector(mode.acceleration),
        _forces(mode.forces, numbers),
    )


def _failure(mode: sf.ContactMode) -> tuple[bool, bool, float]:
    """Sort key: how far a word is from being consistent; 0 for consistent words."""
    worst = min((value for _, _, value in mode.margins), default=0.0)
    return (
        not mode.consistent,
        mode.determined == "impossible",
        0.0 if mode.consistent else -worst,
    )


def _row(mode: sf.ContactMode) -> tuple[str, str, str, str]:
    tie = ", tie" if mode.near_degenerate else ""
    if mode.determined == "impossible":
        return mode.word, "no: no forces lead to it", "", ""
    if mode.consistent:
        verdict = "yes"
    else:
        failed = set(mode.violated)
        number, test, value = min(
            (m for m in mode.margins if f"contact {m[0]}: {m[1]}" in failed),
            key=lambda m: m[2],
        )
        verdict = f"no: contact {number}: {test} by {abs(value):.3g}"
        if len(failed) > 1:
            verdict += f", and {len(failed) - 1} more"
    return mode.word, verdict + tie, _vector(mode.acceleration), _forces(mode.forces)


def _forces(
    forces: npt.NDArray[np.float64], numbers: Sequence[int] | None = None
) -> str:
    """The forces that are not zero, with the numbers of their contacts: from 1 on, if none are given."""
    named = zip(numbers or range(1, len(forces) + 1), forces, strict=True)
    acting = [f"{i}: {_vector(f)}" for i, f in named if f.any()]
    if len(acting) > FORCES:
        acting[FORCES:] = [f"and {len(acting) - FORCES} more"]
    return "  ".join(acting) or "none"


def _vector(values: npt.NDArray[np.float64]) -> str:
    texts = [plain(value, ".6g") for value in values]
    if len(texts) > COORDINATES:
        texts[COORDINATES:] = ["..."]
    return f"({', '.join(texts)})"


def robustness_table(result: sf.Robustness) -> str:
    """The kicks that a posture withstands, by their size.

    >>> box = sf.Posture.box(0.3, 0.5, friction=0.5, restitution=0.3)
    >>> print(robustness_table(sf.robustness(box, [0.1, 3.0], trials=200)))
      kicks  200 of each size, in random directions (seed 0); model full, impact moreau
      back   at rest on contacts 1 and 2 and no others, on the same ground, turned by less than a quarter turn
        size / (m/s)  relative size  back  interval of 95 %   at rest  largest displacement / m  other outcomes
        0.1           0.05913        200   98.12 to 100.00 %  200      0.001241                  none
        3             1.774          50    19.51 to 31.43 %   200      1.177                     none
    """
    options = result.options
    rows = [
        (
            "size / (m/s)",
            "relative size",
            "back",
            "interval of 95 %",
            "at rest",
            "largest displacement / m",
            "other outcomes",
        )
    ]
    for k, size in enumerate(result.sizes):
        low, high = result.interval[k]
        moved = result.largest_displacement[k]
        others = [
            f"{counts[k]} {outcome}"
            for outcome, counts in result.outcomes.items()
            if outcome != "rest" and counts[k] > 0
        ]
        rows.append(
            (
                f"{size:.6g}",
                f"{result.relative_sizes[k]:.4g}",
                str(int(result.returned[k].sum())),
                f"{100 * low:.2f} to {100 * high:.2f} %",
                str(result.rest[k]),
                "none is back" if np.isnan(moved) else f"{moved:.4g}",
                ", ".join(others) or "none",
            )
        )
    return "\n".join(
        [
            f"  kicks  {result.trials} of each size, in random directions (seed {result.seed}); model {options['model']},"
            f" impact {options['impact']}",
            f"  back   at rest on {contacts_named(result.contacts)} and no others, on the same ground, turned by less than a quarter turn",
            *aligned(rows),
        ]
    )


def map_table(grid: "xarray.Dataset") -> list[str]:
    """A map in numbers: the range of each parameter, and for each quantity how many points have which value."""
    lines = []
    for path, values in grid.coords.items():
        text, unit = described(str(path))
        low, high = float(values.min()), float(values.max())
        lines.append(
            f"  over     {text}: {counted(values.size, 'value')} from {plain(low)} to {plain(high)} {unit}".rstrip()
        )
    for name in quantities(grid):
        values = grid[name].values
        lines.append(f"  {described(name)[0]}")
        if values.dtype.kind == "f":
            known = values[np.isfinite(values)]
            rows = [("from", "to", "points")]
            ends = (known.min(), known.max()) if known.size else (np.nan, np.nan)
            rows.append((plain(ends[0]), plain(ends[1]), str(known.size)))
            rows += [
                (what, "", str(int(count)))
                for what, count in (
                    ("inf", np.isposinf(values).sum()),
                    ("-inf", np.isneginf(values).sum()),
                    ("nan", np.isnan(values).sum()),
                )
                if count
            ]
        else:
            words = np.where(values, "yes", "no") if values.dtype == bool else values
            found, counts = np.unique(words, return_counts=True)
            rows = [("", "points", "share")]
            rows += [
                (str(word), str(count), f"{100 * count / values.size:.2f} %")
                for word, count in sorted(
                    zip(found, counts, strict=True), key=lambda pair: -pair[1]
                )
            ]
        lines.extend(aligned(rows))
    return lines
