"""Siconos 4.4.0 (Debian's python3-siconos, under Debian's Python): event-driven, and Moreau-Jean time stepping.

Model: a Lagrangian system in (y, θ), and x with friction, with one scleronomous relation per contact, whose functions
are compiled C (gcc; a relation overridden in Python crashed). The compilation is not timed.

- Event-driven, for the scenes without friction (with the friction law it throws): LsodarOSI with its default tolerances, which
  are at roundoff, an LCP for impacts and one for accelerations. The tolerance below which a gap
  or a speed counts as zero takes several values. It has an effect on the task "rest" only; before the impacts accumulate all values give
  the same answer. Below some tolerance Siconos throws or does not end; such a run is not reported.
- Moreau-Jean with θ = 1/2, for all scenes: LCP with Newton's law, with friction FrictionContact(2) solved to 1e-12. The step is
  shortened so that it divides the requested time; but not for the task "rest", whose time would then lie on the grid by chance. In the
  scene `rocking` friction alone makes the impacts stick.

Siconos cannot express an impact on one end of the rod while the other end is held. Its LCP treats both ends at once (Moreau), and the
held end stays. In the law of the chart the ends are hit in turn, each with its own e. So the time of rest in `nested` converges to
another value: with both methods to 1.058 times the exact time of the chart.

The state is read after every event or step."""

import math
import os
import subprocess
import sys
import tempfile
import time
from functools import partial
from pathlib import Path

import harness

try:
    import numpy as np
    import siconos.kernel as sk
    from siconos.numerics import SICONOS_DPARAM_TOL
except ImportError:
    print("siconos is not installed: skipped", file=sys.stderr)
    sys.exit(0)

TOLERANCES = (1e-6, 1e-8, 1e-10, 1e-12, 1e-13, 1e-14, 1e-15)

#: Contact I with arm (A, B) over a floor of slope S, in C: y, which is the gap and, with friction, M = 2, the place along the
#: floor; its Jacobian in the N coordinates q = (y, theta, x); and the rate of the Jacobian. Matrices by columns.
CONTACT = """
static void arm@(const double *q, double *x, double *y) {
  *x = cos(q[1]) * A - sin(q[1]) * B;
  *y = sin(q[1]) * A + cos(q[1]) * B;
}
static void turned@(double x, double y, double *out) {
  out[0] = cos(S) * y - sin(S) * x;
  if (M > 1) out[1] = cos(S) * x + sin(S) * y;
}
void gap@(unsigned n, const double *q, unsigned m, double *out, unsigned k, double *z) {
  double x, y;
  arm@(q, &x, &y);
  turned@(x + (N > 2 ? q[2] : 0), y + q[0], out);
}
void jacobian@(unsigned n, const double *q, unsigned m, double *out, unsigned k, double *z) {
  double x, y;
  arm@(q, &x, &y);
  turned@(0, 1, out);
  turned@(-y, x, out + M);
  if (N > 2) turned@(1, 0, out + 2 * M);
}
void rate@(unsigned n, const double *q, unsigned l, const double *v, double *out, unsigned k, double *z) {
  double x, y;
  arm@(q, &x, &y);
  for (int j = 0; j < M * N; j++) out[j] = 0;
  turned@(-x * v[1], -y * v[1], out + M);
}
"""


def compiled(path, body):
    """The contact functions of a body as a library, which Siconos loads."""
    n, m = (3, 2) if body["friction"] else (2, 1)
    code = "#include <math.h>\n"
    for i, (a, b) in enumerate(body["arms"]):
        known = {"A": a, "B": b, "S": body["slope"], "M": m, "N": n}
        code += "".join(
            f"#undef {key}\n#define {key} ({known[key]!r})\n" for key in known
        )
        code += CONTACT.replace("@", str(i))
    source = path.with_suffix(".c")
    source.write_text(code)
    library = path.with_suffix(".so")
    subprocess.run(
        ["gcc", "-O2", "-shared", "-fPIC", source, "-o", library, "-lm"], check=True
    )


def model(path, scene, end):
    """The system with its contacts, and the body in it."""
    body, (x, y, theta), (vx, vy, omega) = (
        scene["body"],
        scene["start"]["q"],
        scene["start"]["v"],
    )
    mass, e, mu = body["mass"], body["restitution"], body["friction"]
    n = 3 if mu else 2
    inertia = np.diag([mass, mass * body["gyration_radius"] ** 2, mass][:n])
    ds = sk.LagrangianLinearTIDS([y, theta, x][:n], [vy, omega, vx][:n], inertia)
    ds.setFExtPtr([-mass * harness.GRAVITY, 0.0, 0.0][:n])
    # The last step needs an end time after it.
    system = sk.NonSmoothDynamicalSystem(0.0, 2 * end)
    system.insertDynamicalSystem(ds)
    law = sk.NewtonImpactFrictionNSL(e, 0.0, mu, 2) if mu else sk.NewtonImpactNSL(e)
    for i in range(len(body["arms"])):
        names = (f"{path}:{name}{i}" for name in ("gap", "jacobian", "rate"))
        system.link(sk.Interaction(law, sk.LagrangianScleronomousR(*names)), ds)
    return system, ds


