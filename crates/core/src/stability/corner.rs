//! The corner map of a two-contact posture in its local model, enclosed in intervals.
//!
//! *Corner*: contact i rests on the terrain or slides along it, and contact j lands with speed y = −u_j > 0. The velocity of the body then
//! follows from the gap rates u and from s, the speed along the direction z in which both contacts slide (N_1 z = N_2 z = 0, zᵀMz = m).
//! v_t,i is the sliding velocity of contact i:
//!
//! ```text
//! q̇ = s z + M⁻¹Nᵀ(N M⁻¹Nᵀ)⁻¹ u,   v_t,i = α_i s + Σ_j β_ij u_j,   ξ = v_t,i/α_i = s − (β_ij/α_i) y
//! ```
//!
//! Impacts without friction do not change s, and gravity changes s at a constant rate. The motion until the next Zeno point is therefore
//! the same for all corners at j, up to the scale y, and is computed once. At this Zeno point contact k rests; the other contact, m, is in
//! the air with the gap h = H y² and the gap rate u = U y. From there on all accelerations are constant, and the motion continues in one of
//! three ways:
//!
//! * m lands before k stops sliding: ξ' = ξ + B y, y' = K y;
//! * k stops sliding first, and then stays fixed (ξ' = 0) or slides back;
//! * both contacts rest at the Zeno point. They slide together until they stop, or without end, or until one of them lifts off and lands
//!   again.
//!
//! The local model has no intrinsic scale. Therefore only φ = atan(ξ/y) matters, and the growth G = r'/r of r, where r² = ξ² + y². For each
//! landing contact j the corner map is a map of an interval of φ.

use serde::{Deserialize, Serialize};
use smallvec::SmallVec;

use crate::body::Mechanism;
use crate::body::contact::{Contact, quarter_turns};
use crate::body::fields::PostureFields;
use crate::body::posture::Posture;
use crate::enclosure;
use crate::math::ball::Ball;
use crate::math::interval::Interval;
use crate::math::real::Enclosed;
use crate::options::Jams;
use crate::tolerance::TRIGONOMETRIC_ERROR;
use crate::verified::rows::{EnclosedRows, dot};
use crate::verified::{Flight, Gap, Landing, Model};

type I = Interval;

/// Constants of a posture in its local model, per unit mass.
#[derive(Debug, Clone)]
pub(crate) struct Local {
    pub(super) g: [I; 2],
    pub(super) e: [I; 2],
    pub(super) psi: [I; 2],
    mu: [I; 2],
    /// N_iM⁻¹N_jᵀ, T_iM⁻¹N_jᵀ, T_iM⁻¹T_iᵀ
    pub(super) nn: [[I; 2]; 2],
    tn: [[I; 2]; 2],
    tt: [I; 2],
    /// Tangential free acceleration T_i (0, −g, 0).
    pull: [I; 2],
    pub(crate) alpha: [I; 2],
    pub(super) beta: [[I; 2]; 2],
    /// ṡ in flight.
    pub(super) drift: I,
}

/// What the constants of two contacts follow from, see [`Local`].
struct Products {
    nn: [[I; 2]; 2],
    tn: [[I; 2]; 2],
    tt: [I; 2],
    alpha: [I; 2],
    g: [I; 2],
    pull: [I; 2],
    drift: I,
    e: [I; 2],
    mu: [I; 2],
}

/// Accelerations while one contact is closed and the other is in the air, or while both are closed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Arc {
    /// dξ/dt of the closed contact, or ds/dt if both contacts are closed; and the acceleration of the gap of the other contact.
    pub(super) along: I,
    pub(super) normal: I,
}

/// Motion from rest of a contact while the other one is in the air.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum FromRest {
    Fixed(Arc),
    /// Slides with this sign of ξ.
    Slides(i8, Arc),
    /// No mode, several modes, or the intervals do not decide.
    Unknown,
}

/// Motion with two sliding contacts.
#[derive(Debug, Clone, Copy, PartialEq)]
enum BothSlide {
    /// Both stop.
    Stops,
    /// Both never stop.
    Runs,
    /// Contact k continues to slide, the other one lifts off.
    Lifts(usize),
    /// Both lift off.
    Separate,
    /// No mode is consistent.
    Jams,
    /// Several modes, or the intervals do not decide.
    Unknown,
}

/// The start of a slide of contact k, at ξ + `from` y after a corner (ξ, y). `h`, `u`: gap and gap rate of the other contact for y = 1.
#[derive(Clone, Copy)]
struct Slide<'c> {
    k: usize,
    from: I,
    h: I,
    u: I,
    cell: &'c Cell,
}

/// A motion with contacts on the terrain in which the body moves away.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Away {
    /// Contact k slides with this sign of ξ or stays fixed (0). The other one moves off the terrain.
    Alone(usize, i8),
    /// Both contacts slide with this sign of s.
    Together(i8),
    /// Contact k continues to slide with this sign of s. The other one lifts off.
    Lifts(usize, i8),
}

/// Image of a corner.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Image {
    /// A corner at `contact`, with `slope` = ξ/y and r at most `most`.
    Corner {
        contact: usize,
        xi: I,
        y: I,
        slope: I,
        most: f64,
    },
    Rest,
    /// The body moves away and never returns.
    Escape,
    /// Not decided.
    Unknown,
}

/// Corners (ξ, y) = (sin φ, cos φ) with φ in an interval.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Cell {
    pub(crate) phi: [f64; 2],
    pub(crate) xi: I,
    pub(crate) y: I,
    /// ξ/y
    pub(crate) slope: I,
    /// (cos 2φ, sin 2φ) at both ends
    doubled: [[f64; 2]; 2],
}

impl Cell {
    /// A single corner, up to rounding error.
    pub(crate) fn point(phi: f64) -> Self {
        Self::new(phi, phi)
    }

