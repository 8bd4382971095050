//! The local model of two contacts, in intervals: the constants of the posture, and the motions with contacts on the terrain.

use serde::{Deserialize, Serialize};
use smallvec::SmallVec;

use crate::body::Mechanism;
use crate::body::contact::{Contact, quarter_turns};
use crate::body::fields::PostureFields;
use crate::body::posture::Posture;
use crate::math::interval::Interval;
use crate::math::real::Enclosed;
use crate::tolerance::ON_ONE_LINE;
use crate::verified::Energy;
use crate::verified::rows::{EnclosedRows, dot};

type I = Interval;

/// Constants of a posture in its local model, per unit mass.
#[derive(Debug, Clone)]
pub(crate) struct Local {
    pub(super) g: [I; 2],
    pub(super) e: [I; 2],
    pub(super) psi: [I; 2],
    pub(super) mu: [I; 2],
    /// N_iM⁻¹N_jᵀ, T_iM⁻¹N_jᵀ, T_iM⁻¹T_iᵀ
    pub(super) nn: [[I; 2]; 2],
    pub(super) tn: [[I; 2]; 2],
    pub(super) tt: [I; 2],
    /// Tangential free acceleration T_i (0, −g, 0).
    pub(super) pull: [I; 2],
    pub(crate) alpha: [I; 2],
    pub(super) beta: [[I; 2]; 2],
    /// ṡ in flight.
    pub(super) drift: I,
    /// See [`Model::between`](crate::verified::Model).
    pub(super) between: Vec<I>,
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
pub(super) enum BothSlide {
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

/// Solves a x + b y = p, c x + d y = q.
pub(super) fn solve([[a, b], [c, d]]: [[I; 2]; 2], [p, q]: [I; 2]) -> [I; 2] {
    let det = a * d - b * c;
    [(p * d - q * b) / det, (q * a - p * c) / det]
}

/// A contact: its normal and its tangent, and its arm from the centre of mass along the tangent (b) and along the normal (c), in m.
pub(super) struct Row {
    pub(super) n: [I; 2],
    t: [I; 2],
    pub(super) b: I,
    pub(super) c: I,
}

impl Row {
    /// `width`: that of the numbers, see [`StabilityOptions`](super::StabilityOptions).
    pub(super) fn of(contact: &Contact, center_of_mass: [f64; 2], width: f64) -> Self {
        let exact = |x: f64| I::from(x);
        let [cos, sin] = match quarter_turns(contact.slope) {
            Some(parts) => parts.map(exact),
            None => [libm::cos(contact.slope), libm::sin(contact.slope)]
                .map(|part| I::near(part).widened(width * contact.slope.abs())),
        };
        let arm = [0, 1].map(|k| exact(contact.point[k]) - exact(center_of_mass[k]));
        let length = (arm[0].square() + arm[1].square()).sqrt().hi;
        let arm = arm.map(|part| part.widened(width * length));
        let (n, t) = ([-sin, cos], [cos, sin]);
        let (b, c) = (t[0] * arm[0] + t[1] * arm[1], n[0] * arm[0] + n[1] * arm[1]);
        Self { n, t, b, c }
    }

    /// The place of this contact on the line from one with an equal normal (0) to another one (1); `None` unless it is on this line and strictly
    /// between them.
    pub(super) fn between(&self, from: &Self, to: &Self, size: f64) -> Option<I> {
        let place = (self.b - from.b) / (to.b - from.b);
        let off = (self.c - from.c - place * (to.c - from.c)).middle();
        let inside = place.is_positive() && (I::ONE - place).is_positive();
        (inside && off.abs() <= ON_ONE_LINE * size).then_some(place)
    }

    /// The row after a turn of the body with this cosine and sine.
    pub(super) fn turned(&self, cos: I, sin: I) -> Self {
        Self { b: self.b * cos - self.c * sin, c: self.c * cos + self.b * sin, ..*self }
    }

    /// The horizontal distance of the contact from the centre of mass.
    pub(super) fn along_level(&self) -> I {
        self.t[0] * self.b + self.n[0] * self.c
    }

    /// The height of the contact above the centre of mass.
    pub(super) fn height(&self) -> I {
        self.t[1] * self.b + self.n[1] * self.c
    }

