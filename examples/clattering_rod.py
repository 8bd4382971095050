"""A falling rod clatters to rest: its infinitely many impacts end at a finite time."""

import math

import standfast as sf

rod = sf.Posture.rod(half_length=0.5, gyration_radius=0.2, restitution=0.1)
run = sf.simulate(rod, q=(0, 0.011, math.asin(0.002)), qdot=(0, 0, 0), model="full")

for impact in run.impacts:
    print(f"{impact['time']:.15f} s: contact {impact['contact']} hits the floor")
zeno = run.zeno_points[0]
print(f"{zeno.time:.15f} s: contacts {zeno.contacts} are at rest ({zeno.kind})")
print(f"outcome: {run.outcome}")
