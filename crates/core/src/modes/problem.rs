//! The contact-mode problem: which motions of a body in contact does Coulomb's law allow?
//!
//! ```text
//! q̈ = a₀ + M⁻¹ Σ_i (T_iᵀ f_t,i + N_iᵀ f_n,i)        a₀ the free acceleration, that of the load alone
//! a_n,i = N_i q̈ + bias_n,i     a_t,i = T_i q̈ + bias_t,i
//! N_i = (n_i, d_i × n_i)       T_i = (t_i, d_i × t_i)     n_i = t_i turned by +90°
//! ```
//!
//! At the impulse level the same equations hold with the velocity after the impact for q̈, the one before it
//! for a₀, impulses for forces, and bias e·(velocity before) for Newton's restitution.

use nalgebra::{Vector2, Vector3};
use serde::{Deserialize, Serialize};

use crate::body::geometry::ContactGeometry;
use crate::body::ground::MOST_IN_VERTICES;
use crate::body::posture::{MAX_CONTACTS, Posture};
use crate::body::side::TouchedSide;
use crate::body::state::State;
use crate::error::{Error, LARGEST, finite, friction, in_range, positive};
use crate::math::turn::Turn;
use crate::math::unsigned_zero::UnsignedZero;
use crate::modes::rows::{Row, scale};
use crate::modes::scaled::Problem;
use crate::modes::squeeze::Squeeze;
use crate::modes::{Method, Mode, ModeAnswer, contact_modes};
use crate::tolerance::{TOUCH, UNIT_TANGENT};

/// The kind of unknowns of a contact-mode problem.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Level {
    /// Accelerations (m/s²) and forces (N).
    #[default]
    Acceleration,
    /// Velocities after an impact (m/s) and impulses (N s).
    Impulse,
}

/// The fields of a contact-mode problem. SI units; all lists have one entry for each contact.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ProblemFields {
    /// Mass m > 0, in kg.
    pub mass: f64,
    /// Radius of gyration ρ > 0, in m.
    pub gyration_radius: f64,
    /// Arms d_i from the centre of mass to the contact points as they are now, world axes, in m.
    pub arms: Vec<[f64; 2]>,
    /// Unit tangents t_i of the terrain. A component of at most 2⁻⁵² counts as zero, because cos(π/2) is not zero in doubles.
    pub tangents: Vec<[f64; 2]>,
    /// Coefficients of friction μ_i, from 0 to 1e12.
    pub friction: Vec<f64>,
    /// Sign of the sliding velocity: 1, −1 or 0; `None` where the contact is separated. At the impulse level 0, where the
    /// mode gives the direction of sliding after the impact.
    pub sliding: Vec<Option<i8>>,
    /// Added to J q̈ at each contact, (tangential, normal), in m/s² (impulse level: m/s).
    pub bias: Vec<[f64; 2]>,
    /// Acceleration without contact forces, (x, y, θ), in m/s² and rad/s² (impulse level: m/s, rad/s).
    pub free_acceleration: [f64; 3],
    /// Accelerations and forces, or velocities and impulses.
    #[serde(default)]
    pub level: Level,
}

/// A validated contact-mode problem, with the rows of its contacts in the mass metric.
///
/// ```
/// use standfast::modes::{ContactProblem, ProblemFields, contact_modes, Method, Status};
///
/// // A uniform rod of half-length 1 slides to the right on its lower end, leaning back by atan 2: Painlevé's
/// // example. With friction of 4/3 or more it has no consistent mode.
/// let (sin, cos) = (2.0 / 5f64.sqrt(), 1.0 / 5f64.sqrt());
/// let rod = |friction| {
///     ContactProblem::new(ProblemFields {
///         mass: 1.0,
///         gyration_radius: (1.0 / 3f64).sqrt(),
///         arms: vec![[cos, -sin]],
///         tangents: vec![[1.0, 0.0]],
///         friction: vec![friction],
///         sliding: vec![Some(1)],
///         bias: vec![[0.0, 0.0]],
///         free_acceleration: [0.0, -9.81, 0.0],
///         ..ProblemFields::default()
///     })
/// };
/// assert_eq!(contact_modes(&rod(1.3)?, Method::Auto)?.status(), Status::Unique);
/// assert_eq!(contact_modes(&rod(1.4)?, Method::Auto)?.status(), Status::None);
/// # Ok::<(), standfast::Error>(())
/// ```
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "ProblemFields", into = "ProblemFields")]
pub struct ContactProblem {
    fields: ProblemFields,
    rows: Vec<Row>,
    /// The largest of the load and the biases: the unit of the scaled accelerations, in m/s² (m/s).
    scale: f64,
    /// Scaled free acceleration (ẍ, ÿ, ρθ̈).
    load: Vector3<f64>,
}

