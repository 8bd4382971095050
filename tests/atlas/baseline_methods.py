"""The usual ways to compute a body that bounces: those of textbooks, of short scripts, and of engines with a fixed
step.

Each method is implemented as well as it can be, so that its failures are caused by the method itself.
"""

import math

import numpy as np


def bounces_on_an_absolute_clock(t, u, gravity, restitution):
    """Adds every flight to an absolute clock: number of bounces until the clock stops, and that time."""
    count = 0
    while True:
        later = t + 2 * u / gravity
        if later == t:
            return count, t
        t, u, count = later, restitution * u, count + 1


def bounces_until_slow(t, u, gravity, restitution, slow=1e-10):
    """Number of bounces until the speed is below a fixed small tolerance, and that time."""
    count = 0
    while u > slow:
        t, u, count = t + 2 * u / gravity, restitution * u, count + 1
    return count, t


def textbook_root(h, u, gravity):
    """The later root of h + ut − ½gt², by the textbook formula."""
    return (u + math.sqrt(u * u + 2 * gravity * h)) / gravity


def scan_and_bisect(gap, end, step):
    """The first change of sign on a grid, then bisection; None if there is none."""
    grid = np.arange(0.0, end, step)
    below = np.nonzero(gap(grid) < 0)[0]
    if not below.size:
        return None
    low, high = grid[max(below[0] - 1, 0)], grid[below[0]]
    for _ in range(60):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if gap(middle) > 0 else (low, middle)
    return high


def semi_implicit_euler(h, u, gravity, restitution, step, end):
    """u −= g dt; h += u dt; a gap below zero is set to zero, and the rate is reversed. The last rate, and the largest one in
    the last tenth of the time."""
    late, steps = 0.0, round(end / step)
    for k in range(steps):
        u -= gravity * step
        h += u * step
        if h < 0:
            h, u = 0.0, -restitution * u
        if k > 0.9 * steps:
            late = max(late, abs(u))
    return u, late


def moreau_jean(gaps, rates, gravity, psi, restitution, step, end):
    """Two contacts: θ = 1/2 in the gaps; once per step impulses at the closed gaps, u⁺ + e u⁻ ≥ 0 ⊥ p ≥ 0. Returns
    the last time at which a rate was above ten times its change by gravity in a step."""
    h, u, moved = list(gaps), list(rates), 0.0
    for k in range(round(end / step)):
        before = list(u)
        free = [u[i] - gravity[i] * step for i in range(2)]
        closed = [h[i] + 0.5 * step * u[i] <= 0 for i in range(2)]
        need = [-(free[i] + restitution * before[i]) for i in range(2)]
        p = _complementary(closed, need, psi)
        u = [free[i] + p[i] - psi[1 - i] * p[1 - i] for i in range(2)]
        h = [h[i] + 0.5 * step * (before[i] + u[i]) for i in range(2)]
        if max(abs(u[0]), abs(u[1])) > 10 * step * max(gravity):
            moved = (k + 1) * step
    return moved


def _complementary(closed, need, psi):
    """p ≥ 0 ⊥ p_i − ψ_j p_j − need_i ≥ 0 on the closed contacts, by trying every set."""
    both = 1 - psi[0] * psi[1]
    tries = [(0.0, 0.0), (need[0], 0.0), (0.0, need[1])]
    tries += [
        ((need[0] + psi[1] * need[1]) / both, (need[1] + psi[0] * need[0]) / both)
    ]
    for p in tries:
        slack = [p[i] - psi[1 - i] * p[1 - i] - need[i] for i in range(2)]
        if all(
            p[i] >= 0
            and (closed[i] or p[i] == 0)
            and (not closed[i] or slack[i] >= -1e-12)
            for i in range(2)
        ):
            return p
    return (0.0, 0.0)


#: Number of impacts after which a loop of restarts is stopped.
MOST = 1000


