//! The speed below which every kick comes back, in the full model: the barrier around a well, and around a body on level ground.
//!
//! Let r be the displacement of the centre of mass, R the turn by θ, a_i the arm of contact i. Its gap is h_i = n_i·(r + (R − 1)a_i). For a
//! fixed θ the gaps are affine in r; let V(θ) be the least height r_y at which no gap is negative. A linear programme gives it, and each
//! pair of contacts a bound from below:
//!
//! ```text
//! e_y = λ_i n_i + λ_j n_j, λ ≥ 0   ⇒   V ≥ λ_i d_i + λ_j d_j     d_i = −n_i·(R − 1)a_i = c_i(1 − cos θ) − b_i sin θ
//! ```
//!
//! From rest in the posture a kick of speed v gives the energy ½v² per unit mass, which never rises: r_y ≤ H = v²/2g. If V(Θ_-), V(Θ_+) ≥ H
//! at two angles Θ_- < 0 < Θ_+, the body stays between them. There it comes to rest where it stood, if for all θ, at heights of at most H,
//!
//! * *a motion exists*: no contact jams alone, and no two that may be closed together jam while both slide, turning at any rate that the
//!   energy allows;
//! * *no motion keeps its energy*: every contact that may be closed has friction and is below the centre of mass;
//! * *it rests on two contacts*: none that is closed is straight below the centre of mass;
//! * *it rests near its posture*: where two contacts are closed, the gaps of all others are small, as those of a body that has come back: see [`robustness`](mod@crate::robustness).
//!
//! For in the limit the energy is constant. Then nothing slides under load, no impact is due, and the body flies, rolls about one contact,
//! or rests. In flight r̈_y = −g. While it rolls about a contact below the centre of mass r̈_y = −g b_y²/(b_y² + c_y² + ρ²) − ω²|c_y| with
//! the horizontal and vertical arms b_y, c_y: negative. ṙ_y is continuous. So no interval of motion ends, and none lasts for ever above the
//! ground. On level ground all this holds up to a shift, and a body that slides flat has friction: see *Neutral* in `feet.rs`.

use crate::body::contact::Contact;
use crate::body::posture::Posture;
use crate::math::interval::Interval;
use crate::math::real::Enclosed;
use crate::stability::local::{Local, Row, solve};
use crate::tolerance::{HOVERS, TOUCH, TRIGONOMETRIC_ERROR};

type I = Interval;

/// Angles of a quarter turn, at which the barrier may be.
const STEPS: usize = 192;

/// How often the range of the height is halved.
const HALVINGS: usize = 16;

/// Angles θ, by the intervals of their sine and cosine.
#[derive(Clone, Copy)]
struct Turn {
    cos: I,
    sin: I,
    /// 1 − cos θ
    fallen: I,
    /// Limits of |θ|.
    size: [f64; 2],
    /// tan |θ/2|
    half: I,
    /// The sign of θ.
    side: f64,
}

/// The size of the step k.
fn angle(k: usize) -> f64 {
    std::f64::consts::FRAC_PI_2 * k as f64 / STEPS as f64
}

impl Turn {
    /// From |θ| = `from` to `to`, at most a quarter turn, to the left (side 1) or to the right (side −1).
    fn new(from: f64, to: f64, side: f64) -> Self {
        let wide = |lo: f64, hi: f64| I::new(lo - TRIGONOMETRIC_ERROR, hi + TRIGONOMETRIC_ERROR);
        let sin = wide(libm::sin(from), libm::sin(to));
        let half = wide(libm::sin(0.5 * from), libm::sin(0.5 * to));
        let fallen = half.square().times(2.0);
        let cos = wide(libm::cos(to), libm::cos(from));
        let half = half / wide(libm::cos(0.5 * to), libm::cos(0.5 * from));
        Self { cos, sin: sin.times(side), fallen, size: [from, to], half, side }
    }
}

struct Barrier<'p> {
    posture: &'p Posture,
    rows: Vec<Row>,
    /// Contacts in the air, with their gaps.
    others: Vec<(Row, I)>,
    rho2: I,
    width: f64,
}

/// The line of ground of a contact for a turned body: n·r ≥ d.
#[derive(Clone, Copy)]
struct Line {
    n: [I; 2],
    d: I,
}

impl Line {
    fn is_level(&self) -> bool {
        self.n[0] == I::ZERO && self.n[1].is_positive()
    }

    fn gap(&self, at: [I; 2]) -> I {
        self.n[0] * at[0] + self.n[1] * at[1] - self.d
    }
}

/// The solution of two linear equations, if it is certain that there is one.
fn certain(solution: [I; 2]) -> Option<[I; 2]> {
    solution.iter().all(|x| x.lo.is_finite() && x.hi.is_finite()).then_some(solution)
}

/// λ with e_y = λ_1 n_1 + λ_2 n_2; `None` if the lines may be parallel.
fn shares(one: &Line, two: &Line) -> Option<[I; 2]> {
    let rows = [[one.n[0], two.n[0]], [one.n[1], two.n[1]]];
    certain(solve(rows, [I::ZERO, I::ONE]))
}

