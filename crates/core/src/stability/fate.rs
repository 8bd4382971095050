//! The end of a clattering motion: one contact bounces alone, both clatter to rest, or the motion repeats on a smaller and
//! smaller scale.

use crate::error::Error;
use crate::outcome::ContactNumber;
use crate::stability::clattering::clattering_bound;
use crate::stability::reduced::{CANCEL_INTERVAL, OrbitEnd, ReducedMap, ReducedStep, Shape};
use crate::tolerance::{CYCLE_REACHED, RECURRENCE, SHAPE_LOST};

/// The kind of end of a clattering motion.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum FateKind {
    /// One contact bounces alone until it rests; the other contact is in the air.
    OneZeno,
    /// Impacts alternate between the contacts for ever, gravity becomes negligible, and both contacts come to rest at the same
    /// time.
    Clattering,
    /// The shape converges to an attracting cycle: the motion repeats on a smaller and smaller scale.
    SelfSimilar,
    /// None of these within the allowed number of impacts: a quasi-periodic or chaotic shape, or slow convergence.
    Other,
    /// Both contacts land at the same instant: the impacts have no order.
    None,
}

impl FateKind {
    /// Its name.
    #[must_use]
    pub fn as_str(self) -> &'static str {
        match self {
            Self::OneZeno => "1-zeno",
            Self::Clattering => "clattering",
            Self::SelfSimilar => "self-similar",
            Self::Other => "other",
            Self::None => "none",
        }
    }
}

/// The end of a clattering motion.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Fate {
    /// Its kind.
    pub kind: FateKind,
    /// The contact that comes to rest in a 1-Zeno.
    pub contact: Option<ContactNumber>,
    /// Whether the kind is proved for the given start. A 1-Zeno is proved, and so is clattering with equal restitutions, unless rounding
    /// errors of the impacts before may have grown to more than 1e-6 of the shape. A cycle is observed, not proved.
    pub certified: bool,
    /// Number of impacts after the first one until the kind is known.
    pub hits: usize,
    /// Number of impacts after which shape and contact repeat: 1 for a 1-Zeno, 2 for clattering.
    pub period: Option<usize>,
    /// Mean logarithm of the factor of all speeds per impact, after these `hits`; NaN if unknown.
    pub sigma: f64,
}

impl Fate {
    fn of(kind: FateKind, hits: usize) -> Self {
        Self { kind, contact: None, certified: false, hits, period: None, sigma: f64::NAN }
    }
}

/// Accumulated rounding errors of an orbit: the covariance matrix (vv, vy, yy) of the errors of the shape (v, y), computed as if the errors
/// of the steps were independent.
#[derive(Clone, Copy, Default)]
struct Spread([f64; 3]);

impl Spread {
    /// The covariance after a step with the tangent map A: A P Aᵀ plus the rounding errors of this step.
    fn after(self, step: &ReducedStep, rounding: [f64; 2]) -> Self {
        let (Self([vv, vy, yy]), [[a, b], [c, d]]) = (self, step.tangent);
        Self([
            a * a * vv + 2.0 * a * b * vy + b * b * yy + rounding[0] * rounding[0],
            a * c * vv + (a * d + b * c) * vy + b * d * yy,
            c * c * vv + 2.0 * c * d * vy + d * d * yy + rounding[1] * rounding[1],
        ])
    }

    /// Returns true if the accumulated errors are small compared with the shape. NaN does not count as small.
    fn is_small(self, shape: &Shape) -> bool {
        let (v, y) = (SHAPE_LOST * (1.0 + shape.rate.abs()), SHAPE_LOST * (1.0 + shape.gap));
        self.0[0] <= v * v && self.0[2] <= y * y
    }
}

impl ReducedMap {
    /// Bounds on the rounding errors of a step, from the largest terms in its sums.
    fn rounding(&self, from: &Shape, step: &ReducedStep) -> [f64; 2] {
        let e = self.frozen.e[step.shape.contact.index()];
        let back = 2.0 / self.frozen.g[from.contact.index()];
        let gap = (back * (1.0 + from.rate.abs()) + from.gap) / (step.factor * step.factor);
        [step.shape.rate.abs() + 2.0 / e, gap].map(|size| f64::EPSILON * size)
    }

