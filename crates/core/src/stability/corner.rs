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

use crate::math::ball::Ball;
use crate::math::interval::Interval;
use crate::math::real::Enclosed;
use crate::options::Jams;
use crate::stability::local::{Arc, BothSlide, FromRest, Local};
use crate::stability::settling::settling;
use crate::tolerance::{CUT_ENERGY, TRIGONOMETRIC_ERROR};
use crate::verified::{Flight, Gap, Landing, Model};

type I = Interval;

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
        let most = most + off + 16.0 * f64::EPSILON * size;
        // Infinite coefficients bound nothing.
        if most.is_nan() { f64::INFINITY } else { most }
    }
}

/// A corner of a fast slide: ξ' = ξ + B y, y' = K y. The slide begins at ξ + `from` y.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Fast {
    pub(crate) b: I,
    pub(crate) k: I,
    pub(crate) from: I,
}

/// What follows a corner in a fast slide.
#[derive(Debug, Clone, Copy)]
pub(crate) struct FastSlides {
    /// The corners that may follow, by the contact that lands.
    pub(crate) next: [Option<Fast>; 2],
    /// Whether both contacts may rest.
    pub(crate) ends: bool,
    /// Whether a contact may lift off.
    pub(crate) leaves: bool,
}

impl FastSlides {
    /// The corner that follows, if that is certain.
    pub(crate) fn only(&self) -> Option<(usize, Fast)> {
        match (self.next, self.ends || self.leaves) {
            ([Some(fast), None], false) => Some((0, fast)),
            ([None, Some(fast)], false) => Some((1, fast)),
            _ => None,
        }
    }
}

/// Largest number of images of a set of corners.
const MOST_IMAGES: usize = 16;

/// The images of a set of corners.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Images {
    list: [Image; MOST_IMAGES],
    len: usize,
}

impl Images {
    pub(crate) fn none() -> Self {
        Self { list: [Image::Unknown; MOST_IMAGES], len: 0 }
    }

    fn push(&mut self, image: Image) {
        if self.len == self.list.len() {
            self.list[0] = Image::Unknown;
        } else {
            self.list[self.len] = image;
            self.len += 1;
        }
    }

    /// Adds the images of corners that are larger by these factors.
    pub(crate) fn add(&mut self, other: &Self, factor: I) {
        for image in other.iter() {
            self.push(match *image {
                Image::Corner { contact, xi, y, slope, most } => {
                    let most = (most * factor.hi).next_up();
                    let [xi, y] = [xi * factor, y * factor];
                    Image::Corner { contact, xi, y, slope, most }
                }
                other => other,
            });
        }
    }

    pub(crate) fn iter(&self) -> impl Iterator<Item = &Image> {
        self.list[..self.len].iter()
    }
}