def restart_loop(h, u, gravity, restitution, limit):
    """`scipy.integrate.solve_ivp` with a terminal event, restarted after each impact with h = 0: number of impacts, time of
    the last one, and the lowest height of the motion after it."""
    from scipy.integrate import solve_ivp

    def floor(_t, y):
        return y[0]

    floor.terminal, floor.direction = True, -1
    t, y, hits = 0.0, [h, u], 0
    while hits < MOST:
        found = solve_ivp(
            lambda _t, y: [y[1], -gravity],
            (t, limit),
            y,
            events=floor,
            rtol=1e-10,
            atol=1e-12,
        )
        if found.status != 1:
            return hits, t, float(found.y[0].min())
        t, hits = found.t[-1], hits + 1
        y = [0.0, -restitution * found.y[1][-1]]
    return hits, t, 0.0


def corner_hits(psi, restitution, rates, slow):
    """Alternate impacts of two contacts that both touch, until no contact approaches or all speeds are below `slow`: their
    number, the rates, and whether the loop stopped at slow speeds."""
    u, hits = list(rates), 0
    while True:
        approaching = [i for i in range(2) if u[i] < 0]
        if not approaching:
            return hits, u, False
        if max(abs(v) for v in u) < slow:
            return hits, u, True
        i = approaching[0]
        kick = -(1 + restitution) * u[i]
        u[i] += kick
        u[1 - i] -= psi * kick
        hits += 1


def event_loop(gaps, rates, gravity, psi, restitution, most=100_000):
    """Impacts of two contacts with frozen geometry; their times of flight are added. Number of impacts until the
    time does not change any more, and that time."""
    h, u, t = list(gaps), list(rates), 0.0
    for hits in range(most):
        flights = [
            (u[i] + math.sqrt(u[i] * u[i] + 2 * gravity[i] * h[i])) / gravity[i]
            for i in range(2)
        ]
        i = 0 if flights[0] < flights[1] else 1
        dt = flights[i]
        if t + dt == t:
            return hits, t
        t += dt
        for j in range(2):
            h[j] = max(h[j] + dt * (u[j] - 0.5 * gravity[j] * dt), 0.0)
            u[j] -= gravity[j] * dt
        h[i] = 0.0
        kick = -(1 + restitution) * u[i]
        u[i] += kick
        u[1 - i] -= psi[i] * kick
    return most, t


def friction_by_sign(v, friction, gravity, step, steps, pull=0.0):
    """v −= (pull + μ g sign(v)) dt: the final speed, the number of its changes of sign, and the distance."""
    turns, x = 0, 0.0
    for _ in range(steps):
        before = v
        v -= (pull + friction * gravity * math.copysign(1.0, v)) * step
        turns, x = turns + (v * before < 0), x + v * step
    return v, turns, x


#: Number of steps after which a loop is stopped.
STEPS = 1_000_000


def steps_until_slow(v, pull, step, slow):
    """A block that is pulled, in steps until it is slower than a tolerance: its speed, and the number of steps."""
    steps = 0
    while abs(v) > slow and steps < STEPS:
        v, steps = v + pull * step, steps + 1
    return v, steps


def on_a_line(v, gravity, step, end):
    """Slides along the line y = 0, without regard to the terrain: final x and height."""
    x = h = u = 0.0
    for _ in range(round(end / step)):
        u -= gravity * step
        x, h = x + v * step, h + u * step
        if h < 0:
            h = u = 0.0
    return x, h


def static_force(b, rho, gravity):
    """Normal force per unit mass for zero acceleration of a contact of arm b, with velocities neglected."""
    return gravity / (1 + b * b / rho**2)


def impacts_up_to_scale(state, gravity, psi, restitution, sqrt=math.sqrt):
    """Endless impacts of a level rod with equal ends. The state after an impact is (v, y) = (u_b/u_a, h_b/u_a²),
    with a the end that was hit. Speeds are in units of u_a after the last impact. Returned for each impact: (v,
    y), the factor of u_a, and the time since the last impact, in units of u_a before this impact."""
    v, y = state
    kept = (1 + restitution) * psi
    while True:
        landing = sqrt(v * v + 2 * gravity * y)
        t, back = (v + landing) / gravity, 2 / gravity
        if t < back:
            f = restitution * landing
            v, y = 1 - gravity * t - kept * landing, t * (1 - gravity * t / 2)
        else:
            t, f = back, restitution
            v, y = v - gravity * t - kept, y + t * (v - gravity * t / 2)
        v, y = v / f, y / (f * f)
        yield (v, y), f, t


