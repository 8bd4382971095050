//! Any number of contacts: what the energy alone decides.
//!
//! In the local model the states of a body that does not enter the ground are q in the cone K = {N q ≥ 0}. Let E = ½‖q̇‖² + g y per unit
//! mass, with ‖q̇‖² = ẋ² + ẏ² + ρ²θ̇². Gravity is in E, contact forces do no positive work on fixed rows, and impacts lose energy: E never
//! rises. So the rise y on K decides how far the body can go. Let K be pointed with an interior, in general position. Each of its extreme
//! rays closes exactly two contacts, a *pair*, and the body leaves a ray only if it opens one of them. A contact is *exposed* if it is in a
//! pair: only exposed contacts can be closed alone.
//!
//! * *Existence.* From every state a motion exists iff no exposed contact jams while it slides alone, and no pair jams while both slide
//!   along its ray, in both directions.
//! * *Well.* y > 0 on all rays. Every motion stays within max(|x|, |y|, ρ|θ|) ≤ E/(g w), with w the least y of a ray over its largest
//!   component. The posture is stable iff a motion always exists.
//! * *Descending pair.* y < 0 on exactly one ray. E ≥ 0 bounds the body wherever a contact outside this pair is closed; between such times
//!   the pair acts alone. The posture is stable iff a motion always exists and the pair is stable as a posture on two contacts. It is
//!   unstable if the pair is: a motion that starts far down the ray with a small kick touches no other contact.
//!   If several rays descend and none of their pairs holds the body, the posture is unstable.
//! * *Neutral.* N has rank 2, y = 0 along its kernel and y > 0 on the rest of K, and all contacts have friction: level ground with the
//!   centre of mass between the outer contacts, or two contacts that are mirror images. The posture is stable iff a motion always exists.
//!   A posture whose other rays ascend is stable if the pair of its one level ray is.
//!
//! Where jams end by plastic impacts a motion always exists, and a jam loses energy like an impact.
//!
//! These hold for every restitution e < 1. Each sign is certain (intervals), or nothing is decided.

use nalgebra::Vector3;
use serde::{Deserialize, Serialize};

use crate::body::posture::Posture;
use crate::error::{Error, non_negative};
use crate::math::interval::Interval;
use crate::math::real::Enclosed;
use crate::math::unsigned_zero::UnsignedZero;
use crate::modes::{Mode, Word};
use crate::options::{Impact, Jams};
use crate::outcome::ContactNumber;
use crate::stability::certify::WhyUndecided;
use crate::stability::conditions::with_contacts;
use crate::stability::existence::{self, Standing};
use crate::stability::jams::NoMotion;
use crate::stability::local::{Local, Row, length};
use crate::stability::{
    Argument, Details, Evidence, Finding, Stability, StabilityOptions, Verdict, judge,
    judge_carrying, undecided,
};

type I = Interval;

/// A direction in which the body can move while exactly two contacts stay on their ground: an extreme ray of {q : N q ≥ 0}.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Ray {
    /// The two contacts.
    pub contacts: [ContactNumber; 2],
    /// (x, y, θ) in m, m, rad, with x² + y² + ρ²θ² = 1. The ray descends if y < 0.
    pub direction: [f64; 3],
}

/// A posture that the body cannot leave with little energy.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Well {
    /// w: least y/max(|x|, |y|, ρ|θ|) over all q that no contact forbids.
    pub width: f64,
    /// m g, in N.
    pub weight: f64,
}

impl Well {
    /// A bound of max(|x|, |y|, ρ|θ|), in m, for all motions with at most this energy ½m(ẋ² + ẏ² + ρ²θ̇²) + m g y, in J.
    ///
    /// # Errors
    ///
    /// [`Error::OutOfRange`] unless `energy` is finite and not negative.
    pub fn radius(&self, energy: f64) -> Result<f64, Error> {
        let energy = non_negative("energy", energy)?;
        Ok((I::from(energy) / (I::near(self.weight) * I::from(self.width))).hi)
    }
}