/// The corner map.
#[derive(Debug, Clone)]
pub(crate) struct CornerMap {
    local: Local,
    flights: [Flight; 2],
    /// What follows the flights that are cut.
    remainders: [Option<Remainder>; 2],
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

/// ξ/y for y ≥ 0.
pub(crate) fn tangent(xi: I, y: I) -> I {
    if xi == I::ZERO {
        return I::ZERO;
    }
    let y = y.not_below_zero();
    let quotient = |x: f64, near: f64, far: f64| {
        let y = if x < 0.0 { near } else { far };
        if x == 0.0 { 0.0 } else { x / y }
    };
    let (lo, hi) = (quotient(xi.lo, y.lo, y.hi), quotient(xi.hi, y.hi, y.lo));
    I::new(lo.next_down(), hi.next_up())
}

/// An upper bound of √(ξ² + y²).
fn length([xi, y]: [I; 2]) -> f64 {
    (xi.square() + y.square()).sqrt().hi
}

/// x + a, where x may be unbounded.
fn shifted(x: I, a: I) -> I {
    I::new((x.lo + a.lo).next_down(), (x.hi + a.hi).next_up())
}

/// The landings that a gap may have.
struct Landings {
    /// Time and speed of a landing, if there may be one.
    lands: Option<(I, I)>,
    /// Whether the gap may stay open for ever.
    never: bool,
}

/// The next landing of a gap h ≥ 0 with rate u and acceleration a; `None` if nothing bounds it.
///
/// If the sign of u is not known and a > 0, the contact may land before it lifts: then u < 0 and u² ≥ 2ah, and it lands within |u|/a with
/// at most the speed |u|.
fn landings(h: I, u: I, a: I) -> Option<Landings> {
    match (Gap { h, u }).landing(-a) {
        Landing::In(t, y) => Some(Landings { lands: Some((t, y)), never: false }),
        Landing::Never => Some(Landings { lands: None, never: true }),
        Landing::Unknown if a.is_positive() => {
            let most = I::new(0.0, (-u.lo).max(0.0));
            let t = I::new(0.0, (most / a).hi);
            Some(Landings { lands: Some((t, most)), never: true })
        }
        Landing::Unknown => None,
    }
}

/// Width of the state at the end of a flight beyond which the flight is followed in frames.
const COARSE: f64 = 1e-4;

/// How the other contact is when one rests at the end of a flight that is cut.
#[derive(Debug, Clone, Copy)]
pub(super) struct Remainder {
    /// Bounds of the gap and of its rate, for each contact.
    pub(super) h: [I; 2],
    pub(super) u: [I; 2],
    /// Duration of the whole flight.
    t: I,
}

/// How the flights after the corners at contact 1 and at contact 2 with landing speed 1 end.
pub(super) struct Flights {
    pub(super) ends: [Flight; 2],
    pub(super) cut: [Option<Remainder>; 2],
}

impl Flights {
    /// `cuts`: whether flights are cut.
    pub(super) fn of(local: &Local, cuts: bool) -> Self {
        let lets_go = [0, 1].map(|k| local.lets_go(k));
        let mut model = Model::new(local.g, local.psi, local.e, 2);
        model.between.clone_from(&local.between);
        let energy = local.energy().filter(|_| cuts);
        let mut ends = [0, 1].map(|j| Flight::after_corner(&model, j, lets_go, energy.as_ref()));
        let open = |flight: &Flight| flight.energy_left() > CUT_ENERGY || flight.width() > COARSE;
        if ends.iter().any(open) {
            let fine = |x: [I; 2]| x.map(|x| Ball::containing(x.bounds()));
            let mut fine = Model::new(fine(local.g), fine(local.psi), fine(local.e), 2);
            fine.between = local.between.iter().map(|x| Ball::containing(x.bounds())).collect();
            for j in 0..2 {
                // If one remains unknown, the other one rarely decides.
                if open(&ends[j]) && (j == 0 || ends[0] != Flight::Unknown) {
                    let finer =
                        Flight::after_corner_finely(&model, &fine, j, lets_go, energy.as_ref());
                    let less = |of: &dyn Fn(&Flight) -> f64| of(&finer) < of(&ends[j]);
                    if less(&Flight::energy_left)
                        || finer.energy_left() == ends[j].energy_left() && less(&Flight::width)
                    {
                        ends[j] = finer;
                    }
                }
            }
        }
        let is_cut = |flight: &Flight| matches!(flight, Flight::Cut { .. });
        let settles = match &energy {
            Some(energy) if ends.iter().any(is_cut) => settling(local, energy.weights),
            _ => 0.0,
        };
        let cut = ends.map(|flight| match (flight, &energy) {
            (Flight::Cut { energy: left, t }, Some(energy)) => {
                // At the end, where one contact rests: 2E = u² (D⁻¹)_mm + 2 λ_m h for the other one.
                let left = I::from(left);
                let rate = |m: usize| (left / energy.inverse[m][m]).sqrt().hi;
                let gap = |m: usize| (left / energy.weights[m].times(2.0)).hi;
                Some(Remainder {
                    h: [0, 1].map(|m| I::new(0.0, gap(m))),
                    u: [0, 1].map(|m| I::new(-rate(m), rate(m))),
                    t: t + I::new(0.0, (I::from(settles) * left.sqrt()).hi),
                })
            }
            _ => None,
        });
        Self { ends, cut }
    }
}

impl Slide<'_> {
    fn speed(&self) -> I {
        self.cell.xi + self.from * self.cell.y
    }
}

impl CornerMap {
    /// The same map with flights that are followed to their end, if some are cut.
    pub(crate) fn followed(&self) -> Option<Self> {
        self.remainders.iter().any(Option::is_some).then(|| {
            let flights = Flights::of(&self.local, false);
            Self { flights: flights.ends, remainders: flights.cut, ..self.clone() }
        })
    }