def impacts_until_gravity_is_negligible(
    state, gravity, psi, restitution, share, most=1_000_000
):
    """The ratio ε = 2gh/u² decreases from impact to impact. Number of impacts until ε has decreased to this part of
    its first value, and the part that is reached. Stops after `most` impacts."""
    first, count = None, 0
    for (v, y), _, _ in impacts_up_to_scale(state, gravity, psi, restitution):
        now = 2 * gravity * y / (v * v)
        first, count = first or now, count + 1
        if now < share * first or count == most:
            return count, now / first
    return None


def sum_without_gravity(state, psi, restitution):
    """Duration of the infinitely many later alternate impacts without gravity, divided by the speed of the last
    impact."""
    (v, y), p = state, (1 + restitution) * psi
    return y / (-v - 2 / (p + math.sqrt(p * p - 4 * restitution)))


def impacts_until_apart(state, gravity, psi, restitution, move, apart, most=10_000):
    """Number of impacts after which two states with relative difference `move` have the relative difference `apart`."""
    v, y = state
    pair = [
        impacts_up_to_scale(start, gravity, psi, restitution)
        for start in (state, (v * (1 + move), y))
    ]
    for count, ((one, _, _), (other, _, _)) in enumerate(zip(*pair, strict=False), 1):
        if count == most or abs(one[1] - other[1]) > apart * one[1]:
            return count
    return None


def gauss_seidel(contacts, free, rho2, order, sweeps):
    """Forces (tangential, normal) per unit mass of contacts (normal row, tangential row, friction, sliding, bias of both)
    after Gauss–Seidel sweeps in this order, and the largest change of a force in the last sweep."""
    inverse = np.array([1.0, 1.0, 1.0 / rho2])
    motion, forces, change = np.array(free, float), np.zeros((len(contacts), 2)), 0.0
    for _ in range(sweeps):
        change = 0.0
        for i in order:
            normal, tangent, friction, sliding, (bias_t, bias_n) = contacts[i]
            before = forces[i].copy()
            stiff = normal @ (inverse * normal)
            press = max(0.0, before[1] - (normal @ motion + bias_n) / stiff)
            if sliding:
                rub = -sliding * friction * press
            else:
                rub = before[0] - (tangent @ motion + bias_t) / (
                    tangent @ (inverse * tangent)
                )
                rub = min(max(rub, -friction * press), friction * press)
            forces[i] = rub, press
            kick = forces[i] - before
            motion = motion + inverse * (tangent * kick[0] + normal * kick[1])
            change = max(change, *abs(kick))
    return forces, change


def newton_with_friction(v, w, friction, restitution):
    """Routh's process at one contact, v = (tangential, normal), w = (tt, nt, nn) per unit mass, until v_n = −e v_n⁻: the
    final velocity."""
    (v_t, v_n), (tt, nt, nn), target = v, w, -restitution * v[1]
    way = math.copysign(1.0, v_t)
    stops = v_t / (way * friction * tt - nt) if v_t else 0.0
    rise = nn - way * friction * nt
    if stops < 0 or v_n + rise * stops >= target:
        p = (target - v_n) / rise
        return v_t + (nt - way * friction * tt) * p, target
    if abs(nt) <= friction * tt:
        return 0.0, target
    way = math.copysign(1.0, nt)
    p = (target - v_n - rise * stops) / (nn - way * friction * nt)
    return (nt - way * friction * tt) * p, target


def moreau_impact(v, restitution, tangential):
    """Velocity (tangential, normal) after an impact without limit of friction: both components are reversed."""
    return -tangential * v[0], -restitution * v[1]