/// The verdict on a pair of contacts as the only contacts.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct PairVerdict {
    /// The two contacts.
    pub contacts: Vec<ContactNumber>,
    /// The verdict.
    pub frictional_stability: Stability,
    /// Its argument.
    pub by: Option<Argument>,
    /// The data of the argument.
    pub evidence: Option<Box<Evidence>>,
}

/// An extreme ray with the constants of its pair.
struct KnownRay {
    /// Places of the two contacts, from 0.
    pair: [usize; 2],
    /// (x, y, θ)
    z: [I; 3],
    /// Sign of y; `None` if it is not certain.
    rise: Option<i8>,
    local: Local,
}

/// Whether two contacts are mirror images in the vertical line through the centre of mass, exactly. Then the direction in which both slide
/// has no vertical part.
fn are_mirrored(posture: &Posture, [i, j]: [usize; 2]) -> bool {
    let [one, two] = [i, j].map(|k| posture.contacts()[k]);
    let ([a, b], x) = ([one.point[0], two.point[0]], posture.fields().center_of_mass[0]);
    let sum = a + b;
    // The rounding error of the sum [Knuth].
    let part = sum - a;
    let error = (a - (sum - part)) + (b - part);
    error == 0.0
        && sum == 2.0 * x
        && one.point[1] == two.point[1]
        && one.slope == -two.slope
        && a != b
}

/// The rays of K; `None` if they are not certain, or if K may have no interior.
fn rays(posture: &Posture, width: f64) -> Option<Vec<KnownRay>> {
    let f = posture.fields();
    let rows: Vec<Row> = f.contacts.iter().map(|k| Row::of(k, f.center_of_mass, width)).collect();
    let mut found = Vec::new();
    for i in 0..rows.len() {
        for j in i + 1..rows.len() {
            let z = rows[i].along_both(&rows[j]);
            let others = || (0..rows.len()).filter(|k| *k != i && *k != j);
            for z in [z, z.map(|part| -part)] {
                let signs = || others().map(|k| rows[k].opens(z).sign());
                if signs().any(|sign| sign == Some(-1)) {
                    continue;
                }
                if signs().any(|sign| sign != Some(1)) {
                    return None;
                }
                let level = are_mirrored(posture, [i, j]);
                let rise = if level { Some(0) } else { z[1].sign() };
                let local = Local::of(f, [&f.contacts[i], &f.contacts[j]], width)?;
                found.push(KnownRay { pair: [i, j], z, rise, local });
            }
        }
    }
    // With a ray that opens a third contact, K has an interior and is pointed.
    (!found.is_empty()).then_some(found)
}

impl KnownRay {
    fn unit(&self, rho2: I) -> Vector3<f64> {
        let size = length(self.z, rho2);
        Vector3::from(self.z.map(|part| (part / size).middle())).unsigned_zero()
    }

    /// y/max(|x|, |y|, ρ|θ|)
    fn slope(&self, rho: f64) -> I {
        let [x, y, turn] = self.z;
        let wide = |part: I| part.square().sqrt();
        let (x, turn) = (wide(x), wide(turn) * I::from(rho));
        let most = |a: I, b: I| I::new(a.lo.max(b.lo), a.hi.max(b.hi));
        y / most(most(x, wide(y)), turn)
    }
}

/// Whether a motion exists from every state.
enum Existence {
    Certain,
    Fails(NoMotion),
    Unknown,
}

/// Whether contact `which` of a pair, which slides alone in this direction, goes on; `None` if the intervals do not decide.
fn slides_on(local: &Local, which: usize, side: f64) -> Option<bool> {
    if local.stiffness(which, side).is_positive() || local.g[which].hi <= 0.0 {
        return Some(true);
    }
    local.jams_alone(which, side).then_some(false)
}