    pub(crate) fn new(a: f64, b: f64) -> Self {
        // Wider than the rounding errors of the functions and of angles that are fractions of π.
        let wide =
            |x: f64, y: f64| I::new(x.min(y) - TRIGONOMETRIC_ERROR, x.max(y) + TRIGONOMETRIC_ERROR);
        if (a, b) == (0.0, 0.0) {
            let doubled = [[1.0, 0.0]; 2];
            return Self { phi: [a, b], xi: I::ZERO, y: I::ONE, slope: I::ZERO, doubled };
        }
        let (xi, mut y) = (wide(libm::sin(a), libm::sin(b)), wide(libm::cos(a), libm::cos(b)));
        if a < 0.0 && b > 0.0 {
            y.hi = 1.0;
        }
        let half = std::f64::consts::FRAC_PI_2;
        let tan = |phi: f64, side: f64| {
            if phi.abs() >= half {
                f64::INFINITY.copysign(phi)
            } else {
                let tan = libm::tan(phi);
                tan + side * TRIGONOMETRIC_ERROR * (1.0 + tan * tan)
            }
        };
        Self {
            phi: [a, b],
            xi: I::new(xi.lo.max(-1.0), xi.hi.min(1.0)),
            y: I::new(y.lo.max(0.0), y.hi.min(1.0)),
            slope: I::new(tan(a, -1.0), tan(b, 1.0)),
            doubled: [a, b].map(|phi| [libm::cos(2.0 * phi), libm::sin(2.0 * phi)]),
        }
    }
}

/// xx ξ² + 2 xy ξy + yy y²
pub(super) struct Form {
    pub(super) xx: I,
    pub(super) xy: I,
    pub(super) yy: I,
}

impl Form {
    /// The largest value of the form on the circle ξ² + y² = 1.
    pub(super) fn largest(&self) -> f64 {
        let (mean, half) = ((self.xx + self.yy).times(0.5), (self.yy - self.xx).times(0.5));
        (mean + (half.square() + self.xy.square()).sqrt()).hi
    }

    /// The largest value of the form for ξ = sin φ, y = cos φ, φ in a cell narrower than a quarter turn. There the form is (xx + yy)/2 +
    /// (yy − xx)/2 cos 2φ + xy sin 2φ.
    pub(super) fn most(&self, cell: &Cell) -> f64 {
        let [xx, xy, yy] = [&self.xx, &self.xy, &self.yy].map(|k| k.middle());
        let off: f64 = [&self.xx, &self.xy, &self.yy].iter().map(|k| k.hi - k.lo).sum();
        let (mean, even, odd) = (0.5 * (xx + yy), 0.5 * (yy - xx), xy);
        let value = |[cos, sin]: [f64; 2]| mean + even * cos + odd * sin;
        let rises = |[cos, sin]: [f64; 2]| odd * cos - even * sin;
        let size = mean.abs() + even.abs() + odd.abs();
        let [a, b] = cell.doubled;
        let slack = 4.0 * f64::EPSILON * size;
        let peak = rises(a) >= -slack && rises(b) <= slack;
        let most =
            if peak { mean + (even * even + odd * odd).sqrt() } else { value(a).max(value(b)) };
        most + off + 16.0 * f64::EPSILON * size
    }
}

/// The images of a set of corners, at most eight.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Images {
    list: [Image; 8],
    len: usize,
}

impl Images {
    pub(crate) fn none() -> Self {
        Self { list: [Image::Unknown; 8], len: 0 }
    }

    fn push(&mut self, image: Image) {
        if self.len == self.list.len() {
            self.list[0] = Image::Unknown;
        } else {
            self.list[self.len] = image;
            self.len += 1;
        }
    }

    pub(crate) fn iter(&self) -> impl Iterator<Item = &Image> {
        self.list[..self.len].iter()
    }
}

/// Why every frictionless flight ends at a Zeno point.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum FlightsEnd {
    /// λ = D⁻¹(g_1, g_2) > 0: the energy bounds the gaps.
    Energy,
    /// λ_j < 0, ψ_1, ψ_2 ≤ 0 and g > 0 at the other contact: contact j drifts away. After a time proportional to the size of the kick it is
    /// not hit any more.
    Drift,
}

/// The corner map.
#[derive(Debug, Clone)]
pub(crate) struct CornerMap {
    local: Local,
    flights: [Flight; 2],
    /// Accelerations of contact k while it slides with ξ < 0, and with ξ > 0. `None` unless a positive normal force certainly keeps contact
    /// k on the terrain (else Painlevé).
    pub(super) slides: [[Option<Arc>; 2]; 2],
    /// For contact k that slides with ξ < 0, and with ξ > 0: if it jams and jams are impacts, the change of the gap rate of the other contact
    /// per unit ξ.
    jumps: [[Option<I>; 2]; 2],
    pub(super) from_rest: [FromRest; 2],
    /// The motion in which both contacts slide, for s < 0 and for s > 0.
    both: [BothSlide; 2],
    /// Whether a jam ends by an impact.
    resolves_jams: bool,
}

/// Solves a x + b y = p, c x + d y = q.
fn solve([[a, b], [c, d]]: [[I; 2]; 2], [p, q]: [I; 2]) -> [I; 2] {
    let det = a * d - b * c;
    [(p * d - q * b) / det, (q * a - p * c) / det]
}

/// A contact: its normal and its tangent, and its arm from the centre of mass along the tangent (b) and along the normal (c), in m.
pub(super) struct Row {
    n: [I; 2],
    t: [I; 2],
    b: I,
    c: I,
}

impl Row {
    pub(super) fn of(contact: &Contact, center_of_mass: [f64; 2]) -> Self {
        let exact = |x: f64| I::from(x);
        let [cos, sin] = match quarter_turns(contact.slope) {
            Some(parts) => parts.map(exact),
            None => [libm::cos(contact.slope), libm::sin(contact.slope)].map(I::near),
        };
        let arm: [I; 2] =
            std::array::from_fn(|k| exact(contact.point[k]) - exact(center_of_mass[k]));
        let (n, t) = ([-sin, cos], [cos, sin]);
        let (b, c) = (t[0] * arm[0] + t[1] * arm[1], n[0] * arm[0] + n[1] * arm[1]);
        Self { n, t, b, c }
    }

    /// The direction (x, y, θ) in which both contacts stay on their ground: N_1 × N_2, N = (n, b).
    pub(super) fn along_both(&self, other: &Self) -> [I; 3] {
        let ((n, b), (m, c)) = ((self.n, self.b), (other.n, other.b));
        [n[1] * c - b * m[1], b * m[0] - n[0] * c, n[0] * m[1] - n[1] * m[0]]
    }

    /// N M⁻¹ (N − σμT)ᵀ per unit mass, see [`Local::stiffness`].
    pub(super) fn stiffness(&self, friction: f64, side: f64, rho2: I) -> I {
        let arm = self.b + self.c * I::from(friction).times(side);
        I::ONE + self.b * arm / rho2
    }

    /// Change of the gap in a direction: N z.
    pub(super) fn opens(&self, z: [I; 3]) -> I {
        self.n[0] * z[0] + self.n[1] * z[1] + self.b * z[2]
    }
}