/// Longest arm, in radii of gyration. With longer arms the rows are nearly pure rotations, and the rounding errors of forces grow by
/// (|d|/ρ)².
pub(crate) const LONGEST_ARM: f64 = 1e4;

impl TryFrom<ProblemFields> for ContactProblem {
    type Error = Error;

    fn try_from(fields: ProblemFields) -> Result<Self, Error> {
        Self::new(fields)
    }
}

impl From<ContactProblem> for ProblemFields {
    fn from(problem: ContactProblem) -> Self {
        problem.fields
    }
}

/// A component of a unit tangent; zero where it is the rounded sine or cosine of a multiple of π/2. Otherwise two walls that face
/// each other would hold a body without friction, with forces of 1e16 times its weight.
fn on_axis(component: f64) -> f64 {
    if component.abs() <= f64::EPSILON { 0.0 } else { component }
}

impl ContactProblem {
    /// Validates `fields`.
    ///
    /// # Errors
    ///
    /// [`Error::OutOfRange`] or [`Error::Unusable`], naming the field, its value and what is allowed.
    pub fn new(mut fields: ProblemFields) -> Result<Self, Error> {
        positive("mass", fields.mass)?;
        let rho = positive("gyration_radius", fields.gyration_radius)?;
        let n = fields.arms.len();
        if n == 0 || n > MAX_CONTACTS {
            return Err(Error::Unusable {
                field: "arms".into(),
                value: format!("[{n} contacts]"),
                allowed: format!("1 to {MAX_CONTACTS} contacts"),
            });
        }
        for (field, len) in [
            ("tangents", fields.tangents.len()),
            ("friction", fields.friction.len()),
            ("sliding", fields.sliding.len()),
            ("bias", fields.bias.len()),
        ] {
            if len != n {
                return Err(Error::Unusable {
                    field: field.into(),
                    value: format!("[{len} entries]"),
                    allowed: format!("one for each of the {n} arms"),
                });
            }
        }
        for (axis, value) in ["x", "y", "theta"].iter().zip(fields.free_acceleration) {
            finite(format_args!("free_acceleration.{axis}"), value)?;
        }
        let [ax, ay, alpha] = fields.free_acceleration;
        let load = Vector3::new(ax, ay, rho * alpha);
        let mut rows = Vec::with_capacity(n);
        for i in 0..n {
            let number = i + 1;
            let (d, t) = (fields.arms[i], fields.tangents[i]);
            for (axis, k) in [("x", 0), ("y", 1)] {
                finite(format_args!("arms.{number}.{axis}"), d[k])?;
                finite(format_args!("tangents.{number}.{axis}"), t[k])?;
                finite(
                    format_args!("bias.{number}.{}", ["tangential", "normal"][k]),
                    fields.bias[i][k],
                )?;
            }
            if !((libm::hypot(t[0], t[1]) - 1.0).abs() <= UNIT_TANGENT) {
                return Err(Error::Unusable {
                    field: format!("tangents.{number}"),
                    value: format!("({:?}, {:?})", t[0], t[1]),
                    allowed: "a vector of length 1".into(),
                });
            }
            friction(format_args!("friction.{number}"), fields.friction[i])?;
            if let Some(sign) = fields.sliding[i]
                && !(-1..=1).contains(&sign)
            {
                return Err(Error::Unusable {
                    field: format!("sliding.{number}"),
                    value: sign.to_string(),
                    allowed: "1, -1, 0, or none where the contact is separated".into(),
                });
            }
            let arm = Vector2::from(d) / rho;
            let row = Row::new(
                Vector2::from(t.map(on_axis)),
                arm,
                fields.bias[i],
                fields.friction[i],
                fields.sliding[i],
            );
            in_range(
                format_args!("arms.{number}"),
                arm.norm(),
                arm.norm() <= LONGEST_ARM,
                "at most 1e4; forces on longer arms have few correct digits",
            )?;
            rows.push(row);
        }
        let scale = scale(&mut rows, load.amax());
        for pair in fields.arms.iter_mut().chain(&mut fields.tangents).chain(&mut fields.bias) {
            *pair = pair.unsigned_zero();
        }
        fields.free_acceleration = fields.free_acceleration.unsigned_zero();
        Ok(Self { fields, rows, scale, load: load / scale })
    }