    pub(super) fn of(local: Local, jams: Jams) -> Self {
        // The sign of v_t for ξ < 0 and for ξ > 0.
        let sides =
            [0, 1].map(|k| if local.alpha[k].is_positive() { [-1.0, 1.0] } else { [1.0, -1.0] });
        let slides = [0, 1].map(|k| sides[k].map(|side| local.slide(k, side)));
        let ends = |k: usize, side: f64| jams == Jams::Impact && local.jams_alone(k, side);
        let jump = |k: usize| sides[k].map(|side| ends(k, side).then(|| local.jump(k)));
        let flights = Flights::of(&local, true);
        Self {
            flights: flights.ends,
            remainders: flights.cut,
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

    /// Returns true if the flight after some corner is not certain to its end, while much of its energy is left.
    pub(crate) fn flies_far(&self) -> bool {
        self.flights.iter().any(|flight| flight.energy_left() > CUT_ENERGY)
    }

    /// Time from a corner at j with y = 1 to the Zeno point after it.
    pub(super) fn flight_time(&self, j: usize) -> Option<I> {
        match self.flights[j] {
            Flight::One { t, .. } | Flight::Two { t } => Some(t),
            Flight::Cut { .. } => self.remainders[j].map(|remainder| remainder.t),
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
            Flight::One { .. } | Flight::Cut { .. } => {
                for start in self.slides_after(j, cell).iter().flatten() {
                    self.parts(start.speed(), &mut images, |side, xi, images| {
                        self.slide(start, side, xi, images);
                    });
                }
                if let Some(Remainder { t, .. }) = self.remainders[j] {
                    self.together(cell.xi + (shift + l.drift * t) * cell.y, &mut images);
                }
            }
        }
        images
    }

    /// The slides that may follow the corners of a cell at contact j, when one contact rests at the end of the flight and the other one is
    /// in the air: of each contact, if the flight is cut.
    fn slides_after<'c>(&self, j: usize, cell: &'c Cell) -> [Option<Slide<'c>>; 2] {
        let l = &self.local;
        let shift = l.beta[1 - j][j] / l.alpha[1 - j];
        let of = |k: usize, h: I, u: I, t: I| {
            let from = shift + l.drift * t + l.beta[k][1 - k] / l.alpha[k] * u;
            Some(Slide { k, from, h, u, cell })
        };
        match (self.flights[j], &self.remainders[j]) {
            (Flight::One { kept, h, u, t }, _) => [of(kept, h, u, t), None],
            (_, Some(Remainder { h, u, t })) => {
                [0, 1].map(|k| if l.lets_go(k) { None } else { of(k, h[1 - k], u[1 - k], *t) })
            }
            _ => [None, None],
        }
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
        let Some(Landings { lands, never }) = landings(h, u, arc.normal) else {
            return images.push(Image::Unknown);
        };
        if let Some((t, factor)) = lands {
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
                    most: form.most(cell).max(0.0).sqrt().next_up().min(length([part, y])),
                });
            }
            match slows {
                Some(-1) if !never && end.times(sign).lo <= 0.0 => {
                    let stop = -xi / arc.along;
                    let stop = I::new(stop.lo.max(0.0), stop.hi.min((t * y).hi));
                    if stop.lo <= stop.hi {
                        self.stop(start, side, &arc, stop, images);
                    }
                }
                Some(_) => {}
                None => images.push(Image::Unknown),
            }
        }
        if never {
            self.lift(start, side, &arc, xi, images);
        }
    }

    /// Contact k slides at the speed `xi`, and the other contact does not land before it stops.
    fn lift(&self, start: &Slide, side: i8, arc: &Arc, xi: I, images: &mut Images) {
        match arc.along.times(f64::from(side)).sign() {
            Some(-1) => {
                let stop = -xi / arc.along;
                self.stop(start, side, arc, I::new(stop.lo.max(0.0), stop.hi), images);
            }
            Some(_) => images.push(Image::Escape),
            None => images.push(Image::Unknown),
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
        // Below zero the other contact has landed before: that is another image.
        let Some(gap) = gap.non_negative() else { return };
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
        let Some(Landings { lands, never }) = landings(h, u, arc.normal) else {
            return images.push(Image::Unknown);
        };
        if let Some((t, y)) = lands {
            let xi = arc.along * t;
            let size = length([xi, y]);
            images.push(Image::Corner {
                contact: m,
                xi,
                y,
                slope: tangent(xi, y),
                most: most.map_or(size, |most| most.min(size)),
            });
        }
        if never {
            images.push(Image::Escape);
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

    /// The corners that follow those at j near a fast-slide end (φ near ±π/2): ξ' = ξ + B y, y' = K y. `None` if not all is known there.
    pub(crate) fn fast(&self, j: usize, right: bool) -> Option<FastSlides> {
        if matches!(self.flights[j], Flight::Away | Flight::Unknown) {
            return None;
        }
        let cell = Cell::new(0.0, 0.0);
        let mut found =
            FastSlides { next: [None; 2], ends: self.flights[j].may_rest_both(), leaves: false };
        for Slide { k, from, h, u, .. } in self.slides_after(j, &cell).into_iter().flatten() {
            let arc = self.slides[k][usize::from(right)]?;
            let Landings { lands, never } = landings(h, u, arc.normal)?;
            found.leaves |= never;
            found.next[1 - k] =
                lands.map(|(time, factor)| Fast { from, b: from + arc.along * time, k: factor });
        }
        Some(found)
    }

    /// The images of a cell at a fast-slide end in which no corner follows there: contact j has landed, the contact that slides on slows
    /// down, and the other one does not land before it stops.
    pub(crate) fn leaving(&self, j: usize, cell: &Cell, right: bool, images: &mut Images) {
        let side = if right { 1 } else { -1 };
        for start in self.slides_after(j, cell).iter().flatten() {
            let Some(arc) = self.slides[start.k][usize::from(right)] else {
                images.push(Image::Unknown);
                continue;
            };
            match landings(start.h, start.u, arc.normal) {
                Some(Landings { never: false, .. }) => {}
                Some(_) => self.lift(start, side, &arc, start.speed(), images),
                None => images.push(Image::Unknown),
            }
        }
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
    use crate::body::contact::Contact;
    use crate::body::posture::Posture;
    use crate::body::state::State;
    use crate::body::{Lamina, PostureFields};
    use crate::options::{Impact, Model as Mode, Options, Stop};
    use crate::simulate::simulate;
    use proptest::prelude::*;

    use super::*;
    use crate::math::cases::fixed;
    use crate::stability::tests::odd;

    fn map_of(posture: &Posture) -> Option<CornerMap> {
        Local::new(posture, 0.0).map(|local| CornerMap::of(local, Jams::None))
    }

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
        let map = map_of(&rod).expect("a corner map");
        let near = |x: I, exact: f64| x.lo <= exact && exact <= x.hi && x.hi - x.lo < 1e-13;
        for (j, right) in [(0, false), (0, true), (1, false), (1, true)] {
            let slides = map.fast(j, right).expect("a slide");
            let (next, Fast { b: bend, k: factor, .. }) = slides.only().expect("one corner");
            assert!(next == 1 - j && near(factor, 0.6) && near(bend, 0.0), "{factor:?} {bend:?}");
            assert!(near(map.flight_time(j).expect("bounces"), 0.5));
        }
    }

    /// Numbers in [0, 1), evenly distributed.
    fn share(k: usize, factor: f64) -> f64 {
        (k as f64 * factor).fract()
    }

    /// The ends of flights that are cut, as runs find them from starts within the width, lie in the sets of all ends. Sets ten times smaller would
    /// not contain them.
    #[test]
    fn the_ends_of_cut_flights_lie_in_their_sets() {
        let width = 1e-12;
        // The largest ratios of a gap, of a gap rate, and of the remaining time to their bounds.
        let (mut flights, mut largest) = (0, [0.0_f64; 3]);
        for k in 0..600 {
            let at = |factor, low: f64, high: f64| low + (high - low) * share(k + 1, factor);
            let foot = |x: f64, y: f64, slope: f64| Contact::at(x, y).on_slope(slope);
            let posture = Posture::new(PostureFields {
                mass: 1.0,
                gyration_radius: at(0.414_213_562, 0.3, 1.2),
                center_of_mass: [at(0.732_050_807, -0.9, 0.9), at(0.236_067_977, -0.5, 1.5)],
                contacts: vec![
                    foot(-1.0, 0.0, at(0.645_751_311, -0.8, 0.8)),
                    foot(1.0, 0.0, at(0.316_624_790, -0.8, 0.8)),
                ],
                restitution: at(0.618_033_988, 0.6, 0.97),
                gravity: 1.0,
                ..PostureFields::default()
            })
            .expect("a posture");
            let Some(local) = Local::new(&posture, width) else { continue };
            let map = CornerMap::of(local, Jams::None);
            for j in 0..2 {
                let (Flight::Cut { t: before, .. }, Some(set)) =
                    (map.flights[j], map.remainders[j])
                else {
                    continue;
                };
                flights += 1;
                for n in 0..12 {
                    // The other contact rests, j lands with speed 1; the numbers are changed within the width.
                    let wide = |factor| 1.0 + width * (2.0 * share(12 * k + n, factor) - 1.0);
                    let mut fields = posture.fields().clone();
                    fields.restitution *= wide(0.123_105_625);
                    fields.gyration_radius *= wide(0.358_898_943);
                    fields.contacts[0].point[0] *= wide(0.898_943_540);
                    let changed = Posture::new(fields).expect("a posture");
                    let rows = changed.geometry();
                    let row = |i: usize| [rows[i].normal.x, rows[i].normal.y, rows[i].b];
                    let matrix = nalgebra::Matrix3::from_rows(&[
                        row(1 - j).into(),
                        row(j).into(),
                        [rows[0].tangent.x, rows[0].tangent.y, -rows[0].touching_c()].into(),
                    ]);
                    let rates = nalgebra::Vector3::new(0.0, -1.0, 0.3);
                    let qdot = matrix.lu().solve(&rates).expect("independent rows");
                    let start = State::new([0.0; 3], qdot.into());
                    let options = Options {
                        model: Mode::Local,
                        stop: Stop::Zeno,
                        impact: Impact::Newton,
                        ..Options::default()
                    };
                    let run = simulate(&changed, &start, &options).expect("a run");
                    let Some(zeno) = run.zeno_points().first() else { continue };
                    let elapsed = zeno.elapsed;
                    assert!(set.t.lo - 1e-6 <= elapsed && elapsed <= set.t.hi, "{elapsed} {set:?}");
                    let part = (elapsed - before.hi) / (set.t.hi - before.hi);
                    largest[2] = largest[2].max(part);
                    for m in 0..2 {
                        let (h, u) = (zeno.gaps[m], zeno.gap_rates[m]);
                        let parts = [h / set.h[m].hi, u.abs() / set.u[m].hi];
                        assert!(parts.iter().all(|part| *part <= 1.0), "{parts:?} {posture:?} {j}");
                        largest = [largest[0].max(parts[0]), largest[1].max(parts[1]), largest[2]];
                    }
                }
            }
        }
        assert!(flights > 100, "{flights}");
        assert!(largest.iter().all(|part| *part > 0.1), "{flights} {largest:?}");
        println!("{flights} {largest:?}");
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
            let map = map_of(&Posture::new(above).expect("a posture")).expect("a corner map");
            let [one, two] = [(0, 1.0), (1, -1.0)].map(|(j, side)| corners(&map.images(j, &Cell::point(side * phi)), side));
            prop_assert_eq!((one.0.len(), one.1), (two.0.len(), two.1));
            for (i, image) in one.0 {
                let found = two.0.iter().any(|(j, other)| i == 1 - j && meets(image, *other));
                prop_assert!(found, "{image:?} {:?}", two.0);
            }
        }

        #[test]
        fn the_images_of_a_cell_contain_those_of_its_corners(
            low in -1.5..1.2, width in 0.001..0.3, share in 0.0..1.0, e in 0.01..0.4, j in 0..2_usize,
        ) {
            let map = map_of(&odd(e)).expect("a corner map");
            let (all, others) = corners(&map.images(j, &Cell::new(low, low + width)), 1.0);
            for (i, point) in corners(&map.images(j, &Cell::point(low + share * width)), 1.0).0 {
                let found = all.iter().any(|(contact, image)| *contact == i && meets(point, *image));
                prop_assert!(found || others > 0, "{i} {point:?} {all:?}");
            }
        }
    }
}