/// √(x² + y² + ρ²θ²)
pub(super) fn length(z: [I; 3], rho2: I) -> I {
    (z[0].square() + z[1].square() + rho2 * z[2].square()).sqrt()
}

impl Local {
    /// `None` if the two normal rows may be linearly dependent, or if the common sliding direction may leave one contact in place.
    pub(crate) fn new(posture: &Posture) -> Option<Self> {
        let [first, second] = posture.contacts() else { return None };
        Self::of(posture.fields(), [first, second])
    }

    /// The constants of a body on these two contacts.
    pub(super) fn of(f: &PostureFields, [first, second]: [&Contact; 2]) -> Option<Self> {
        let exact = |x: f64| I::from(x);
        let gravity = exact(f.gravity);
        let rho2 = exact(f.gyration_radius).square();
        let rows = [first, second].map(|contact| Row::of(contact, f.center_of_mass));
        let dot = |x: [I; 2], y: [I; 2]| x[0] * y[0] + x[1] * y[1];
        let both = |f: &dyn Fn(usize, usize) -> I| [[f(0, 0), f(0, 1)], [f(1, 0), f(1, 1)]];
        let nn = both(&|i, j| {
            let turned = rows[i].b * rows[j].b / rho2;
            (if i == j { I::ONE } else { dot(rows[i].n, rows[j].n) }) + turned
        });
        let tn = both(&|i, j| {
            let turned = rows[i].c * rows[j].b / rho2;
            (if i == j { I::ZERO } else { dot(rows[i].t, rows[j].n) }) - turned
        });
        let each = |f: &dyn Fn(usize) -> I| [f(0), f(1)];
        let tt = each(&|i| I::ONE + rows[i].c.square() / rho2);
        let z = rows[0].along_both(&rows[1]);
        let size = length(z, rho2);
        if !size.is_positive() {
            return None;
        }
        let z = z.map(|part| part / size);
        let restitution = |i: usize| exact([first, second][i].restitution.unwrap_or(f.restitution));
        Self::with(Products {
            nn,
            tn,
            tt,
            alpha: each(&|i| rows[i].t[0] * z[0] + rows[i].t[1] * z[1] - rows[i].c * z[2]),
            g: each(&|i| gravity * rows[i].n[1]),
            pull: each(&|i| -(gravity * rows[i].t[1])),
            drift: -(gravity * z[1]),
            e: each(&restitution),
            mu: each(&|i| exact([first, second][i].friction)),
        })
    }

    /// The constants of a mechanism with three coordinates that are not locked, on two contacts.
    pub(crate) fn of_mechanism(mechanism: &Mechanism) -> Option<Self> {
        let rows = EnclosedRows::<I>::of(mechanism)?;
        let three = |row: &[I]| <[I; 3]>::try_from(row).ok();
        let [one, two] = &rows.normals[..] else { return None };
        // The unit of mass is a power of four for which max N_iM⁻¹N_iᵀ is from 16 to 64: with it the bounds on the amplification are mostly least.
        let square = [one, two].map(|n| dot(n, n).hi);
        let unit = libm::exp2((0.5 * libm::log2(square[0].max(square[1]))).floor() - 2.0);
        if !(unit > 0.0 && unit.is_finite()) {
            return None;
        }
        let scaled = |row: &[I]| three(row).map(|row| row.map(|part| part / I::from(unit)));
        let normals = [scaled(one)?, scaled(two)?];
        let tangents = [scaled(&rows.tangents[0])?, scaled(&rows.tangents[1])?];
        let pull = three(&rows.pull)?.map(|part| part.times(unit));
        let [a, b] = normals;
        let part = |i: usize, j: usize| a[i] * b[j] - a[j] * b[i];
        let z = [part(1, 2), part(2, 0), part(0, 1)];
        let size = dot(&z, &z).sqrt();
        if !size.is_positive() {
            return None;
        }
        let z = z.map(|part| part / size);
        let both = |f: &dyn Fn(usize, usize) -> I| [[f(0, 0), f(0, 1)], [f(1, 0), f(1, 1)]];
        let each = |f: &dyn Fn(usize) -> I| [f(0), f(1)];
        Self::with(Products {
            nn: both(&|i, j| dot(&normals[i], &normals[j])),
            tn: both(&|i, j| dot(&tangents[i], &normals[j])),
            tt: each(&|i| dot(&tangents[i], &tangents[i])),
            alpha: each(&|i| dot(&tangents[i], &z)),
            g: each(&|i| rows.gravity(i)),
            pull: each(&|i| dot(&tangents[i], &pull)),
            drift: dot(&pull, &z),
            e: each(&|i| I::from(mechanism.restitution(i))),
            mu: each(&|i| I::from(mechanism.contacts()[i].friction)),
        })
    }

    fn with(known: Products) -> Option<Self> {
        let Products { nn, tn, tt, alpha, g, pull, drift, e, mu } = known;
        let det = nn[0][0] * nn[1][1] - nn[0][1] * nn[1][0];
        if !det.is_positive() || alpha.iter().any(|a| a.contains_zero()) {
            return None;
        }
        // β = (T M⁻¹Nᵀ)(N M⁻¹Nᵀ)⁻¹
        let beta = |i: usize, j: usize| {
            let other = 1 - j;
            (tn[i][j] * nn[other][other] - tn[i][other] * nn[other][j]) / det
        };
        Some(Self {
            psi: [0, 1].map(|i| -nn[0][1] / nn[i][i]),
            beta: [0, 1].map(|i| [beta(i, 0), beta(i, 1)]),
            g,
            e,
            mu,
            pull,
            drift,
            nn,
            tn,
            tt,
            alpha,
        })
    }

    /// λ = (N M⁻¹Nᵀ)⁻¹ g: the forces of the contacts without friction.
    pub(crate) fn weights(&self) -> [I; 2] {
        solve(self.nn, self.g)
    }