    /// The fields as given, with +0.0 for −0.0.
    #[must_use]
    pub fn fields(&self) -> &ProblemFields {
        &self.fields
    }

    pub(crate) fn rows(&self) -> &[Row] {
        &self.rows
    }

    pub(crate) fn load(&self) -> Vector3<f64> {
        self.load
    }

    /// q̈ from its scaled form.
    pub(crate) fn motion(&self, y: &Vector3<f64>) -> [f64; 3] {
        [y.x * self.scale, y.y * self.scale, y.z * self.scale / self.fields.gyration_radius]
    }

    /// Force (tangential, normal) at a contact from its scaled form F = ν f/(m scale).
    pub(crate) fn force(&self, index: usize, scaled: [f64; 2]) -> [f64; 2] {
        scaled.map(|part| part * self.fields.mass * self.scale / self.rows[index].stretch)
    }
}

impl Problem for ContactProblem {
    type V = Vector3<f64>;

    fn rows(&self) -> &[Row] {
        &self.rows
    }

    fn load(&self) -> &Vector3<f64> {
        &self.load
    }

    fn coordinates(&self) -> usize {
        3
    }

    fn acceleration(&self, y: &Vector3<f64>) -> Vec<f64> {
        self.motion(y).to_vec()
    }

    fn force(&self, index: usize, scaled: [f64; 2]) -> [f64; 2] {
        self.force(index, scaled)
    }

    fn internal_force(&self, scaled: f64) -> f64 {
        scaled * self.fields.mass * self.scale
    }

    fn squeeze(&self, closed: [usize; 2], rest: &Vector3<f64>) -> Squeeze {
        Squeeze::between(closed.map(|i| &self.rows[i]), *rest)
    }
}

/// The error where a closed contact (from 0) approaches the ground at this rate.
fn approaches(contact: usize, rate: f64) -> Error {
    Error::Unusable {
        field: "qdot".into(),
        value: format!("a rate of {rate:?} m/s at the gap of contact {}", contact + 1),
        allowed: "rates >= 0 at closed contacts; with a negative rate an impact is due, which a ContactProblem of level \"impulse\" solves"
            .into(),
    }
}