    /// The direction (x, y, θ) in which both contacts stay on their ground: N_1 × N_2, N = (n, b).
    pub(super) fn along_both(&self, other: &Self) -> [I; 3] {
        let ((n, b), (m, c)) = ((self.n, self.b), (other.n, other.b));
        [n[1] * c - b * m[1], b * m[0] - n[0] * c, n[0] * m[1] - n[1] * m[0]]
    }

    /// N M⁻¹ (N − σμT)ᵀ per unit mass, see [`Local::stiffness`].
    pub(super) fn stiffness(&self, friction: I, side: f64, rho2: I) -> I {
        let arm = self.b + self.c * friction.times(side);
        I::ONE + self.b * arm / rho2
    }

    /// Change of the gap in a direction: N z.
    pub(super) fn opens(&self, z: [I; 3]) -> I {
        self.n[0] * z[0] + self.n[1] * z[1] + self.b * z[2]
    }
}

/// The part of the interval of a restitution that is below 1.
fn below_one(e: I) -> I {
    I::new(e.lo.max(0.0), e.hi.min(1.0_f64.next_down()))
}

/// √(x² + y² + ρ²θ²)
pub(super) fn length(z: [I; 3], rho2: I) -> I {
    (z[0].square() + z[1].square() + rho2 * z[2].square()).sqrt()
}

impl Local {
    /// `None` if the two normal rows may be linearly dependent, or if the common sliding direction may leave one contact in place.
    pub(crate) fn new(posture: &Posture, width: f64) -> Option<Self> {
        let [first, second] = posture.contacts() else { return None };
        Self::of(posture.fields(), [first, second], width)
    }

    /// The constants of a body on these two contacts.
    pub(super) fn of(f: &PostureFields, pair: [&Contact; 2], width: f64) -> Option<Self> {
        let [first, second] = pair.map(|contact| Row::of(contact, f.center_of_mass, width));
        Self::of_rows(f, pair, [&first, &second], width)
    }

    /// The same with these rows.
    pub(super) fn of_rows(
        f: &PostureFields,
        [first, second]: [&Contact; 2],
        rows: [&Row; 2],
        width: f64,
    ) -> Option<Self> {
        let exact = |x: f64| I::from(x);
        let gravity = exact(f.gravity);
        let wide = |x: f64| exact(x).widened(width * x);
        let rho2 = wide(f.gyration_radius).square();
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
        let z = rows[0].along_both(rows[1]);
        let size = length(z, rho2);
        if !size.is_positive() {
            return None;
        }
        let z = z.map(|part| part / size);
        let restitution =
            |i: usize| below_one(wide([first, second][i].restitution.unwrap_or(f.restitution)));
        Self::with(Products {
            nn,
            tn,
            tt,
            alpha: each(&|i| rows[i].t[0] * z[0] + rows[i].t[1] * z[1] - rows[i].c * z[2]),
            g: each(&|i| gravity * rows[i].n[1]),
            pull: each(&|i| -(gravity * rows[i].t[1])),
            drift: -(gravity * z[1]),
            e: each(&restitution),
            mu: each(&|i| wide([first, second][i].friction)),
        })
    }

    /// The constants of a mechanism on two contacts, with three coordinates that are not locked, or with more of which the contacts feel three. These
    /// three are known up to rounding errors, which are much smaller than a width that is not zero.
    pub(crate) fn of_mechanism(mechanism: &Mechanism, width: f64) -> Option<Self> {
        let rows = EnclosedRows::<I>::of(mechanism)?;
        let rows = match mechanism.contact_space().basis() {
            None => rows,
            Some(basis) if width > 0.0 => rows.along(basis),
            Some(_) => return None,
        };
        let rows = rows.widened(width);
        let wide = |x: f64| I::from(x).widened(width * x);
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
            e: each(&|i| below_one(wide(mechanism.restitution(i)))),
            mu: each(&|i| wide(mechanism.contacts()[i].friction)),
        })
    }