    /// Why every frictionless flight ends at a Zeno point; `None` if neither reason is certain.
    ///
    /// Drift, for λ_j < 0 and i the other contact: ψ_1, ψ_2 ≤ 0, g_i > 0. Put s = u_j + ψ_i u_i and y = h_j + ψ_i h_i (here s and y are not
    /// those of a corner). In a flight ṡ = κ with κ = −(g_j + ψ_i g_i) > 0, because λ_j < 0. An impulse at i does not change s; an impulse
    /// P at j adds P D_jj (1 − ψ_1ψ_2) ≥ 0. So y ≥ y_0 + s_0 t + κt²/2. Contact j can be hit only while y ≤ 0, hence not after T* = (S +
    /// √(S² + 2κY))/κ, with S = max(0, −s_0), Y = max(0, −y_0).
    pub(super) fn flights_end(&self) -> Option<FlightsEnd> {
        let weights = self.weights();
        if weights.iter().all(|weight| weight.is_positive()) {
            return Some(FlightsEnd::Energy);
        }
        let repels = self.psi.iter().all(|psi| psi.hi <= 0.0);
        let drifts = |j: usize| weights[j].is_negative() && self.g[1 - j].is_positive();
        (repels && (0..2).any(drifts)).then_some(FlightsEnd::Drift)
    }

    /// k = N M⁻¹ (N − σμT)ᵀ of contact k, per unit mass, with σ the sign of its sliding: gravity into its terrain divided by its normal
    /// force while it slides.
    pub(super) fn stiffness(&self, k: usize, side: f64) -> I {
        self.nn[k][k] - self.mu[k].times(side) * self.tn[k][k]
    }

    /// Returns true if contact k certainly has no motion on the terrain while the other contact is in the air: gravity pulls contact k off,
    /// and friction is too weak to press it down, whether it slides or not.
    fn lets_go(&self, k: usize) -> bool {
        let soft = |side: f64| self.stiffness(k, side).is_positive();
        self.g[k].is_negative() && soft(1.0) && soft(-1.0)
    }

    /// Accelerations while contact k slides along its tangent with this sign and the other one is in the air; `None` unless the
    /// normal force is certainly not negative and no jam is possible.
    fn slide(&self, k: usize, side: f64) -> Option<Arc> {
        let rub = self.mu[k].times(side);
        let stiffness = self.stiffness(k, side);
        if !stiffness.is_positive() || !(self.g[k].lo >= 0.0) {
            return None;
        }
        let force = self.g[k] / stiffness;
        let along = self.pull[k] + force * (self.tn[k][k] - rub * self.tt[k]);
        let m = 1 - k;
        let normal = force * (self.nn[m][k] - rub * self.tn[k][m]) - self.g[m];
        Some(Arc { along: along / self.alpha[k], normal })
    }

    /// Motion from rest of contact k on the terrain, the other one in the air.
    fn starts_from_rest(&self, k: usize) -> FromRest {
        let m = 1 - k;
        if !(self.g[k].lo >= 0.0) {
            return FromRest::Unknown; // separation is possible, too
        }
        let [normal, tangential] = solve(
            [[self.nn[k][k], self.tn[k][k]], [self.tn[k][k], self.tt[k]]],
            [self.g[k], -self.pull[k]],
        );
        let room = [self.mu[k] * normal - tangential, self.mu[k] * normal + tangential];
        let sticks = if room.iter().all(|side| side.is_positive()) {
            Some(true)
        } else if room.iter().any(|side| side.is_negative()) {
            Some(false)
        } else {
            None
        };
        let mut found = Vec::new();
        match sticks {
            None => return FromRest::Unknown,
            Some(true) => {
                let lift = normal * self.nn[m][k] + tangential * self.tn[k][m] - self.g[m];
                found.push(FromRest::Fixed(Arc { along: I::ZERO, normal: lift }));
            }
            Some(false) => {}
        }
        for side in [1.0, -1.0] {
            let Some(arc) = self.slide(k, side) else {
                if self.stiffness(k, side).is_negative() && self.g[k].is_positive() {
                    continue; // the normal force would be negative
                }
                return FromRest::Unknown;
            };
            // arc.along is a_t/α; the sign of α gives the sign of a_t.
            let alpha = if self.alpha[k].is_positive() { 1.0 } else { -1.0 };
            match arc.along.times(side * alpha).sign() {
                Some(1) => found.push(FromRest::Slides((side * alpha) as i8, arc)),
                Some(_) => {}
                None => return FromRest::Unknown,
            }
        }
        match found.as_slice() {
            [one] => *one,
            _ => FromRest::Unknown,
        }
    }

    /// The modes that may continue a motion in which both contacts slide with this sign of s: both stay on the terrain, or one of them, or
    /// none. `Some(mode)` if it is consistent, `None` if the intervals do not decide; modes that certainly fail are left out.
    fn continuations(&self, side: f64) -> SmallVec<[Option<BothSlide>; 4]> {
        let sign = |i: usize| if self.alpha[i].is_positive() { side } else { -side };
        let rub = [0, 1].map(|i| self.mu[i].times(sign(i)));
        let stiffness = |i: usize, j: usize| self.nn[i][j] - rub[j] * self.tn[j][i];
        let matrix = [[stiffness(0, 0), stiffness(0, 1)], [stiffness(1, 0), stiffness(1, 1)]];
        let force = solve(matrix, self.g);
        let mut found = SmallVec::new();
        let closed = force.map(I::sign);
        if closed == [Some(1), Some(1)] {
            let along = self.drift
                - (rub[0] * force[0] * self.alpha[0] + rub[1] * force[1] * self.alpha[1]);
            found.push(match along.times(side).sign() {
                Some(-1) => Some(BothSlide::Stops),
                Some(_) => Some(BothSlide::Runs),
                None => None,
            });
        } else if !closed.contains(&Some(-1)) {
            found.push(None);
        }
        for k in 0..2 {
            match self.slide(k, sign(k)) {
                Some(arc) => match arc.normal.sign() {
                    Some(1) => found.push(Some(BothSlide::Lifts(k))),
                    Some(-1) => {}
                    _ => found.push(None),
                },
                None => match (self.g[k].sign(), stiffness(k, k).sign()) {
                    (Some(1), Some(-1)) | (Some(-1), Some(1)) => {} // a negative normal force
                    _ => found.push(None),
                },
            }
        }
        if self.g.iter().all(|g| g.lo < 0.0) {
            let falls = self.g.iter().all(|g| g.is_negative());
            found.push(falls.then_some(BothSlide::Separate));
        }
        found
    }

    /// Returns true if contact k certainly jams while it slides with this sign of v_t and the other contact is in the air: gravity presses
    /// it down, and no normal force keeps it on the terrain.
    pub(super) fn jams_alone(&self, k: usize, side: f64) -> bool {
        self.g[k].is_positive() && self.stiffness(k, side).is_negative()
    }