/// Existence for a body whose cone has these rays.
fn existence(posture: &Posture, rays: &[KnownRay], rho2: I) -> Existence {
    let standing = Standing::Body(posture);
    let mut known = true;
    for ray in rays {
        for (which, &contact) in ray.pair.iter().enumerate() {
            for side in [1.0, -1.0] {
                match slides_on(&ray.local, which, side) {
                    Some(true) => {}
                    None => known = false,
                    Some(false) => {
                        // Between this ray and the other one of the facet only this contact is closed.
                        let on_facet = |other: &&KnownRay| {
                            other.pair.contains(&contact) && other.pair != ray.pair
                        };
                        let Some(next) = rays.iter().find(on_facet) else { continue };
                        let open = ray.unit(rho2) + next.unit(rho2);
                        let k = ray.local.stiffness(which, side).middle();
                        let slides = [(contact, side)];
                        let found = existence::start(
                            standing,
                            &slides,
                            ray.pair[1 - which],
                            Some(k),
                            open.as_slice(),
                        );
                        if let Some(start) = found {
                            return Existence::Fails(start);
                        }
                    }
                }
            }
        }
        for side in [1.0, -1.0] {
            match ray.local.goes_on(side) {
                Some(true) => {}
                None => known = false,
                Some(false) => {
                    let slides =
                        [0, 1].map(|i| (ray.pair[i], side * ray.local.alpha[i].middle().signum()));
                    let open = ray.unit(rho2);
                    if let Some(start) =
                        existence::start(standing, &slides, ray.pair[1], None, open.as_slice())
                    {
                        return Existence::Fails(start);
                    }
                }
            }
        }
    }
    if known { Existence::Certain } else { Existence::Unknown }
}

/// The two contacts that bear a body whose kernel of N is level: the outer ones on level ground, or two mirror images.
fn level_pair(posture: &Posture) -> Option<[usize; 2]> {
    let contacts = posture.contacts();
    if contacts.len() == 2 && are_mirrored(posture, [0, 1]) {
        return Some([0, 1]);
    }
    if contacts.iter().any(|contact| contact.slope != 0.0) {
        return None;
    }
    let outer = |right: bool| {
        let x = |k: &usize| contacts[*k].point[0] * if right { 1.0 } else { -1.0 };
        let last = (0..contacts.len()).max_by(|a, b| x(a).total_cmp(&x(b)))?;
        (0..contacts.len()).all(|k| k == last || x(&k) < x(&last)).then_some(last)
    };
    let (left, right) = (outer(false)?, outer(true)?);
    (left != right).then_some([left, right])
}

/// Contacts on a line that two others carry, the outer ones of the line.
pub(super) struct Carried {
    /// Places of all other contacts.
    pub(super) others: Vec<usize>,
    /// The outer contacts of each line, by their places among the others, and the places on the line of those between them, from 0 to 1.
    lines: Vec<([usize; 2], Vec<I>)>,
    /// The contacts that are carried, and the outer contacts of their line, by their places in the posture.
    inner: Vec<(usize, [usize; 2])>,
}

impl Carried {
    /// `None` if no contact is carried.
    ///
    /// On a line of ground with equal normals the gap of a contact between two others is a mean of their gaps, and its force is that of two
    /// forces at them. With equal friction the contacts between exert no force on the body that the outer two cannot exert, at rest and while they
    /// slide. With equal restitutions they change its motion only where one outer contact lands beside the other one: see
    /// [`Model::between`](crate::verified::Model).
    pub(super) fn of(posture: &Posture, width: f64) -> Option<Self> {
        let f = posture.fields();
        let contacts = posture.contacts();
        let rows: Vec<Row> = contacts.iter().map(|k| Row::of(k, f.center_of_mass, width)).collect();
        let along = |k: usize| rows[k].b.middle();
        let mut others: Vec<usize> = (0..contacts.len()).collect();
        let (mut lines, mut carried) = (Vec::new(), Vec::new());
        for first in 0..contacts.len() {
            let alike = |k: &usize| {
                let (one, other) = (&contacts[first], &contacts[*k]);
                one.slope == other.slope
                    && one.friction == other.friction
                    && posture.geometry()[first].restitution == posture.geometry()[*k].restitution
                    && !one.is_round()
                    && !other.is_round()
            };
            let mut line: Vec<usize> = (0..contacts.len()).filter(alike).collect();
            line.sort_by(|i, j| along(*i).total_cmp(&along(*j)));
            let (Some(&a), Some(&b)) = (line.first(), line.last()) else { continue };
            if line.len() < 3 || line.iter().min() != Some(&first) {
                continue;
            }
            let inner = &line[1..line.len() - 1];
            let places = inner.iter().map(|k| rows[*k].between(&rows[a], &rows[b], posture.size()));
            let Some(places) = places.collect::<Option<Vec<I>>>() else { continue };
            others.retain(|k| !inner.contains(k));
            carried.extend(inner.iter().map(|k| (*k, [a, b])));
            lines.push(([a, b], places));
        }
        if lines.is_empty() {
            return None;
        }
        for (outer, _) in &mut lines {
            *outer = outer.map(|k| others.iter().filter(|other| **other < k).count());
        }
        Some(Self { others, lines, inner: carried })
    }