impl ContactProblem {
    /// The contact-mode problem of a state: gravity, the load `wrench` = (f_x, f_y, torque about the centre of
    /// mass) in N and N m, and the curvature bias −(b_i, c_i) ω² of the true configuration.
    ///
    /// After the contacts of the posture come the sides of its outline that touch corners of the ground.
    ///
    /// A contact is closed if its gap is within [`TOUCH`] of zero relative to the size of the body, and its
    /// rate is within the same of zero relative to the speeds of the body. A contact with a larger rate separates.
    ///
    /// ```
    /// use standfast::modes::{ContactProblem, Method, contact_modes};
    /// use standfast::{Lamina, Posture, State};
    ///
    /// // A rod of 1 kg is pushed with 6 N; friction of 5 N holds it back: it begins to slide at 1 m/s².
    /// let rod = Posture::rod(0.5, &Lamina { friction: 0.5, gravity: 10.0, ..Lamina::default() })?;
    /// let problem = ContactProblem::of_posture(&rod, &State::at_rest([0.0; 3]), [6.0, 0.0, 0.0])?;
    /// let modes = contact_modes(&problem, Method::Auto)?;
    /// let mode = modes.consistent().next().expect("one mode");
    /// assert_eq!(mode.word.to_string(), "RR");
    /// assert!((mode.acceleration[0] - 1.0).abs() < 1e-14);
    /// # Ok::<(), standfast::Error>(())
    /// ```
    ///
    /// # Errors
    ///
    /// A state that is not finite, a contact in the terrain, a corner of the ground in the body, or a closed contact that approaches it, which
    /// means an impact.
    pub fn of_posture(posture: &Posture, state: &State, wrench: [f64; 3]) -> Result<Self, Error> {
        state.validate()?;
        posture.check_sides(&state.q)?;
        for (axis, value) in ["x", "y", "torque"].iter().zip(wrench) {
            finite(format_args!("wrench.{axis}"), value)?;
        }
        let (f, size) = (posture.fields(), posture.size());
        let spin = state.qdot.z * state.qdot.z * size;
        let allowed = "omega^2 times the size of the body at most 1e150 m/s^2";
        in_range("qdot.theta", state.qdot.z, spin <= LARGEST, allowed)?;
        let inertia = f.mass * posture.gyration_squared();
        for (k, axis) in ["x", "y", "torque"].iter().enumerate() {
            let push = wrench[k] / if k < 2 { f.mass } else { inertia };
            let allowed = "accelerations of at most 1e150 m/s^2 or rad/s^2";
            in_range(format_args!("wrench.{axis}"), wrench[k], push.abs() <= LARGEST, allowed)?;
        }
        let count = posture.contacts().len();
        let geometry = (0..count).map(|i| posture.under_moving(i, state).geometry);
        let geometry: Vec<ContactGeometry> = geometry.collect();
        let first = Self::on_pieces(posture, state, wrench, &geometry)?;
        let free = |&i: &usize| first.fields.sliding[i] == Some(0);
        let at_vertex = |i: usize| Some((i, posture.convex_vertex(i, &state.q)?));
        let at_vertices: Vec<(usize, [isize; 2])> =
            (0..count).filter(free).filter_map(at_vertex).take(MOST_IN_VERTICES).collect();
        if at_vertices.is_empty() {
            return Ok(first);
        }
        let at = |i: usize| posture.position(i, &state.q);
        let mut best: Option<((bool, usize), Self)> = None;
        for choice in 0..1_usize << at_vertices.len() {
            let (mut geometry, mut inwards) = (geometry.clone(), vec![None; count]);
            for (bit, (i, pieces)) in at_vertices.iter().enumerate() {
                let on = pieces.map(|k| {
                    posture.piece(*i, k).map(|piece| posture.on_piece(*i, piece, &at(*i)))
                });
                // The first choice is the one found, so that it is kept if no other is better.
                let found = usize::from(on[1].is_some_and(|on| on.normal == geometry[*i].normal));
                let taken = if choice >> bit & 1 == 0 { found } else { 1 - found };
                geometry[*i] = on[taken].unwrap_or(geometry[*i]);
                inwards[*i] = Some(if taken == 0 { Mode::Left } else { Mode::Right });
            }
            let problem = Self::on_pieces(posture, state, wrench, &geometry)?;
            let holds = problem.holds(&inwards);
            if best.as_ref().is_none_or(|(most, _)| holds > *most) {
                best = Some((holds, problem));
            }
        }
        Ok(best.map_or(first, |(_, problem)| problem))
    }

    /// Whether a consistent word holds all closed contacts fixed; and the largest number of contacts that stay on their pieces in a
    /// consistent word. A contact stays on its piece if it is fixed, or if it slides in the direction given here, away from its vertex.
    pub(crate) fn holds(&self, inwards: &[Option<Mode>]) -> (bool, usize) {
        let Ok(modes) = contact_modes(self, Method::Enumerate) else { return (false, 0) };
        let of = |answer: &ModeAnswer| {
            let letters: Vec<Mode> = answer.word.modes().collect();
            let closed = |i: &usize| self.fields.sliding[*i].is_some();
            let fixed = (0..letters.len()).filter(closed).all(|i| letters[i] == Mode::Fixed);
            let stays = |(mode, inward): (&Mode, &Option<Mode>)| {
                inward.is_some_and(|inward| *mode == Mode::Fixed || *mode == inward)
            };
            (fixed, letters.iter().zip(inwards).filter(|pair| stays(*pair)).count())
        };
        modes.consistent().map(of).max().unwrap_or((false, 0))
    }