    /// Change of the gap rate of the other contact, per unit ξ, in the plastic impact that ends a jam of contact k. The impulse P =
    /// −W⁻¹(v_t, 0) stops contact k, with W the impact matrix of contact k in the order tangential, normal.
    fn jump(&self, k: usize) -> I {
        let m = 1 - k;
        let det = self.nn[k][k] * self.tt[k] - self.tn[k][k].square();
        (self.nn[m][k] * self.tn[k][k] - self.tn[k][m] * self.nn[k][k]) / det * self.alpha[k]
    }

    /// Whether impulses in the cones of both contacts stop a motion in which both slide with this sign of s; `None` if the intervals do not
    /// decide. An impulse w has the components N_1M⁻¹w, N_2M⁻¹w and z·w. Those of the edges N_j + f T_j, f = ±μ_j, are N_iM⁻¹N_j + f
    /// T_jM⁻¹N_i and f α_j. The impulse that stops the body has the components (0, 0, −s).
    fn stops_both(&self, side: f64) -> Option<bool> {
        let edge = |(j, way): (usize, f64)| {
            let f = self.mu[j].times(way);
            let of = |i: usize| self.nn[i][j] + f * self.tn[j][i];
            [of(0), of(1), f * self.alpha[j]]
        };
        let edges = [(0, 1.0), (0, -1.0), (1, 1.0), (1, -1.0)].map(edge);
        let target = [I::ZERO, I::ZERO, I::from(-side)];
        let cross = |a: [I; 3], b: [I; 3]| {
            let part = |i: usize, j: usize| a[i] * b[j] - a[j] * b[i];
            [part(1, 2), part(2, 0), part(0, 1)]
        };
        let dot = |a: [I; 3], b: [I; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
        // The target is inside if it is a sum of positive parts of three edges. It is outside if a plane through two edges has it on one
        // side, and the other edges on the other side or in the plane.
        for left in 0..4 {
            let [a, b, c] = [1, 2, 3].map(|k| edges[(left + k) % 4]);
            let volume = dot(a, cross(b, c));
            let parts = [cross(b, c), cross(c, a), cross(a, b)].map(|n| dot(target, n) / volume);
            if !volume.contains_zero() && parts.iter().all(|part| part.is_positive()) {
                return Some(true);
            }
        }
        for i in 0..4 {
            for j in i + 1..4 {
                let normal = cross(edges[i], edges[j]);
                let others =
                    || (0..4).filter(|k| *k != i && *k != j).map(|k| dot(edges[k], normal));
                let at = dot(target, normal);
                if at.is_positive() && others().all(|x| x.hi <= 0.0)
                    || at.is_negative() && others().all(|x| x.lo >= 0.0)
                {
                    return Some(false);
                }
            }
        }
        None
    }

    /// Whether a mode continues a motion in which both contacts slide with this sign of s; `None` if the intervals do not decide.
    pub(super) fn goes_on(&self, side: f64) -> Option<bool> {
        let found = self.continuations(side);
        if found.iter().any(Option::is_some) {
            return Some(true);
        }
        found.is_empty().then_some(false)
    }

    /// Motion with both contacts sliding on the terrain with this sign of s.
    fn both(&self, side: f64) -> BothSlide {
        match self.continuations(side).as_slice() {
            [] => BothSlide::Jams,
            [Some(one)] => *one,
            _ => BothSlide::Unknown,
        }
    }

    /// The ends of the motions after the corners at contact 1 and at contact 2 with landing speed 1.
    fn flights(&self, fine: impl FnOnce() -> Option<Model<Ball>>) -> [Flight; 2] {
        let lets_go = [0, 1].map(|k| self.lets_go(k));
        let model = Model::new(self.g, self.psi, self.e, 2);
        let mut flights = [0, 1].map(|j| Flight::after_corner(&model, j, lets_go));
        if flights.contains(&Flight::Unknown)
            && let Some(fine) = fine()
        {
            for j in 0..2 {
                // If one remains unknown, the other one rarely decides.
                if flights[j] == Flight::Unknown && (j == 0 || flights[0] != Flight::Unknown) {
                    flights[j] = Flight::after_corner_finely(&model, &fine, j, lets_go);
                }
            }
        }
        flights
    }
}

/// ξ/y for y ≥ 0.
pub(crate) fn tangent(xi: I, y: I) -> I {
    if xi == I::ZERO {
        return I::ZERO;
    }
    let quotient = |x: f64, near: f64, far: f64| {
        let y = if x < 0.0 { near } else { far };
        if x == 0.0 { 0.0 } else { x / y }
    };
    let (lo, hi) = (quotient(xi.lo, y.lo, y.hi), quotient(xi.hi, y.hi, y.lo));
    I::new(lo.next_down(), hi.next_up())
}

/// x + a, where x may be unbounded.
fn shifted(x: I, a: I) -> I {
    I::new((x.lo + a.lo).next_down(), (x.hi + a.hi).next_up())
}

/// The next landing of a gap h ≥ 0 with rate u and acceleration a.
fn landing(h: I, u: I, a: I) -> Landing<I> {
    Gap { h, u }.landing(-a)
}

impl CornerMap {
    pub(crate) fn new(posture: &Posture, jams: Jams) -> Option<Self> {
        Some(Self::of(Local::new(posture)?, || enclosure::local_model(posture), jams))
    }

    /// That of a mechanism with three coordinates that are not locked.
    pub(crate) fn of_mechanism(mechanism: &Mechanism, jams: Jams) -> Option<Self> {
        let fine = || {
            let rows = EnclosedRows::<Ball>::of(mechanism)?;
            let n = |i: usize, j: usize| dot(&rows.normals[i], &rows.normals[j]);
            let psi = [(-n(0, 1)).over(n(0, 0))?, (-n(0, 1)).over(n(1, 1))?];
            let e = [0, 1].map(|i| Ball::from(mechanism.restitution(i)));
            Some(Model::new([0, 1].map(|i| rows.gravity(i)), psi, e, 2))
        };
        Some(Self::of(Local::of_mechanism(mechanism)?, fine, jams))
    }

    /// `fine`: the frictionless model with more digits.
    fn of(local: Local, fine: impl FnOnce() -> Option<Model<Ball>>, jams: Jams) -> Self {
        // The sign of v_t for ξ < 0 and for ξ > 0.
        let sides =
            [0, 1].map(|k| if local.alpha[k].is_positive() { [-1.0, 1.0] } else { [1.0, -1.0] });
        let slides = [0, 1].map(|k| sides[k].map(|side| local.slide(k, side)));
        let ends = |k: usize, side: f64| jams == Jams::Impact && local.jams_alone(k, side);
        let jump = |k: usize| sides[k].map(|side| ends(k, side).then(|| local.jump(k)));
        Self {
            flights: local.flights(fine),
            from_rest: [local.starts_from_rest(0), local.starts_from_rest(1)],
            both: [local.both(-1.0), local.both(1.0)],
            slides,
            jumps: [jump(0), jump(1)],
            resolves_jams: jams == Jams::Impact,
            local,
        }
    }