    /// The places of the contacts between the contacts of a pair.
    fn between(&self, pair: [usize; 2]) -> Vec<I> {
        let whole = self.lines.iter().find_map(|([a, b], places)| {
            if pair == [*a, *b] {
                Some(places.clone())
            } else if pair == [*b, *a] {
                Some(places.iter().map(|place| I::ONE - *place).collect())
            } else {
                None
            }
        });
        whole.unwrap_or_default()
    }

    /// The finding on the other contacts, with the numbers of all.
    pub(super) fn put_back(&self, found: Finding) -> Finding {
        let count = self.others.len() + self.inner.len();
        let whole = |evidence: Evidence| match evidence {
            // A contact on a line stays on the ground if the outer ones do, and slides as they do.
            Evidence::Word(word) => {
                let mut all = Word::separate(count);
                for (place, letter) in self.others.iter().zip(word.modes()) {
                    all = all.with(*place, letter);
                }
                for (k, outer) in &self.inner {
                    let [one, two] = outer.map(|place| all.modes().nth(place));
                    if let (Some(one), Some(two)) = (one, two)
                        && two != Mode::Separate
                    {
                        all = all.with(*k, one);
                    }
                }
                Evidence::Word(all)
            }
            mut evidence => {
                evidence.renumber(&|number| {
                    *number = ContactNumber::of(self.others[number.index()]);
                });
                evidence
            }
        };
        match found {
            Finding::Decided(stability, by, evidence) => {
                Finding::Decided(stability, by, whole(evidence))
            }
            Finding::Undecided(evidence) => Finding::Undecided(evidence.map(whole)),
        }
    }

    /// The finding for a body on one line of ground: that for its outer contacts.
    fn decide(&self, outer: &Posture, options: StabilityOptions) -> Result<Finding, Error> {
        let between = self.between([0, 1]);
        let pair = pair_verdict(outer, [0, 1], &between, options, Details::NONE)?;
        let pairs = vec![shown_pair(&pair)];
        Ok(match pair.frictional_stability {
            Stability::Undecided => undecided(pair.reason().unwrap_or(WhyUndecided::Pairs)),
            decided => {
                let evidence = Evidence::DescendingPairs { rays: Vec::new(), pairs };
                Finding::Decided(decided, Argument::DescendingPair, evidence)
            }
        })
    }
}

/// The verdict of *Neutral*, if it applies.
pub(super) fn neutral(posture: &Posture, options: StabilityOptions) -> Option<Finding> {
    let StabilityOptions { jams, width } = options;
    let f = posture.fields();
    let pair = level_pair(posture)?;
    let local = Local::of(f, pair.map(|k| &f.contacts[k]), width)?;
    let bears = local.weights().iter().all(|weight| weight.is_positive());
    if !bears || !f.contacts.iter().all(|contact| contact.friction > 0.0) {
        return None;
    }
    let stiffness = [0, 1].map(|which| [1.0, -1.0].map(|side| local.stiffness(which, side)));
    for (which, sides) in stiffness.iter().enumerate() {
        for (k, side) in sides.iter().zip([1.0, -1.0]) {
            if jams == Jams::None && local.jams_alone(which, side) {
                let (standing, slides) = (Standing::Body(posture), [(pair[which], side)]);
                let (apart, other) = (existence::above(standing, pair, which)?, pair[1 - which]);
                let start = existence::start(standing, &slides, other, Some(k.middle()), &apart)?;
                return Some(Finding::Decided(
                    Stability::Unstable,
                    Argument::NoSolution,
                    Evidence::NoMotion(start),
                ));
            }
        }
    }
    let smooth = stiffness.iter().flatten().all(|k| k.is_positive());
    let slides = [1.0, -1.0].into_iter().all(|side| local.goes_on(side) == Some(true));
    (jams == Jams::Impact || smooth && slides).then(|| {
        let evidence = Evidence::Neutral {
            outer: pair.map(ContactNumber::of),
            stiffness: stiffness.map(|sides| sides.map(I::middle)),
        };
        Finding::Decided(Stability::Stable, Argument::Neutral, evidence)
    })
}