    /// The problem of a body with its contacts on pieces of ground with these constants.
    fn on_pieces(
        posture: &Posture,
        state: &State,
        wrench: [f64; 3],
        geometry: &[ContactGeometry],
    ) -> Result<Self, Error> {
        let (f, size) = (posture.fields(), posture.size());
        let (v, omega) = (state.qdot, state.qdot.z);
        let touch = TOUCH * size;
        let tolerance = TOUCH * (libm::hypot(v.x, v.y) + size * omega.abs());
        let gaps = posture.gaps(&state.q);
        let turn = Turn::by(state.q.z);
        let mut problem = ProblemFields {
            mass: f.mass,
            gyration_radius: f.gyration_radius,
            free_acceleration: [
                wrench[0] / f.mass,
                wrench[1] / f.mass - f.gravity,
                wrench[2] / (f.mass * posture.gyration_squared()),
            ],
            ..ProblemFields::default()
        };
        for (i, k) in geometry.iter().enumerate() {
            let (b, c) = k.turned(&turn);
            let gap = posture.signed_gap(i, &state.q, gaps[i]);
            let rate = k.gap_rate(&state.qdot, &turn).unsigned_zero();
            if gap < -touch {
                return Err(Error::Penetrating { contact: i + 1, gap, touch });
            }
            let closed = gap <= touch;
            if closed && posture.touched(i, &state.q).len() > 1 {
                let [x, y, theta] = state.q.into();
                return Err(Error::Unusable {
                    field: "q".into(),
                    value: format!("[{x:?}, {y:?}, {theta:?}]"),
                    allowed: format!(
                        "contact {} off the vertex of its terrain; in the vertex it rests on two pieces, which a ContactProblem takes as two contacts",
                        i + 1
                    ),
                });
            }
            if closed && rate < -tolerance {
                return Err(approaches(i, rate));
            }
            let touching = c - k.radius;
            let along = k.tangent.x * v.x + k.tangent.y * v.y;
            let speed = along - touching * omega - k.surface_speed;
            let sign = i8::from(speed > tolerance) - i8::from(speed < -tolerance);
            problem.arms.push((k.tangent * b + k.normal * touching).into());
            problem.tangents.push(k.tangent.into());
            problem.friction.push(k.friction);
            problem.sliding.push((closed && rate <= tolerance).then_some(sign));
            // About a corner the normal of a disc turns with its centre.
            let centre = along - c * omega;
            let turning = if k.corner.is_some() { centre * centre / k.radius } else { 0.0 };
            problem.bias.push([-b * omega * omega, turning - c * omega * omega]);
        }
        let corners = posture.sides_touched(&state.q);
        for (number, TouchedSide { geometry: k, .. }) in corners.iter().enumerate() {
            let rate = (k.normal.dot(&v.xy()) + k.b * omega).unsigned_zero();
            if rate < -tolerance {
                return Err(approaches(geometry.len() + number, rate));
            }
            let speed = k.tangent.dot(&v.xy()) - k.c * omega;
            let sign = i8::from(speed > tolerance) - i8::from(speed < -tolerance);
            problem.arms.push((k.tangent * k.b + k.normal * k.c).into());
            problem.tangents.push(k.tangent.into());
            problem.friction.push(k.friction);
            problem.sliding.push((rate <= tolerance).then_some(sign));
            // ḧ = n·r̈ + b ω̇ − c ω² − 2 ω v_t: the normal turns with the body.
            let turning = if sign == 0 { 0.0 } else { 2.0 * omega * speed };
            problem.bias.push([-k.b * omega * omega, -k.c * omega * omega - turning]);
        }
        Self::new(problem).map_err(|e| {
            e.renamed(|field| match field.strip_prefix("arms.") {
                Some(number) => format!(
                    "(distance of contacts.{number}.point from center_of_mass) / gyration_radius"
                ),
                None => field.into(),
            })
        })
    }
}