    /// Returns true if the motion with both contacts sliding is known for both signs of s.
    pub(crate) fn slides_known(&self) -> bool {
        self.both
            .iter()
            .all(|both| !matches!(both, BothSlide::Separate | BothSlide::Jams | BothSlide::Unknown))
    }

    /// Returns true if certainly no mode continues the motion with both contacts sliding with this sign of s.
    pub(super) fn jams_together(&self, side: f64) -> bool {
        self.both[usize::from(side > 0.0)] == BothSlide::Jams
    }

    /// The smaller |α_i| of the two contacts. α_i is the speed of contact i per unit speed s of the body when both contacts slide. If it is
    /// near zero, contact i hardly moves.
    pub(crate) fn least_slide(&self) -> f64 {
        self.local.alpha.iter().map(|alpha| alpha.middle().abs()).fold(f64::INFINITY, f64::min)
    }

    /// Returns true if some contact jams when it slides alone, and jams are no impacts.
    pub(crate) fn jams(&self) -> bool {
        let l = &self.local;
        let jams =
            |k: usize| [1.0, -1.0].into_iter().any(|side| l.stiffness(k, side).is_negative());
        (0..2).any(|k| jams(k) && self.jumps[k] == [None; 2])
    }

    /// Returns true if impacts that end jams are part of the motion.
    pub(super) fn has_jumps(&self) -> bool {
        self.jumps.iter().flatten().any(Option::is_some)
    }

    /// Returns true if the flight after some corner is unknown.
    pub(crate) fn flies_unknown(&self) -> bool {
        self.flights.contains(&Flight::Unknown)
    }

    /// Time from a corner at j with y = 1 to the Zeno point after it.
    pub(super) fn flight_time(&self, j: usize) -> Option<I> {
        match self.flights[j] {
            Flight::One { t, .. } | Flight::Two { t } => Some(t),
            Flight::Away | Flight::Nowhere | Flight::Unknown => None,
        }
    }

    pub(crate) fn local(&self) -> &Local {
        &self.local
    }

    /// The images of the corners of a cell at contact j.
    pub(crate) fn images(&self, j: usize, cell: &Cell) -> Images {
        let mut images = Images::none();
        let i = 1 - j;
        let l = &self.local;
        let shift = l.beta[i][j] / l.alpha[i];
        match self.flights[j] {
            Flight::Unknown => images.push(Image::Unknown),
            Flight::Away => images.push(Image::Escape),
            Flight::Nowhere => {}
            Flight::Two { t } => {
                let s = cell.xi + (shift + l.drift * t) * cell.y;
                self.together(s, &mut images);
            }
            Flight::One { kept, h, u, t } => {
                let m = 1 - kept;
                let from = shift + l.drift * t + l.beta[kept][m] / l.alpha[kept] * u;
                let start = cell.xi + from * cell.y;
                self.parts(start, &mut images, |side, xi, images| {
                    self.slide(&Slide { k: kept, from, h, u, cell }, side, xi, images);
                });
            }
        }
        images
    }

    /// Divides an interval of speeds at zero. Calls `what` with the sign −1 for the part below zero, and with +1 for the part above zero;
    /// with 0 if the speed is exactly zero.
    fn parts(&self, speed: I, images: &mut Images, mut what: impl FnMut(i8, I, &mut Images)) {
        if speed.lo < 0.0 {
            what(-1, I::new(speed.lo, speed.hi.min(0.0)), images);
        }
        if speed.hi > 0.0 {
            what(1, I::new(speed.lo.max(0.0), speed.hi), images);
        }
        if speed == I::ZERO {
            what(0, speed, images);
        }
    }

    /// Contact k slides at the speed `xi`, which has the sign `side`; the other contact is in the air.
    fn slide(&self, start: &Slide, side: i8, xi: I, images: &mut Images) {
        let Slide { k, from, h, u, cell } = *start;
        let (m, y) = (1 - k, cell.y);
        if side == 0 {
            return self.turn(k, h * y.square(), u * y, None, None, images);
        }
        let Some(arc) = self.slides[k][usize::from(side > 0)] else {
            return match self.jumps[k][usize::from(side > 0)] {
                Some(jump) => self.jam(start, side, xi, jump, images),
                None => images.push(Image::Unknown),
            };
        };
        let sign = f64::from(side);
        let slows = arc.along.times(sign).sign();
        let lands = landing(h, u, arc.normal);
        if let Landing::In(t, factor) = lands {
            // ξ' = ξ + B y, y' = K y, if the sign of ξ' is still the same.
            let shift = from + arc.along * t;
            let clip = |x: I| {
                if side > 0 { I::new(x.lo.max(0.0), x.hi) } else { I::new(x.lo, x.hi.min(0.0)) }
            };
            let end = xi + arc.along * t * y;
            let part = clip(end);
            if part.lo <= part.hi {
                let form = Form { xx: I::ONE, xy: shift, yy: shift.square() + factor.square() };
                let slope = clip(shifted(cell.slope, shift) / factor);
                let y = factor * y;
                images.push(Image::Corner {
                    contact: m,
                    xi: part,
                    y,
                    slope: if factor.is_positive() && slope.lo <= slope.hi {
                        slope
                    } else {
                        tangent(part, y)
                    },
                    most: form.most(cell).max(0.0).sqrt().next_up(),
                });
            }
            match slows {
                Some(-1) if end.times(sign).lo <= 0.0 => {
                    let stop = -xi / arc.along;
                    let stop = I::new(stop.lo.max(0.0), stop.hi.min((t * y).hi));
                    if stop.lo <= stop.hi {
                        self.stop(start, side, &arc, stop, images);
                    }
                }
                Some(_) => {}
                None => images.push(Image::Unknown),
            }
            return;
        }
        match (slows, lands) {
            (Some(-1), Landing::Never) => {
                let stop = -xi / arc.along;
                self.stop(start, side, &arc, I::new(stop.lo.max(0.0), stop.hi), images);
            }
            (Some(_), Landing::Never) => images.push(Image::Escape),
            _ => images.push(Image::Unknown),
        }
    }