    fn ended(&self, end: OrbitEnd, hits: usize) -> Fate {
        match end {
            OrbitEnd::Tie => Fate::of(FateKind::None, hits),
            OrbitEnd::OneZeno(contact) => Fate {
                contact: Some(contact),
                certified: true,
                period: Some(1),
                sigma: libm::log(self.frozen.e[contact.index()]),
                ..Fate::of(FateKind::OneZeno, hits)
            },
        }
    }

    /// Clattering for ever from this shape on, if the certificate holds. For two different restitutions the certificate
    /// neglects gravity, so the coupling must also be above the bound of clattering convergence.
    fn clatters(&self, shape: &Shape, hits: usize) -> Option<Fate> {
        let (a, gaps) = (shape.contact.index(), self.gaps(shape));
        let tail = self.frozen.clatter_tail(a, &gaps)?;
        let [e1, e2] = self.frozen.e;
        if !self.frozen.certainly_clatters(a, &gaps)
            || !(tail.proved || self.psi > clattering_bound([e1, e2]))
        {
            return None;
        }
        // Two impacts multiply the speeds by the larger root of Λ² − (p_1p_2 − e_1 − e_2)Λ + e_1e_2.
        let trace = (1.0 + e1) * (1.0 + e2) * self.psi * self.psi - e1 - e2;
        let root = (trace * trace - 4.0 * e1 * e2).max(0.0).sqrt();
        Some(Fate {
            certified: tail.proved,
            period: Some(2),
            sigma: 0.5 * libm::log(0.5 * (trace + root)),
            ..Fate::of(FateKind::Clattering, hits)
        })
    }

    /// The mean growth over `period` impacts from `shape` on, if an attracting cycle is near. Let x' be the shape after these impacts, x
    /// the shape before, and A the tangent map. The eigenvalues of A must lie in the unit circle, and (1 − A)⁻¹(x' − x) must be small.
    fn attracting_cycle(&self, shape: &Shape, period: usize) -> Option<f64> {
        let (mut now, mut a, mut log) = (*shape, [[1.0, 0.0], [0.0, 1.0]], 0.0);
        for _ in 0..period {
            let step = self.step(&now).ok()?;
            let t = step.tangent;
            a = [0, 1].map(|i| [0, 1].map(|k| t[i][0] * a[0][k] + t[i][1] * a[1][k]));
            log += libm::log(step.factor);
            now = step.shape;
        }
        let trace = a[0][0] + a[1][1];
        let determinant = a[0][0] * a[1][1] - a[0][1] * a[1][0];
        // Both roots of λ² − trace λ + determinant lie in the unit circle (Jury).
        let attracts = determinant < 1.0 && trace.abs() < 1.0 + determinant;
        let (dv, dy) = (now.rate - shape.rate, now.gap - shape.gap);
        let d = (1.0 - a[0][0]) * (1.0 - a[1][1]) - a[0][1] * a[1][0];
        let to_v = ((1.0 - a[1][1]) * dv + a[0][1] * dy) / d;
        let to_y = ((1.0 - a[0][0]) * dy + a[1][0] * dv) / d;
        let near = to_v.abs() <= CYCLE_REACHED * (1.0 + shape.rate.abs())
            && to_y.abs() <= CYCLE_REACHED * (1.0 + shape.gap);
        (attracts && near).then(|| log / period as f64)
    }
}

fn recurs(now: &Shape, before: &Shape) -> bool {
    now.contact == before.contact
        && (now.rate - before.rate).abs() <= RECURRENCE * (1.0 + before.rate.abs())
        && (now.gap - before.gap).abs() <= RECURRENCE * (1.0 + before.gap)
}