/// The point of two lines; `None` if they may be parallel.
fn crossing(one: &Line, two: &Line) -> Option<[I; 2]> {
    certain(solve([one.n, two.n], [one.d, two.d]))
}

/// The guaranteed speed, √(ẋ² + ẏ² + ρ²θ̇²) in m/s, of a posture that stands in a well or on level ground; `None` if no speed is certain,
/// or if the body or its ground are more than points on straight lines that have no ends. `standing`: with those contacts that touch, at
/// these places.
pub(super) fn safe_speed(
    posture: &Posture,
    standing: &Posture,
    places: &[usize],
    width: f64,
) -> Option<f64> {
    let f = posture.fields();
    let endless = [f64::NEG_INFINITY, f64::INFINITY];
    let plain = f.terrain.is_empty()
        && f.gravity > 0.0
        && f.contacts.iter().all(|k| k.segment == endless && !k.is_round() && k.friction > 0.0);
    if !plain {
        return None;
    }
    let radius = I::from(f.gyration_radius);
    let row = |k: &Contact| Row::of(k, f.center_of_mass, width);
    let gaps = posture.gaps(&[0.0; 3].into());
    let size = posture.size();
    let others = (0..f.contacts.len()).filter(|k| !places.contains(k)).map(|k| {
        let gap = I::from(gaps[k]).widened((width + TOUCH) * size);
        (row(&f.contacts[k]), gap)
    });
    let barrier = Barrier {
        posture: standing,
        others: others.collect(),
        rows: standing.contacts().iter().map(row).collect(),
        rho2: radius.widened(width * radius.hi).square(),
        width,
    };
    let height = barrier.height()?;
    let speed = (I::from(height) * I::from(f.gravity)).times(2.0).sqrt().lo;
    (speed > 0.0).then_some(speed)
}