    /// The constants of two contacts of a mechanism that slide independently, and T_1M⁻¹T_2ᵀ. There is no direction in which both slide: ξ of
    /// each contact is its own v_t. Only functions of one contact on the terrain, and of frictionless motion, have a meaning. `None` unless
    /// the normal rows are certainly independent.
    pub(super) fn apart(mechanism: &Mechanism, width: f64) -> Option<(Self, I)> {
        let rows = EnclosedRows::<I>::of(mechanism)?.widened(width);
        let wide = |x: f64| I::from(x).widened(width * x);
        let (n, t) = (&rows.normals, &rows.tangents);
        if n.len() != 2 {
            return None;
        }
        let both = |f: &dyn Fn(usize, usize) -> I| [[f(0, 0), f(0, 1)], [f(1, 0), f(1, 1)]];
        let each = |f: &dyn Fn(usize) -> I| [f(0), f(1)];
        let local = Self::with(Products {
            nn: both(&|i, j| dot(&n[i], &n[j])),
            tn: both(&|i, j| dot(&t[i], &n[j])),
            tt: each(&|i| dot(&t[i], &t[i])),
            alpha: [I::ONE; 2],
            g: each(&|i| rows.gravity(i)),
            pull: each(&|i| dot(&t[i], &rows.pull)),
            drift: I::ZERO,
            e: each(&|i| below_one(wide(mechanism.restitution(i)))),
            mu: each(&|i| wide(mechanism.contacts()[i].friction)),
        })?;
        Some((local, dot(&t[0], &t[1])))
    }