    /// Contact k, which slides at ξ, jams: it stops, and the gap rate of the other contact changes by `jump` ξ.
    fn jam(&self, start: &Slide, side: i8, xi: I, jump: I, images: &mut Images) {
        let Slide { k, from, h, u, cell } = *start;
        let y = cell.y;
        let most = match self.from_rest[k] {
            FromRest::Fixed(still) => {
                // y'² = (u + jump (ξ + from y))² − 2 a h y², and ξ' = 0.
                let rate = u + jump * from;
                let yy = rate.square() - (still.normal * h).times(2.0);
                let form = Form { xx: jump.square(), xy: jump * rate, yy };
                Some(form.most(cell).max(0.0).sqrt().next_up())
            }
            _ => None,
        };
        self.turn(k, h * y.square(), u * y + jump * xi, Some(side), most, images);
    }

    /// Both contacts slide with this sign of s, and no mode is consistent: they stop, or one of them stops and the other one lifts off. These are
    /// the images of all impacts that friction allows.
    fn jam_together(&self, side: i8, s: I, images: &mut Images) {
        let right = usize::from(side > 0);
        let before = images.len;
        match self.local.stops_both(f64::from(side)) {
            Some(true) => images.push(Image::Rest),
            Some(false) => {}
            None => images.push(Image::Unknown),
        }
        for k in 0..2 {
            let sign = if self.local.alpha[k].is_positive() { side } else { -side };
            match self.jumps[k][right] {
                Some(jump) => match jump.times(f64::from(side)).sign() {
                    Some(1) => self.turn(k, I::ZERO, jump * s, Some(side), None, images),
                    Some(_) => {}
                    None => images.push(Image::Unknown),
                },
                None if self.local.stiffness(k, f64::from(sign)).is_positive() => {}
                None => images.push(Image::Unknown),
            }
        }
        if images.len == before {
            images.push(Image::Unknown);
        }
    }

    /// The sliding of contact k has ended after the time `t`.
    fn stop(&self, start: &Slide, side: i8, arc: &Arc, t: I, images: &mut Images) {
        let Slide { k, from, h, u, cell } = *start;
        let y = cell.y;
        let gap = h * y.square() + u * y * t + (arc.normal * t.square()).times(0.5);
        let rate = u * y + arc.normal * t;
        let Some(gap) = gap.non_negative() else { return images.push(Image::Unknown) };
        let form = match self.from_rest[k] {
            FromRest::Fixed(still) => {
                // y'² = A y² + 2B yτ + C τ² with τ = p ξ + q y
                let less = arc.normal - still.normal;
                let a = u.square() - (still.normal * h).times(2.0);
                let (b, c) = (u * less, arc.normal * less);
                let (p, q) = (-I::ONE / arc.along, -from / arc.along);
                let form = Form {
                    xx: c * p.square(),
                    xy: (b + c * q) * p,
                    yy: a + (b * q).times(2.0) + c * q.square(),
                };
                Some(form.most(cell).max(0.0).sqrt().next_up())
            }
            _ => None,
        };
        self.turn(k, gap, rate, Some(side), form, images);
    }

    /// Contact k is at rest after it slid in the direction `side`; the other contact is in the air. `most`: a bound of the landing speed.
    fn turn(&self, k: usize, h: I, u: I, side: Option<i8>, most: Option<f64>, images: &mut Images) {
        let m = 1 - k;
        let arc = match self.from_rest[k] {
            FromRest::Fixed(arc) => arc,
            FromRest::Slides(to, arc) if side != Some(to) => arc,
            _ => return images.push(Image::Unknown),
        };
        match landing(h, u, arc.normal) {
            Landing::In(t, y) => {
                let xi = arc.along * t;
                let size = (xi.square() + y.square()).sqrt().hi;
                images.push(Image::Corner {
                    contact: m,
                    xi,
                    y,
                    slope: tangent(xi, y),
                    most: most.map_or(size, |most| most.min(size)),
                });
            }
            Landing::Never => images.push(Image::Escape),
            Landing::Unknown => images.push(Image::Unknown),
        }
    }

    /// Both contacts are on the terrain and slide at s.
    pub(crate) fn together(&self, s: I, images: &mut Images) {
        if s.contains_zero() {
            images.push(Image::Rest);
        }
        self.parts(s, images, |side, s, images| {
            let k = match self.both[usize::from(side > 0)] {
                _ if side == 0 => return, // at rest
                BothSlide::Stops => return images.push(Image::Rest),
                BothSlide::Runs => return images.push(Image::Escape),
                BothSlide::Jams if self.resolves_jams => return self.jam_together(side, s, images),
                BothSlide::Separate | BothSlide::Jams | BothSlide::Unknown => {
                    return images.push(Image::Unknown);
                }
                BothSlide::Lifts(k) => k,
            };
            let Some(arc) = self.slides[k][usize::from(side > 0)] else {
                return images.push(Image::Unknown);
            };
            match arc.along.times(f64::from(side)).sign() {
                Some(-1) => {
                    let t = -s / arc.along;
                    let t = I::new(t.lo.max(0.0), t.hi);
                    let gap = (arc.normal * t.square()).times(0.5);
                    self.turn(k, gap, arc.normal * t, Some(side), None, images);
                }
                Some(_) => images.push(Image::Escape),
                None => images.push(Image::Unknown),
            }
        });
    }

    /// The images after both contacts slide with s < 0 or s > 0.
    pub(crate) fn sliding_together(&self, right: bool) -> Images {
        let mut images = Images::none();
        self.together(if right { I::ONE } else { -I::ONE }, &mut images);
        images
    }

    /// The map near a fast-slide end (φ near ±π/2) of the corners at j, where contact k stays on the terrain: ξ' = ξ + B y, y' = K y.
    /// The slide begins at ξ + A y. Returns the contact that lands next, A, B and K; `None` if the corners do not repeat in this way.
    pub(crate) fn fast(&self, j: usize, right: bool) -> Option<(usize, I, I, I)> {
        let Flight::One { kept, h, u, t } = self.flights[j] else { return None };
        let (i, m, l) = (1 - j, 1 - kept, &self.local);
        let arc = self.slides[kept][usize::from(right)]?;
        let from = l.beta[i][j] / l.alpha[i] + l.drift * t + l.beta[kept][m] / l.alpha[kept] * u;
        let Landing::In(time, factor) = landing(h, u, arc.normal) else { return None };
        Some((m, from, from + arc.along * time, factor))
    }