/// Returns true if the body stands on level ground and *Neutral* proves that it is stable.
pub(super) fn is_level(posture: &Posture, options: StabilityOptions) -> bool {
    posture.contacts().iter().all(|contact| contact.slope == 0.0)
        && matches!(neutral(posture, options), Some(Finding::Decided(Stability::Stable, ..)))
}

/// The finding for one contact, or for three and more, and the well, if the posture is one. `carried`: contacts that were left out. `moves_away`: a word at rest in which the body
/// moves away.
pub(super) fn decide(
    posture: &Posture,
    carried: Option<&Carried>,
    options: StabilityOptions,
    moves_away: impl FnOnce() -> Result<Option<Word>, Error>,
) -> Result<(Finding, Option<Well>), Error> {
    let open = undecided;
    let f = posture.fields();
    let rho2 = I::from(f.gyration_radius).square();
    if let (Some(carried), 2) = (carried, posture.contacts().len()) {
        return Ok((carried.decide(posture, options)?, None));
    }
    let known = rays(posture, options.width);
    let mut well = None;
    // Where jams end by impacts a motion always exists.
    let mut motion_exists = options.jams == Jams::Impact;
    if let Some(rays) = &known {
        let slopes = rays.iter().map(|ray| ray.slope(f.gyration_radius));
        let width = slopes.map(|slope| slope.lo).fold(f64::INFINITY, f64::min);
        if rays.iter().all(|ray| ray.rise == Some(1)) && width > 0.0 && f.gravity > 0.0 {
            well = Some(Well { width, weight: f.mass * f.gravity });
        }
        if !motion_exists {
            match existence(posture, rays, rho2) {
                Existence::Fails(start) => {
                    let evidence = Evidence::NoMotion(start);
                    let found =
                        Finding::Decided(Stability::Unstable, Argument::NoSolution, evidence);
                    return Ok((found, well));
                }
                Existence::Certain => motion_exists = true,
                Existence::Unknown => {}
            }
        }
        if well.is_some() {
            let found = if motion_exists {
                Finding::Decided(
                    Stability::Stable,
                    Argument::Well,
                    Evidence::Well { width, rays: shown(rays, rho2) },
                )
            } else {
                open(WhyUndecided::Jam)
            };
            return Ok((found, well));
        }
    }
    if let Some(word) = moves_away()? {
        return Ok((
            Finding::Decided(Stability::Unstable, Argument::AcceleratingMode, Evidence::Word(word)),
            None,
        ));
    }
    let Some(rays) = known else { return Ok((open(WhyUndecided::Degenerate), None)) };
    if f.gravity == 0.0 || rays.iter().any(|ray| ray.rise.is_none()) {
        return Ok((open(WhyUndecided::Degenerate), None));
    }
    let core: Vec<&KnownRay> = rays.iter().filter(|ray| ray.rise != Some(1)).collect();
    let mut pairs = Vec::new();
    for ray in &core {
        let between = carried.map(|carried| carried.between(ray.pair)).unwrap_or_default();
        pairs.push(pair_verdict(posture, ray.pair, &between, options, Details::NONE)?);
    }
    let descend = core.iter().all(|ray| ray.rise == Some(-1));
    let evidence = |pairs: &[Verdict]| {
        let pairs = pairs.iter().map(shown_pair);
        Evidence::DescendingPairs { rays: shown(&rays, rho2), pairs: pairs.collect() }
    };
    let found = match pairs.as_slice() {
        [pair] if pair.frictional_stability == Stability::Stable => {
            if motion_exists {
                Finding::Decided(Stability::Stable, Argument::DescendingPair, evidence(&pairs))
            } else {
                open(WhyUndecided::Jam)
            }
        }
        [pair] if descend && pair.frictional_stability == Stability::Unstable => {
            Finding::Decided(Stability::Unstable, Argument::DescendingPair, evidence(&pairs))
        }
        pairs if descend && pairs.iter().all(|pair| !pair.equilibrium.holds) => {
            Finding::Decided(Stability::Unstable, Argument::DescendingPair, evidence(pairs))
        }
        _ => open(WhyUndecided::Pairs),
    };
    Ok((found, None))
}