def position(scene, q):
    """(x, y, θ) from the coordinates (y, θ) or (y, θ, x) of Siconos."""
    y, theta, *x = (float(u) for u in q)
    return [*(x or scene["start"]["q"][:1]), y, theta]


def with_events(folder, name, scene, tolerance, end):
    system, ds = model(Path(folder, name), scene, end)
    simulation = sk.EventDriven(system, sk.TimeDiscretisation(0.0, end))
    simulation.insertIntegrator(sk.LsodarOSI())
    simulation.insertNonSmoothProblem(sk.LCP(), sk.SICONOS_OSNSP_ED_IMPACT)
    simulation.insertNonSmoothProblem(sk.LCP(), sk.SICONOS_OSNSP_ED_SMOOTH_ACC)
    simulation.setToleranceED(tolerance)
    simulation.initialize()
    return simulation, ds, scene


def event_driven(simulation, ds, scene, end):
    radius, q, v = scene["body"]["gyration_radius"], ds.q(), ds.velocity()
    times, speeds, late = [], [], time.perf_counter() + harness.PATIENCE
    while simulation.startingTime() < end:
        simulation.advanceToEvent()
        simulation.processEvents()
        times.append(simulation.startingTime())
        speeds.append(max(abs(v[0]), radius * abs(v[1])))
        if time.perf_counter() > late:
            raise TimeoutError(f"no end of events at t = {times[-1]}")
    return position(scene, q), harness.settled(times, speeds)


def sweep_events(folder, name, scene):
    """Event-driven, with each tolerance until one fails."""
    for task, longer in (("before", 1.0), ("rest", 1.5)):
        if task not in scene:
            continue
        for tolerance in TOLERANCES:
            ready = partial(with_events, folder, name, scene, tolerance)
            end = longer * scene[task]["time"]
            try:
                seconds, (q, rest) = harness.timed(ready, event_driven, task, end)
            except Exception as error:
                print(
                    f"{name}, {task}, tolerance {tolerance:g}: {error}", file=sys.stderr
                )
                break
            harness.report(
                tool="Siconos 4.4.0, event-driven",
                scene=name,
                task=task,
                setting=f"tolerance = {tolerance:g}",
                parameter=tolerance,
                seconds=seconds,
                **harness.answer(name, scene, task, q, rest),
            )


def with_steps(folder, name, scene, task, dt, end):
    system, ds = model(Path(folder, name), scene, end)
    steps = math.ceil(end / dt - 1e-6)
    if task == "before":
        dt = end / steps
    simulation = sk.TimeStepping(system, sk.TimeDiscretisation(0.0, dt))
    simulation.insertIntegrator(sk.MoreauJeanOSI(0.5))
    friction = scene["body"]["friction"] > 0
    problem = sk.FrictionContact(2) if friction else sk.LCP()
    if friction:
        problem.numericsSolverOptions().dparam[SICONOS_DPARAM_TOL] = 1e-12
    simulation.insertNonSmoothProblem(problem)
    return simulation, ds


def moreau_jean(simulation, ds, scene, task, dt, end):
    friction = scene["body"]["friction"] > 0
    steps = math.ceil(end / dt - 1e-6)
    radius, q, v = scene["body"]["gyration_radius"], ds.q(), ds.velocity()
    times, speeds = [], []
    for _ in range(steps):
        simulation.computeOneStep()
        simulation.nextStep()
        times.append(simulation.startingTime())
        along = abs(v[2]) if friction else 0.0
        speeds.append(max(abs(v[0]), radius * abs(v[1]), along))
    return position(scene, q), harness.settled(times, speeds)


def main():
    # Siconos writes to the standard output; this redirects it to standard error.
    sys.stdout = os.fdopen(os.dup(1), "w")
    os.dup2(2, 1)
    with tempfile.TemporaryDirectory() as folder:
        for name, scene in harness.scenes(sys.argv[1]).items():
            compiled(Path(folder, name), scene["body"])
            if not scene["body"]["friction"]:
                sweep_events(folder, name, scene)
        harness.fixed_step(
            "Siconos 4.4.0, Moreau-Jean",
            sys.argv[1],
            partial(with_steps, folder),
            moreau_jean,
            terrain=False,
        )


if __name__ == "__main__":
    main()
