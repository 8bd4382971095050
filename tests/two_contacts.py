"""The oracle's inputs, as named in ``oracle.LOCAL_INPUTS`` and ``FULL_INPUTS``, through the package."""

import standfast as sf


def simulate_local(v):
    """Run the local model up to its first Zeno point."""
    model = sf.LocalModel(
        gravity=(v["g1"], v["g2"]),
        psi=(v["psi1"], v["psi2"]),
        phi=(v["phi1"], v["phi2"]),
        restitution=v["e"],
    )
    return model.simulate(
        gaps=(v["h1"], v["h2"]),
        rates=(v["u1"], v["u2"]),
        theta=v["theta"],
        omega=v["omega"],
        stop="zeno",
        simultaneous="first-contact-first",
    )


def simulate_full(v, **options):
    """Run the full model up to its first Zeno point."""
    contacts = [
        sf.Contact(point=(v[f"x{i}_x"], v[f"x{i}_y"]), slope=v[f"alpha{i}"])
        for i in (1, 2)
    ]
    posture = sf.Posture(
        mass=1.0,
        gyration_radius=v["rho"],
        center_of_mass=(v["x_x"], v["x_y"]),
        contacts=contacts,
        restitution=v["e"],
        gravity=v["g"],
    )
    return sf.simulate(
        posture,
        q=(v["r_x"], v["r_y"], v["theta"]),
        qdot=(v["v_x"], v["v_y"], v["omega"]),
        model="full",
        stop="zeno",
        simultaneous="first-contact-first",
        **options,
    )