fn shown(rays: &[KnownRay], rho2: I) -> Vec<Ray> {
    let ray = |ray: &KnownRay| Ray {
        contacts: ray.pair.map(ContactNumber::of),
        direction: ray.unit(rho2).into(),
    };
    rays.iter().map(ray).collect()
}

fn shown_pair(pair: &Verdict) -> PairVerdict {
    PairVerdict {
        contacts: pair.contacts.clone(),
        frictional_stability: pair.frictional_stability,
        by: pair.by,
        evidence: pair.evidence.clone().map(Box::new),
    }
}

/// The verdict on two contacts of a posture as its only ones, with their numbers in the posture. `between`: the places of contacts that they carry.
fn pair_verdict(
    posture: &Posture,
    places: [usize; 2],
    between: &[I],
    options: StabilityOptions,
    details: Details,
) -> Result<Verdict, Error> {
    let pair = with_contacts(posture, &places)?;
    let mut verdict = if between.is_empty() {
        judge(&pair, options, details)?
    } else {
        judge_carrying(&pair, between, options)?
    };
    verdict.renumber(&places);
    Ok(verdict)
}

/// The verdicts on the pairs of contacts that can hold the body alone, one for each extreme ray; empty for fewer than three contacts, and
/// where the rays are not certain.
pub(super) fn holding_pairs(
    posture: &Posture,
    options: StabilityOptions,
) -> Result<Vec<Verdict>, Error> {
    let details = Details { amplification: false, delicate: true };
    let mut found = Vec::new();
    if posture.contacts().len() < 3 {
        return Ok(found);
    }
    let carried = Carried::of(posture, options.width);
    let all = |carried: &Carried| with_contacts(posture, &carried.others);
    let others = carried.as_ref().map(all).transpose()?;
    let known = match &others {
        Some(outer) if outer.contacts().len() == 2 => vec![[0, 1]],
        _ => {
            let rays = rays(others.as_ref().unwrap_or(posture), options.width);
            rays.into_iter().flatten().map(|ray| ray.pair).collect()
        }
    };
    for pair in known {
        let between = carried.as_ref().map(|carried| carried.between(pair)).unwrap_or_default();
        let whole = pair.map(|k| carried.as_ref().map_or(k, |carried| carried.others[k]));
        let verdict = pair_verdict(posture, whole, &between, options, details)?;
        if verdict.equilibrium.holds {
            found.push(verdict);
        }
    }
    Ok(found)
}

/// The laws of impact for which *Well* and *Neutral* hold: those that certainly lose energy in every impact. With friction this asks that no
/// contact jams in an impact, whether exposed or not; Moreau's law also asks that both of its restitutions are equal.
pub(super) fn laws(posture: &Posture) -> Vec<Impact> {
    let f = posture.fields();
    let rho2 = I::from(f.gyration_radius).square();
    let soft = f.contacts.iter().all(|contact| {
        let row = Row::of(contact, f.center_of_mass, 0.0);
        [1.0, -1.0]
            .into_iter()
            .all(|side| row.stiffness(I::from(contact.friction), side, rho2).is_positive())
    });
    let mut laws = vec![Impact::Newton];
    if soft {
        laws.extend([Impact::Poisson, Impact::Stronge]);
        let mut restitutions = posture.geometry().iter().zip(&f.contacts);
        if restitutions.all(|(k, contact)| k.restitution == contact.tangential_restitution) {
            laws.push(Impact::Moreau);
        }
    }
    laws
}