impl Barrier<'_> {
    fn lines(&self, turn: Turn) -> Vec<Line> {
        Self::lines_of(self.rows.iter(), turn)
    }

    fn lines_of<'r>(rows: impl Iterator<Item = &'r Row>, turn: Turn) -> Vec<Line> {
        let [from, to] = turn.size;
        let at = 0.5 * (from + to);
        let middle = Turn::new(at, at, turn.side);
        let reach = (to - at).max(at - from).next_up();
        let line = |row: &Row| {
            // The mean value theorem, with d' = c sin θ − b cos θ.
            let rises = row.c * turn.sin - row.b * turn.cos;
            let around = rises * I::new(-reach, reach);
            Line { n: row.n, d: row.c * middle.fallen - row.b * middle.sin + around }
        };
        rows.map(line).collect()
    }

    /// Whether the contacts in the air stay there: with the normal of a contact that touches, their gap is at least h + d_i − d_k.
    fn others_stay(&self, lines: &[Line], turn: Turn) -> bool {
        let others = Self::lines_of(self.others.iter().map(|(row, _)| row), turn);
        others.iter().zip(&self.others).all(|(line, (_, gap))| {
            lines.iter().any(|one| one.n == line.n && (*gap + one.d - line.d).is_positive())
        })
    }

    /// The same in units of |sin θ|, with which all d become zero: so that the order of the gaps is seen near θ = 0, too.
    fn scaled_lines(&self, turn: Turn) -> Vec<Line> {
        let line = |row: &Row| Line { n: row.n, d: row.c * turn.half - row.b.times(turn.side) };
        self.rows.iter().map(line).collect()
    }

    /// A lower bound of V at the step k.
    fn least(&self, k: usize, side: f64) -> f64 {
        let lines = self.lines(Turn::new(angle(k), angle(k), side));
        let mut least = f64::NEG_INFINITY;
        for (i, one) in lines.iter().enumerate() {
            for two in &lines[i + 1..] {
                if let Some([a, b]) = shares(one, two)
                    && a.lo.min(b.lo) >= 0.0
                {
                    least = least.max((a * one.d + b * two.d).lo);
                }
            }
            if one.is_level() {
                least = least.max((one.d / one.n[1]).lo);
            }
        }
        least
    }

    /// The largest height H for which all holds, up to the last halving. All conditions hold for any smaller height, too.
    fn height(&self) -> Option<f64> {
        let sides = [1.0, -1.0];
        let levels: [Vec<f64>; 2] =
            sides.map(|side| (0..=STEPS).map(|k| self.least(k, side)).collect());
        let holds = |height: f64| {
            (0..2).all(|s| {
                Self::range(&levels[s], height)
                    .all(|k| self.holds(k, sides[s], height) && self.is_near(k, sides[s], height))
            })
        };
        let highest = |side: &Vec<f64>| side.iter().fold(0.0, |a: f64, b| a.max(*b));
        let most = highest(&levels[0]).min(highest(&levels[1]));
        if most > 0.0 && holds(most) {
            return Some(most);
        }
        let (mut low, mut high) = (0.0, most);
        for _ in 0..HALVINGS {
            let middle = 0.5 * (low + high);
            *(if holds(middle) { &mut low } else { &mut high }) = middle;
        }
        (low > 0.0).then_some(low)
    }

    /// The steps k, from k to k + 1, that the body may reach.
    fn range(levels: &[f64], height: f64) -> std::ops::Range<usize> {
        0..levels.iter().position(|level| *level >= height).unwrap_or(STEPS)
    }

    /// Whether between the steps k and k + 1 a motion exists that loses energy unless the body rests.
    fn holds(&self, k: usize, side: f64, height: f64) -> bool {
        let f = self.posture.fields();
        let turn = Turn::new(angle(k), angle(k + 1), side);
        let rows: Vec<Row> = self.rows.iter().map(|row| row.turned(turn.cos, turn.sin)).collect();
        let lines = self.lines(turn);
        let walls = |one: &Line, two: &Line| {
            shares(one, two).is_some_and(|both| both.iter().all(|x| x.is_positive()))
        };
        let walled =
            (0..lines.len()).any(|i| lines[i + 1..].iter().any(|two| walls(&lines[i], two)));
        let bounded = walled || lines.iter().all(Line::is_level);
        let sound = (0..rows.len()).filter(|i| Self::may_touch(&lines, *i, height)).all(|i| {
            let (row, friction) = (&rows[i], f.contacts[i].friction);
            let friction = I::from(friction).widened(self.width * friction);
            let soft = |way: f64| row.stiffness(friction, way, self.rho2).is_positive();
            row.height().is_negative()
                && !row.along_level().contains_zero()
                && soft(1.0)
                && soft(-1.0)
        });
        let scaled = self.scaled_lines(turn);
        let reach = height / (libm::sin(angle(k)) - TRIGONOMETRIC_ERROR).max(0.0);
        sound
            && bounded
            && self.others_stay(&lines, turn)
            && (0..rows.len()).all(|i| {
                (i + 1..rows.len()).all(|j| {
                    !Self::may_close(&scaled, i, j, reach) || self.slides_on([i, j], &rows, height)
                })
            })
    }

    /// Whether two closed contacts that slide certainly go on, either way, at any rate of turning that the energy allows. At the rate ω the
    /// gap of contact i has the acceleration −c_iω² too, and its sliding velocity −b_iω².
    fn slides_on(&self, pair: [usize; 2], rows: &[Row], height: f64) -> bool {
        let f = self.posture.fields();
        let contacts = pair.map(|k| &f.contacts[k]);
        let rows = pair.map(|k| &rows[k]);
        let Some(mut local) = Local::of_rows(f, contacts, rows, self.width) else { return false };
        let most = (I::from(height) * I::from(f.gravity)).times(2.0) / self.rho2;
        let spin = I::new(0.0, most.hi);
        for (k, row) in rows.iter().enumerate() {
            local.g[k] = local.g[k] + row.c * spin;
            local.pull[k] = local.pull[k] - row.b * spin;
        }
        [1.0, -1.0].iter().all(|way| local.goes_on(*way) == Some(true))
    }

    /// Whether contact i may be closed at a height of at most H. Its line and that of another contact bound the height: e_y = λ_i n_i + λ_j
    /// n_j, λ_j ≥ 0. Of two contacts with one normal only the lower one can be closed.
    fn may_touch(lines: &[Line], i: usize, height: f64) -> bool {
        let one = &lines[i];
        let rises_by = |two: &Line| {
            shares(one, two)
                .is_some_and(|[a, b]| b.lo >= 0.0 && (a * one.d + b * two.d).lo > height)
        };
        let is_kept_open = |two: &Line| one.n == two.n && (two.d - one.d).is_positive();
        let rises = one.is_level() && (one.d / one.n[1]).lo > height;
        !rises
            && !lines
                .iter()
                .enumerate()
                .any(|(j, two)| j != i && (rises_by(two) || is_kept_open(two)))
    }

    /// Whether two contacts may be closed together at a height of at most H, in the units of the lines.
    fn may_close(lines: &[Line], i: usize, j: usize, height: f64) -> bool {
        let (one, two) = (&lines[i], &lines[j]);
        match crossing(one, two) {
            Some(at) => Self::may_be(lines, at, height),
            // On one line both are closed only where θ = 0, and their slide is part of the verdict.
            None if one.n == two.n => (one.d - two.d).contains_zero(),
            None => true,
        }
    }

    fn may_be(lines: &[Line], at: [I; 2], height: f64) -> bool {
        !lines.iter().any(|line| line.gap(at).is_negative()) && at[1].lo <= height
    }

    /// Whether between the steps k and k + 1 all gaps are small where two contacts are closed at heights up to H.
    fn is_near(&self, k: usize, side: f64, height: f64) -> bool {
        let lines = self.lines(Turn::new(angle(k), angle(k + 1), side));
        let most = HOVERS * self.posture.size();
        (0..lines.len()).all(|i| {
            (i + 1..lines.len()).all(|j| {
                let (one, two) = (&lines[i], &lines[j]);
                let Some(at) = crossing(one, two) else { return one.n == two.n };
                !Self::may_be(&lines, at, height)
                    || lines.iter().all(|line| line.gap(at).hi <= most)
            })
        })
    }
}