    /// The same with further contacts between the two, see [`Local::between`].
    pub(super) fn carrying(self, between: &[I]) -> Self {
        Self { between: between.to_vec(), ..self }
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
            between: Vec::new(),
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

    /// The energy of frictionless motions; `None` unless it certainly bounds them (λ > 0), and gravity presses both contacts down, which bounds
    /// their duration.
    pub(super) fn energy(&self) -> Option<Energy> {
        let weights = self.weights();
        let det = self.determinant();
        let [[a, b], [_, c]] = self.nn;
        let lost = |j: usize| {
            let squared = self.e[j].square();
            if squared.is_positive() {
                (I::ONE - squared) / (squared * self.nn[j][j])
            } else {
                I::ZERO
            }
        };
        let bounds = weights.iter().chain(&self.g).all(|x| x.is_positive());
        bounds.then(|| Energy {
            inverse: [[c / det, -b / det], [-b / det, a / det]],
            weights,
            lost: [lost(0), lost(1)],
        })
    }

    /// det D
    pub(super) fn determinant(&self) -> I {
        self.nn[0][0] * self.nn[1][1] - self.nn[0][1] * self.nn[1][0]
    }

    /// k = N M⁻¹ (N − σμT)ᵀ of contact k, per unit mass, with σ the sign of its sliding: gravity into its terrain divided by its normal
    /// force while it slides.
    pub(super) fn stiffness(&self, k: usize, side: f64) -> I {
        self.nn[k][k] - self.mu[k].times(side) * self.tn[k][k]
    }

    /// Returns true if contact k certainly has no motion on the terrain while the other contact is in the air: gravity pulls contact k off,
    /// and friction is too weak to press it down, whether it slides or not.
    pub(super) fn lets_go(&self, k: usize) -> bool {
        let soft = |side: f64| self.stiffness(k, side).is_positive();
        self.g[k].is_negative() && soft(1.0) && soft(-1.0)
    }

    /// Accelerations while contact k slides along its tangent with this sign and the other one is in the air; `None` unless the
    /// normal force is certainly not negative and no jam is possible.
    pub(super) fn slide(&self, k: usize, side: f64) -> Option<Arc> {
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
    pub(super) fn starts_from_rest(&self, k: usize) -> FromRest {
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

    /// The sign of v_t of contact i while both contacts slide with this sign of s.
    fn way(&self, i: usize, side: f64) -> f64 {
        if self.alpha[i].is_positive() { side } else { -side }
    }

    /// N M⁻¹ (N − σμT)ᵀ while both contacts slide with this sign of s.
    fn sliding(&self, side: f64) -> [[I; 2]; 2] {
        [0, 1].map(|i| {
            [0, 1].map(|j| self.nn[i][j] - self.mu[j].times(self.way(j, side)) * self.tn[j][i])
        })
    }

    /// The modes that may continue a motion in which both contacts slide with this sign of s: both stay on the terrain, or one of them, or
    /// none. `Some(mode)` if it is consistent, `None` if the intervals do not decide; modes that certainly fail are left out.
    fn continuations(&self, side: f64) -> SmallVec<[Option<BothSlide>; 4]> {
        let sign = |i: usize| self.way(i, side);
        let rub = [0, 1].map(|i| self.mu[i].times(sign(i)));
        let matrix = self.sliding(side);
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
                None => match (self.g[k].sign(), matrix[k][k].sign()) {
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
    pub(super) fn jump(&self, k: usize) -> I {
        let m = 1 - k;
        let det = self.nn[k][k] * self.tt[k] - self.tn[k][k].square();
        (self.nn[m][k] * self.tn[k][k] - self.tn[k][m] * self.nn[k][k]) / det * self.alpha[k]
    }

    /// Whether impulses in the cones of both contacts stop a motion in which both slide with this sign of s; `None` if the intervals do not
    /// decide. The impulse that stops the body has the components (0, 0, −s), see [`Local::in_cones`].
    pub(super) fn stops_both(&self, side: f64) -> Option<bool> {
        self.in_cones([I::ZERO, I::ZERO, I::from(-side)])
    }

    /// Whether forces in the cones of both contacts hold the body; `None` if the intervals do not decide.
    pub(super) fn holds(&self) -> Option<bool> {
        self.in_cones([self.g[0], self.g[1], -self.drift])
    }

    /// Whether a force w, or an impulse, with the components N_1M⁻¹w, N_2M⁻¹w and z·w is a sum of forces in the cones of both contacts; `None` if
    /// the intervals do not decide. The edges N_j + f T_j, f = ±μ_j, have the components N_iM⁻¹N_j + f T_jM⁻¹N_i and f α_j.
    ///
    /// It is if it lies on the inner side of each plane through two edges that has the other edges on one side, and it is not if it lies on
    /// the outer side of one.
    fn in_cones(&self, target: [I; 3]) -> Option<bool> {
        let mut edges: SmallVec<[[I; 3]; 4]> = SmallVec::new();
        for j in 0..2 {
            let ways: &[f64] = if self.mu[j].is_zero() { &[0.0] } else { &[1.0, -1.0] };
            for way in ways {
                let f = self.mu[j].times(*way);
                let of = |i: usize| self.nn[i][j] + f * self.tn[j][i];
                edges.push([of(0), of(1), f * self.alpha[j]]);
            }
        }
        let cross = |a: [I; 3], b: [I; 3]| {
            let part = |i: usize, j: usize| a[i] * b[j] - a[j] * b[i];
            [part(1, 2), part(2, 0), part(0, 1)]
        };
        let dot = |a: [I; 3], b: [I; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
        let mut inside = edges.len() > 2;
        for i in 0..edges.len() {
            for j in i + 1..edges.len() {
                let normal = cross(edges[i], edges[j]);
                let at = dot(target, normal);
                let others: SmallVec<[I; 2]> = (0..edges.len())
                    .filter(|k| *k != i && *k != j)
                    .map(|k| dot(edges[k], normal))
                    .collect();
                if at.is_positive() && others.iter().all(|x| x.hi <= 0.0)
                    || at.is_negative() && others.iter().all(|x| x.lo >= 0.0)
                {
                    return Some(false);
                }
                let all = |sign: i8| others.iter().all(|x| x.sign() == Some(sign));
                let any = |sign: i8| others.iter().any(|x| x.sign() == Some(sign));
                let splits = any(1) && any(-1);
                let inner = at.is_positive() && all(1) || at.is_negative() && all(-1);
                inside &= splits || inner;
            }
        }
        inside.then_some(true)
    }

    /// Whether a mode continues a motion in which both contacts slide with this sign of s; `None` if the intervals do not decide.
    ///
    /// The modes are the solutions of the complementarity problem a = A λ − g ≥ 0 ⊥ λ ≥ 0 with A = N M⁻¹(N − σμT)ᵀ. If both entries of the
    /// diagonal of A and its determinant are positive, it has exactly one solution for every g. So a motion exists also at a tie, where one
    /// contact carries nothing, and sliding and lifting off are the same motion.
    pub(super) fn goes_on(&self, side: f64) -> Option<bool> {
        let [[a, b], [c, d]] = self.sliding(side);
        if a.is_positive() && d.is_positive() && (a * d - b * c).is_positive() {
            return Some(true);
        }
        let found = self.continuations(side);
        if found.iter().any(Option::is_some) {
            return Some(true);
        }
        found.is_empty().then_some(false)
    }

    /// Motion with both contacts sliding on the terrain with this sign of s.
    pub(super) fn both(&self, side: f64) -> BothSlide {
        match self.continuations(side).as_slice() {
            [] => BothSlide::Jams,
            [Some(one)] => *one,
            _ => BothSlide::Unknown,
        }
    }
}