impl ReducedMap {
    /// The end of a motion, followed for `n` impacts at most.
    ///
    /// A 1-Zeno is decided exactly, and clattering by its certificate. To find a cycle, each shape is compared with a stored shape. The
    /// stored shape is replaced after 1, 2, 4, … impacts (Brent's scheme). A shape that recurs counts as a cycle if its tangent map
    /// contracts.
    ///
    /// ```
    /// use standfast::body::{LocalModel, LocalModelFields};
    /// use standfast::stability::{FateKind, ReducedMap};
    ///
    /// // Inside the bound of clattering convergence: both contacts are hit in turn until both rest.
    /// let (gravity, psi, restitution) = ([1.0; 2], [0.9; 2], [0.1; 2]);
    /// let model = LocalModel::new(LocalModelFields { gravity, psi, restitution, ..LocalModelFields::default() })?;
    /// let fate = ReducedMap::new(&model)?.fate([0.0, 0.1], [0.1, -1.9], 1000, &|| false)?;
    /// assert_eq!(fate.kind, FateKind::Clattering);
    /// # Ok::<(), standfast::Error>(())
    /// ```
    ///
    /// # Errors
    ///
    /// As [`ReducedMap::orbit`]; [`Error::Cancelled`] once `cancel`, which is called from time to time, returns true.
    pub fn fate(
        &self,
        gaps: [f64; 2],
        rates: [f64; 2],
        n: usize,
        cancel: &dyn Fn() -> bool,
    ) -> Result<Fate, Error> {
        let mut shape = match self.start(gaps, rates)?.first {
            Ok(shape) => shape,
            Err(end) => return Ok(self.ended(end, 0)),
        };
        // The stored shape, impacts since, impacts until it is replaced, and whether a recurrence to it was already rejected.
        let (mut kept, mut since, mut keep, mut tried) = (shape, 0, 1, false);
        let mut spread = Spread::default();
        let of_the_start = |spread: Spread, shape: &Shape, fate: Fate| Fate {
            certified: fate.certified && spread.is_small(shape),
            ..fate
        };
        for hits in 0..n {
            if hits % CANCEL_INTERVAL == CANCEL_INTERVAL - 1 && cancel() {
                return Err(Error::Cancelled);
            }
            if let Some(fate) = self.clatters(&shape, hits) {
                return Ok(of_the_start(spread, &shape, fate));
            }
            shape = match self.step(&shape) {
                Ok(step) => {
                    spread = spread.after(&step, self.rounding(&shape, &step));
                    step.shape
                }
                Err(end) => return Ok(of_the_start(spread, &shape, self.ended(end, hits))),
            };
            since += 1;
            if !tried && recurs(&shape, &kept) {
                if let Some(sigma) = self.attracting_cycle(&kept, since) {
                    let (period, hits) = (Some(since), hits + 1);
                    let fate = Fate { period, sigma, ..Fate::of(FateKind::SelfSimilar, hits) };
                    return Ok(fate);
                }
                tried = true;
            }
            if since == keep {
                (kept, since, keep, tried) = (shape, 0, 2 * keep, false);
            }
        }
        Ok(Fate::of(FateKind::Other, n))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::body::local_model::{LocalModel, LocalModelFields};
    use crate::stability::clattering::{neimark_sacker, self_similar};

    fn fate(e: f64, psi: f64, n: usize) -> Fate {
        let model = LocalModel::new(LocalModelFields {
            gravity: [1.0; 2],
            psi: [psi; 2],
            restitution: [e; 2],
            ..LocalModelFields::default()
        })
        .unwrap();
        ReducedMap::new(&model).unwrap().fate([0.0, 0.1], [0.1, -1.0], n, &|| false).unwrap()
    }

    #[test]
    fn each_fate_has_its_example() {
        let clattering = fate(0.1, 0.9, 100);
        assert_eq!((clattering.kind, clattering.certified), (FateKind::Clattering, true));
        let one = fate(0.1, 0.1, 100);
        assert_eq!((one.kind, one.certified, one.sigma), (FateKind::OneZeno, true, 0.1_f64.ln()));
        assert_eq!(fate(0.9, 0.22, 10_000).kind, FateKind::Other);
    }

    #[test]
    fn below_the_bound_it_is_self_similar() {
        let (e, psi) = (0.5, 0.9);
        let orbit = self_similar(e, psi).unwrap();
        assert!(orbit.stable && psi > neimark_sacker(e));
        let found = fate(e, psi, 100_000);
        assert_eq!((found.kind, found.period), (FateKind::SelfSimilar, Some(2)));
        assert!((found.sigma - orbit.factor.ln()).abs() < 1e-9, "{found:?}");
    }
}
