"""Siconos 4.4.0."""

import math
import subprocess
import sys
import tempfile
from pathlib import Path

import told

try:
    import numpy as np
    import siconos.kernel as sk
    import siconos.numerics as sn
except ImportError:
    print("siconos is not installed: skipped", file=sys.stderr)
    sys.exit(0)

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


def compiled(name, body, folder):
    """The contact functions of a scene as a library that Siconos loads as a plugin."""
    source = Path(folder, f"{name}.c")
    n, m = (3, 2) if body["friction"] else (2, 1)
    code = "#include <math.h>\n"
    for i, (a, b) in enumerate(body["arms"]):
        known = {"A": a, "B": b, "S": body["slope"], "M": m, "N": n}
        code += "".join(f"#undef {key}\n#define {key} ({value!r})\n" for key, value in known.items())
        code += CONTACT.replace("@", str(i))
    source.write_text(code)
    subprocess.run(
        ["gcc", "-O2", "-shared", "-fPIC", source, "-o", source.with_suffix(".so"), "-lm"], check=True
    )


class Model:
    def __init__(self, name, scene, end):
        body, (x, y, theta), (vx, vy, omega) = scene["body"], scene["start"]["q"], scene["start"]["v"]
        self.radius, self.end, mass = body["gyration_radius"], end, body["mass"]
        self.friction = body["friction"] > 0
        n = 3 if self.friction else 2
        m = 2 if self.friction else 1
        inertia = np.diag([mass, mass * self.radius**2, mass][:n])
        self.ds = sk.LagrangianLinearTIDS([y, theta, x][:n], [vy, omega, vx][:n], inertia)
        self.ds.setFExtPtr([-mass * told.GRAVITY, 0.0, 0.0][:n])
        self.nsds = sk.NonSmoothDynamicalSystem(0.0, 2 * end)
        self.nsds.insertDynamicalSystem(self.ds)
        e = body["restitution"]
        law = sk.NewtonImpactFrictionNSL(e, 0.0, body["friction"], 2) if self.friction else sk.NewtonImpactNSL(e)
        self.contacts = []
        for i in range(len(body["arms"])):
            relation = sk.LagrangianScleronomousR(f"{name}:gap{i}", f"{name}:jacobian{i}", f"{name}:rate{i}")
            self.contacts.append(sk.Interaction(law, relation))
            self.nsds.link(self.contacts[-1], self.ds)
        self.times, self.speeds = [], []

    def read(self, time, q, v):
        self.times.append(time)
        vx = abs(v[2]) if self.friction else 0.0
        self.speeds.append(max(abs(v[0]), abs(v[1]) * self.radius, vx))

    def event_driven(self, tol):
        sim = sk.EventDriven(self.nsds, sk.TimeDiscretisation(0.0, self.end))
        osi = sk.LsodarOSI()
        sim.insertIntegrator(osi)
        sim.insertNonSmoothProblem(sk.LCP(), sk.SICONOS_OSNSP_ED_IMPACT)
        sim.insertNonSmoothProblem(sk.LCP(), sk.SICONOS_OSNSP_ED_SMOOTH_ACC)
        sim.setToleranceED(tol)
        sim.initialize()
        q, v = self.ds.q(), self.ds.velocity()
        while sim.startingTime() < self.end:
            sim.advanceToEvent()
            sim.processEvents()
            self.read(sim.startingTime(), q, v)
        self.q, self.v = q, v

    def time_stepping(self, dt):
        steps = math.ceil(self.end / dt - 1e-6)
        sim = sk.TimeStepping(self.nsds, sk.TimeDiscretisation(0.0, self.end / steps))
        sim.insertIntegrator(sk.MoreauJeanOSI(0.5))
        problem = sk.FrictionContact(2) if self.friction else sk.LCP()
        if self.friction:
            problem.numericsSolverOptions().dparam[sn.SICONOS_DPARAM_TOL] = 1e-12
        sim.insertNonSmoothProblem(problem)
        q, v = self.ds.q(), self.ds.velocity()
        for _ in range(steps):
            sim.computeOneStep()
            sim.nextStep()
            self.read(sim.startingTime(), q, v)
        self.q, self.v = q, v