def sliding_rod(theta, omega, arm, rho2, friction, way, gravity, step, most):
    """A body that slides on one contact, in fixed steps, with the force for zero normal acceleration: number of steps until
    this force is negative, and the forces per unit mass before and then."""
    force = math.nan
    for k in range(most):
        c, s = math.cos(theta), math.sin(theta)
        b, h = c * arm[0] - s * arm[1], s * arm[0] + c * arm[1]
        lever = b + way * friction * h
        before, force = force, (gravity + h * omega**2) / (1 + b * lever / rho2)
        if force < 0:
            return k, before, force
        omega += lever * force / rho2 * step
        theta += omega * step
    return most, before, force


def friction_smoothed(v, friction, gravity, slow, step, steps):
    """v −= μ g tanh(v/slow) dt: the largest speed."""
    largest = abs(v)
    for _ in range(steps):
        v -= friction * gravity * math.tanh(v / slow) * step
        largest = max(largest, abs(v))
    return largest


def on_the_ground(ground, v, gravity, step, end):
    """Slides along y = ground(x). After each step it is put back on the ground if it is within 2 v dt above. Its final height
    above the ground."""
    x, y, fall = 0.0, ground(0.0), 0.0
    for _ in range(round(end / step)):
        fall -= gravity * step
        x, y = x + v * step, y + fall * step
        if y - ground(x) < 2 * v * step:
            y, fall = ground(x), 0.0
    return y - ground(x)


def in_a_valley(s, pull, kept, step, end):
    """A foot on two slopes, s the distance along either of them, semi-implicit; each passage of the vertex multiplies its
    speed by `kept`. Its largest speed in the last tenth of the time."""
    v, late, steps = 0.0, 0.0, round(end / step)
    for k in range(steps):
        v -= math.copysign(pull, s) * step
        before, s = s, s + v * step
        if before * s < 0:
            v *= kept
        if k > 0.9 * steps:
            late = max(late, abs(v))
    return late


def speed_by_energy(mass, gravity, height):
    """√(2E/m), E = mgh."""
    return math.sqrt(2 * (mass * gravity * height) / mass)


def landing_by_solve_ivp(gap, end):
    """The first event h = 0 that `scipy.integrate.solve_ivp` finds in the integration of the fall; None if it finds none."""
    from scipy.integrate import solve_ivp

    def floor(t, _y):
        return gap(t)

    floor.terminal, floor.direction = True, -1
    found = solve_ivp(
        lambda _t, _y: [1.0], (0.0, end), [0.0], events=floor, rtol=1e-10, max_step=1e-3
    )
    return float(found.t_events[0][0]) if found.t_events[0].size else None


def sequential_impulses(psi, rates, sweeps):
    """Two closed contacts without restitution, with impulses one after the other for some sweeps: their rates."""
    u = list(rates)
    for _ in range(sweeps):
        for i in range(2):
            kick = max(0.0, -u[i])
            u[i] += kick
            u[1 - i] -= psi * kick
    return u


@np.errstate(all="ignore")
def steps_along_a_wedge(slide, contact, end, step, most):
    """Classical Runge–Kutta steps with the forces at two contacts, from rest: time at which this contact has moved by `end`
    along its ground, by quadratic interpolation within the last step; None if it does not."""

    def rate(y):
        return np.concatenate([y[3:], slide.acceleration_by_forces(y[2], y[5])])

    slope, (p, q) = float(slide.slopes[contact]), map(float, slide.arms[contact])
    y, t, way = np.zeros(6), 0.0, 0.0
    for _ in range(most):
        one = rate(y)
        two = rate(y + step / 2 * one)
        three = rate(y + step / 2 * two)
        four = rate(y + step * three)
        y = y + step / 6 * (one + 2 * two + 2 * three + four)
        (x, h, theta), before = y[:3], way
        x += (math.cos(theta) - 1) * p - math.sin(theta) * q
        h += math.sin(theta) * p + (math.cos(theta) - 1) * q
        way = abs(math.cos(slope) * x + math.sin(slope) * h)
        if not way < end:
            return t + step * (math.sqrt(end) - math.sqrt(before)) / (
                math.sqrt(way) - math.sqrt(before)
            )
        t += step
    return None