    /// The motions with one contact on the terrain: the contact, the sign of its ξ (0: fixed), and whether the motion ends with a landing
    /// of the other contact. A contact that gravity pulls off the terrain has no such motion.
    fn lone(&self) -> impl Iterator<Item = (usize, i8, Option<bool>)> {
        let falls = |arc: &Arc| arc.normal.sign().map(|sign| sign < 0);
        (0..2).filter(|&k| !self.local.lets_go(k)).flat_map(move |k| {
            let (still, back) = match &self.from_rest[k] {
                FromRest::Fixed(arc) => (0, falls(arc)),
                FromRest::Slides(side, arc) => (*side, falls(arc)),
                FromRest::Unknown => (0, None),
            };
            let slides = [-1_i8, 1].map(|side| {
                let right = usize::from(side > 0);
                let ends = match &self.slides[k][right] {
                    Some(arc) => match (falls(arc), arc.along.times(f64::from(side)).sign()) {
                        (Some(true), _) => Some(true),
                        (_, Some(-1)) => back,
                        (Some(false), Some(_)) => Some(false),
                        _ => None,
                    },
                    None => self.jumps[k][right].and(back), // after a jam it starts from rest
                };
                (k, side, ends)
            });
            [(k, still, back)].into_iter().chain(slides)
        })
    }

    /// Returns true if every motion with one contact on the terrain certainly ends with a landing of the other one.
    pub(crate) fn returns(&self) -> bool {
        self.lone().all(|(.., ends)| ends == Some(true))
    }

    /// A motion with contacts on the terrain that certainly goes on for ever, or ends in one that does.
    pub(crate) fn leaves(&self) -> Option<Away> {
        let alone = self.lone().find(|(.., ends)| *ends == Some(false));
        if let Some((k, side, _)) = alone {
            return Some(Away::Alone(k, side));
        }
        let escapes = |side: &i8| {
            self.sliding_together(*side > 0).iter().any(|image| *image == Image::Escape)
        };
        let side = [-1, 1].into_iter().find(escapes)?;
        match self.both[usize::from(side > 0)] {
            BothSlide::Lifts(k) => Some(Away::Lifts(k, side)),
            _ => Some(Away::Together(side)),
        }
    }
}

#[cfg(test)]
mod tests {
    use crate::body::Lamina;
    use proptest::prelude::*;

    use super::*;
    use crate::math::cases::fixed;
    use crate::stability::tests::odd;

    /// L = 1, ρ = 2, e = 1/5, g = 1: ψ = −3/5. Contact j bounces for T = 2e/(g(1−e)) = 1/2, and the other one is then at
    /// h = |ψ|T/(1−e) − gT²/2 = 1/4 with u = |ψ|(1+e)/(1−e) − gT = 2/5. It falls with g(1+ψ) = 2/5 and lands with
    /// √(u² + 2·2/5·h) = 3/5. Without friction the sliding speed stays.
    #[test]
    fn a_corner_of_a_rod_without_friction_comes_back_with_three_fifths_of_its_speed() {
        let rod = Posture::rod(
            1.0,
            &Lamina {
                gyration_radius: Some(2.0),
                restitution: 0.2,
                gravity: 1.0,
                ..Lamina::default()
            },
        )
        .expect("a rod");
        let map = CornerMap::new(&rod, Jams::None).expect("a corner map");
        let near = |x: I, exact: f64| x.lo <= exact && exact <= x.hi && x.hi - x.lo < 1e-13;
        for (j, right) in [(0, false), (0, true), (1, false), (1, true)] {
            let (next, _, bend, factor) = map.fast(j, right).expect("a slide");
            assert!(next == 1 - j && near(factor, 0.6) && near(bend, 0.0), "{factor:?} {bend:?}");
            assert!(near(map.flight_time(j).expect("bounces"), 0.5));
        }
    }

    /// Contact, ξ, y and ξ/y of the corners among these images, with φ reversed for −1, and the number of the others.
    fn corners(images: &Images, side: f64) -> (Vec<(usize, [I; 3])>, usize) {
        let corner = |image: &Image| match *image {
            Image::Corner { contact, xi, y, slope, .. } => {
                Some((contact, [xi.times(side), y, slope.times(side)]))
            }
            _ => None,
        };
        let found: Vec<_> = images.iter().filter_map(corner).collect();
        let others = images.iter().count() - found.len();
        (found, others)
    }

    fn meets(x: [I; 3], y: [I; 3]) -> bool {
        x.iter().zip(y).all(|(x, y)| x.lo <= y.hi && y.lo <= x.hi)
    }

    proptest! {
        #![proptest_config(fixed(3))]

        #[test]
        fn the_corner_map_of_a_symmetric_body_is_its_mirror_image_with_the_contacts_exchanged(
            phi in -1.5..1.5, e in 0.05..0.6, rho in 0.3..1.5, mu in 0.0..1.0, height in 0.0..1.0,
        ) {
            let rod = Posture::rod(1.0, &Lamina { gyration_radius: Some(rho), restitution: e, friction: mu, gravity: 1.0, ..Lamina::default() }).expect("a rod");
            let above = PostureFields { center_of_mass: [0.0, height], ..rod.fields().clone() };
            let map = CornerMap::new(&Posture::new(above).expect("a posture"), Jams::None).expect("a corner map");
            let [one, two] = [(0, 1.0), (1, -1.0)].map(|(j, side)| corners(&map.images(j, &Cell::point(side * phi)), side));
            prop_assert_eq!((one.0.len(), one.1), (two.0.len(), two.1));
            for ((i, one), (j, two)) in one.0.into_iter().zip(two.0) {
                prop_assert!(i == 1 - j && meets(one, two), "{one:?} {two:?}");
            }
        }

        #[test]
        fn the_images_of_a_cell_contain_those_of_its_corners(
            low in -1.5..1.2, width in 0.001..0.3, share in 0.0..1.0, e in 0.01..0.4, j in 0..2_usize,
        ) {
            let map = CornerMap::new(&odd(e), Jams::None).expect("a corner map");
            let (all, others) = corners(&map.images(j, &Cell::new(low, low + width)), 1.0);
            for (i, point) in corners(&map.images(j, &Cell::point(low + share * width)), 1.0).0 {
                let found = all.iter().any(|(contact, image)| *contact == i && meets(point, *image));
                prop_assert!(found || others > 0, "{i} {point:?} {all:?}");
            }
        }
    }
}
