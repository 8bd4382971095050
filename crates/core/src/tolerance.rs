//! Every tolerance: what counts as zero, as equal or as reached where numbers are rounded. Each has its unit, the reason for its value,
//! and the range of values for which that reason holds (an order of magnitude; no campaign has varied them).
//!
//! Elsewhere stand: ranges of input (`simulate/limits.rs`, `error.rs`, `body/posture.rs`), proved bounds of rounding (`math/ball.rs`,
//! `math/interval.rs`, `stability/corner.rs`, `enclosure/`), limits on numbers of steps, and parameters of a search that only change
//! its cost (`stability/certify.rs`, `stability/trials.rs`).

// --- Starts and terrain ---

/// Least |n_y| of a ground onto which a contact is put by a vertical displacement. Dimensionless. On a steeper one the displacement would be
/// a million times the gap. Range: 1e-9 to 1e-3.
pub(crate) const STEEPEST_REACHED: f64 = 1e-6;

/// Change of the gap rate of a closed contact by a kick that counts as zero. Unit: roundings of the size of its three terms. A kick along the
/// ground would otherwise lift a contact, or hit it, by its rounding error. Range: 2 to 16.
pub(crate) const KICK_ROUNDINGS: f64 = 4.0;

/// Gap of a contact that counts as touching, at the start and at vertices of the terrain; and distance of a corner of the ground from a side
/// of the body at the start of a motion in which it enters. Unit: size of the body.
/// Positions in doubles carry rounding of about 1e-16 of their size. A larger value would hide a wrong start, a smaller one refuse a
/// right one. Range: 1e-14 to 1e-9.
pub const TOUCH: f64 = 1e-12;

/// Distance of a vertex of the terrain from the straight line between the vertices around it that is rounding. Unit: machine epsilon times
/// the coordinates of the vertex and of the point of that line nearest to it. The coordinates are often computed from a slope, with a few
/// roundings. A larger value would remove real bends, a smaller one would keep vertices at which nothing changes. Range: 4 to 64.
pub(crate) const STRAIGHT_VERTEX: f64 = 8.0;

/// Height above the ground of another contact that counts as zero where the lines of several contacts are compared. Unit: size of the
/// body and its displacement. Coordinates and slopes are often given with three digits only. Range: 1e-6 to 1e-2.
pub(crate) const SAME_GROUND: f64 = 1e-3;

/// Rounding of the gap and of the gap rate of a closed contact in the final state of a run, which counts as touching when the next run
/// starts from that state. Unit: machine epsilon times the terms of the gap. The roundings of the steps of a rotation add up.
/// Range: 8 to 1e3.
pub(crate) const FINAL_GAP_ROUNDINGS: f64 = 32.0;

/// Excess of the product ψ_1ψ_2 over its bound 1 that is rounding. Relative. The product has a few roundings.
/// Range: 4 to 64 machine epsilons.
pub(crate) const COUPLING_ROUNDING: f64 = 8.0 * f64::EPSILON;

/// Distance from the start at which a body has left for ever. Unit: m. Its square is close to the largest double.
/// Range: below 1e150.
pub(crate) const DEPARTED: f64 = 1e140;

/// Time up to which it is not examined whether a body has departed. Unit: s. Range: below the time to fall by [`DEPARTED`].
pub(crate) const DEPARTS_AFTER: f64 = 1e18;

// --- Flight ---

/// Newton step to a touchdown after which no other one is needed. Relative to the time. The error after the step is of third order
/// in it, below 1e-17; the turn is updated by its Taylor terms of the same order. Range: up to 4e-6.
pub(crate) const LAST_NEWTON_STEP: f64 = 2e-6;

/// Lowest gap within a turn of a spinning body that is rounding. Unit: sum of the terms of the gap. Range: 4 to 64 machine epsilons.
pub(crate) const LOWEST_GAP_ROUNDING: f64 = 8.0 * f64::EPSILON;

/// Rounding of a difference of gaps or gap rates. Unit: size of its terms. Range: 2 to 16 machine epsilons.
pub(crate) const GAP_DIFFERENCE_ROUNDING: f64 = 4.0 * f64::EPSILON;

/// Margin by which the bounds of a touchdown time are widened, so that rounding cannot exclude the touchdown. Relative.
/// A wider bracket costs steps, not accuracy. Range: 1e-14 to 1e-3.
pub(crate) const BRACKET_MARGIN: f64 = 1e-9;

/// Number of turns in flight after which the angle is reduced again. A sum of so many turns keeps ten digits of one turn.
/// Range: 1e3 to 1e8.
pub(crate) const MANY_TURNS: f64 = 1e6;

/// Rotation in one flight beyond which at most four digits of the angle at its end are left. Unit: rad. Range: 1e10 to 1e13.
pub(crate) const PHASE_LOST: f64 = 1e12;

/// Distance of one flight beyond which at most four digits of the distances between the contacts are left. Unit: size of the body.
/// Range: 1e10 to 1e13.
pub(crate) const PLACE_LOST: f64 = 1e12;

/// Difference of two touchdown times below which both contacts land together. Relative to the times. Each time has a few roundings: of
/// its gap, of gravity and of a square root. Range: 4 to 64 machine epsilons.
pub(crate) const SIMULTANEOUS: f64 = 8.0 * f64::EPSILON;

// --- Impact ---

/// Impulse of a contact that is rounding. Unit: the largest impulse of the collision. Range: 2 to 64 machine epsilons.
pub(crate) const UNLOADED: f64 = 4.0 * f64::EPSILON;

/// Rise of the normal velocity with the normal impulse of a sliding contact that counts as zero. Unit: the rise without friction. A slide
/// that jams ends where the rise vanishes. Range: 1e-12 to 1e-6.
pub(crate) const JAMMED_SLIDE: f64 = 1e-9;

// --- Contact modes ---

/// Distance from equality below which a test of Table I counts as a tie. Unit: load.
///
/// A tie belongs to the closed, the static word: a_n within this of zero is not S, a_t within this is neither R nor L, and
/// f_n ≥ −`TIE` is closed; unless no word is consistent then, but one is whose a_n or a_t is positive. Rows are of length one and loads of
/// size one, so that rounding is of order 1e-16 times the condition of a word's system. A larger value would blur modes that differ.
/// Range: 1e-12 to 1e-8.
pub const TIE: f64 = 1e-10;

/// Acceleration that counts as zero where geometry and biases fix it near zero. Unit: load.
///
/// Such a zero may hold for reasons that the numbers do not show (a body on four contacts rebounds with −e times its velocity), up to
/// rounding of order 1e-16 times the condition of the rows. A larger value would hide ties, a smaller one would report rounding.
/// Range: 1e-15 to 1e-12.
pub(crate) const FIXED_ACCELERATION: f64 = 1e-14;

/// Distance of a row from the span of others below which it depends on them. Unit: length of the row, which is about one.
/// Rows carry rounding of order 1e-16. A larger value would treat contacts that are close together as one. Range: 1e-12 to 1e-8.
pub(crate) const DEPENDENT_ROW: f64 = 1e-10;

/// Acceleration per unit of a force outside its cone that a tie allows. Rows are of length about one. Range: 10 to 1e3.
pub(crate) const CONE_TIE_ACCELERATION: f64 = 100.0;

/// Difference of the length of a tangent from one that is rounding of decimals such as 0.8 and 0.6. Range: 1e-15 to 1e-6.
pub(crate) const UNIT_TANGENT: f64 = 1e-12;

/// Accelerations below which the solution of a convex programme counts as zero, tried in this order. Unit: load. Clarabel's 1e-8 in the
/// objective is at most 1e-4 in the acceleration. Range: 0 to 1e-3.
#[cfg(feature = "qp")]
pub(crate) const QP_ZERO: [f64; 3] = [0.0, 1e-6, 1e-4];

/// Accuracies asked of Clarabel, tried in this order. Only the active edges of the cones are needed, and a rough solution mostly shows
/// them. Range: 1e-10 to 1e-3.
#[cfg(feature = "qp")]
pub(crate) const QP_ACCURACIES: [f64; 2] = [1e-5, 1e-9];

/// Residual of the balance of forces that is rounding. Unit: the largest force. It is the rounding of a sum of up to 64 forces; one edge
/// too many among the active ones leaves more. Range: 1e-14 to 1e-11.
#[cfg(feature = "qp")]
pub(crate) const FORCE_BALANCE: f64 = 1e-13;

/// Entry of a tableau of the simplex method that is rounding. The programmes have coefficients of order one. Range: 1e-14 to 1e-9.
pub(crate) const SIMPLEX_ZERO: f64 = 1e-12;

// --- Zeno points ---

/// Error of a summed tail at which the sum is taken. Unit: time elapsed.
///
/// A fortieth of the rounding of the time itself. The estimate of the error of a clattering tail can be 9 times too low; with this value
/// the error stays below half a unit in the last place all the same. Range: 1e-20 to 1e-17.
pub(crate) const TAIL: f64 = 5e-18;

/// Value of ε²τ at which a clattering tail is tried, with τ the last flight and ε = 2gh/(u² + 2gh) the part of gravity in the next one.
/// Unit: time elapsed. The error of the sum grows like ε²τ. A larger value costs collisions that try in vain, a smaller one collisions
/// that could have been summed; no answer depends on it beyond [`TAIL`]. Range: 10 to 1e4 times [`TAIL`].
pub(crate) const TRY_TAIL: f64 = 1e2 * TAIL;

/// Remaining time of an accumulation without a closed form at which it counts as reached. Unit: time elapsed. Below the rounding of the
/// time. Range: 1e-18 to 1e-16.
pub(crate) const REACHED: f64 = 1e-17;

/// Change of the scale-reduced state over one cycle that counts as a repetition. Relative. Range: 1e-8 to 1e-4.
pub(crate) const SELF_SIMILAR: f64 = 1e-6;

/// Ratio of the speeds of a clattering state to the speed g T0 that gravity gives in the time left, T0 = h_b/d, at which the sum leaves
/// gravity out. Range: above 4.
pub(crate) const GRAVITY_NEGLIGIBLE: f64 = 16.0;

/// 1 − ψ_1ψ_2 below which the rows of two gaps count as parallel. It carries a few roundings. Range: 8 to 64 machine epsilons.
pub(crate) const PARALLEL_GAP_ROWS: f64 = 16.0 * f64::EPSILON;

/// Ratio (2u_a − g_aτ)/u_a below which the order of two touchdowns is decided from their difference. Range: 1e-15 to 1e-6.
pub(crate) const LANDING_ORDER_CLOSE: f64 = 1e-14;

/// Flight below which an accumulation may be close to its end. Unit: time elapsed. Range: 1e-17 to 1e-12; only the cost depends on it.
pub(crate) const NEARLY_REACHED: f64 = 1e-16;

/// Time to rest above which it is not examined whether the geometry can be frozen. Unit: time elapsed. Range: 1e-6 to 1e-1; only the cost
/// depends on it.
pub(crate) const TAIL_TOO_LONG: f64 = 1e-3;

/// Safety factor on the estimated change of the geometry within a tail. Range: 1 to 16.
pub(crate) const FROZEN_CHANGE_MARGIN: f64 = 4.0;

/// Distance of two contacts from which on equal gap rates show that the body does not turn. Unit: √(b² + ρ²). At smaller distances the
/// rates are equal within their rounding even where it turns. Range: 1e-6 to 1e-2.
pub(crate) const CONTACTS_APART: f64 = 1e-3;

/// Speed of the body at a touchdown that is rounding. Unit: the largest speed of the run. About fifty roundings.
/// Range: 1e-15 to 1e-13.
pub(crate) const QUIET_LANDING: f64 = 1e-14;

/// Rounding of the ratio of two landing speeds one cycle apart. Unit: machine epsilon. Range: 16 to 256.
pub(crate) const CYCLE_RATIO_ROUNDINGS: f64 = 64.0;

/// Safety factor on the estimated remainder of a sum of cycles where speeds count as zero. Range: 1 to 16.
pub(crate) const REMAINDER_FACTOR: f64 = 4.0;

/// √(u² + 2gh) of a contact below which it has come to rest. Unit: the largest speed of the run. It is the rounding of the speeds of the
/// body. Range: 5e-17 to 1e-14.
pub(crate) const CONTACT_STOPPED: f64 = 1e-16;

/// Speed of a contact, in units of [`CONTACT_STOPPED`], up to which it may be part of a sequence of impacts with a contact that is below
/// that. Range: 10 to 1e6.
pub(crate) const HIT_IN_TURN: f64 = 1e3;

/// Effective gravity of a contact that counts as zero. Unit: machine epsilon times gravity and the acceleration |c| ω² of the contact. At a
/// vertical wall the sign of the component of gravity is rounding error, and a time that is inversely proportional to it is arbitrary.
/// Range: 2 to 64.
pub(crate) const PULL_ROUNDINGS: f64 = 8.0;

/// Rounding of the change of velocity between two impacts of one contact at one instant. Unit: machine epsilon. Range: 16 to 256.
pub(crate) const SEQUENCE_RATIO_ROUNDINGS: f64 = 64.0;

/// Largest error of a velocity from the rounding of the ratio by which impacts at one instant are summed. Unit: the largest speed of
/// the run. Half of the digits. Range: 1e-12 to 1e-6.
pub(crate) const SUMMED_VELOCITY: f64 = 1e-8;

/// Ratio of the speeds of two stretches of collisions from which on the contacts come down. Contacts that lose a hundredth of their speed
/// in each impact come down by more. Range: 2 to 100.
pub(crate) const SLOWER_STRETCH: f64 = 8.0;

/// Ratio of the fastest impacts of two stretches of collisions from which on the impacts become faster or slower. Range: 1.001 to 1.1.
pub(crate) const CHANGED_SPEED: f64 = 1.02;

// --- Sustained contact ---

/// Sliding speed at the end of an accumulation that counts as zero where friction can hold the contact. Unit: the largest speed of the
/// run. Also the tangential acceleration that counts as zero, in units of gravity. Sums of rounded impulses leave residues of order 1e-15.
/// A larger value would end nested accumulations too early, by as much of their time. Range: 1e-14 to 1e-12.
pub(crate) const STILL: f64 = 3e-14;

/// Distance of a contact from a piece of ground or from an end of its piece that is rounding error. Unit: displacement, arm and size of
/// the body. A body that stands on two corners is tilted by the rounding errors of both. Range: 16 to 256 machine epsilons.
pub(crate) const PLACE: f64 = 64.0 * f64::EPSILON;

/// Distance of a nominal contact from a vertex that is rounding error of its coordinates. Unit: sum of the sizes of the coordinates.
/// Range: 2 to 16 machine epsilons.
pub(crate) const SAME_VERTEX: f64 = 8.0 * f64::EPSILON;

/// Largest sliding speed that counts as zero after a sum of impacts whose time has an error. Unit: the sliding speed that counts as zero
/// elsewhere. Errors of nested sums give some hundred. Range: 1e2 to 1e4.
pub(crate) const SLOWEST_KNOWN: f64 = 1e3;

/// Gap of a contact that lands together with another one. Unit: bound of the rounding of the gap. The bound leaves out the errors of the
/// body's own motion, which add a few times as much to all gaps. Range: 4 to 64.
pub(crate) const LANDS_TOGETHER: f64 = 16.0;

/// Ratio of the gap rates of two contacts up to which they may land together. The gap that counts as zero grows with it.
/// Range: 2 to 100.
pub(crate) const LANDS_TOGETHER_SPEED: f64 = 8.0;

/// Speed of a contact at a vertex that counts as zero. Unit: machine epsilon times the terms of the speed. It is horizontal right above the
/// vertex, where the acceleration then decides to which piece the contact goes, or normal to the pieces of a narrow vertex, in which the
/// contact then rests. Each crossing of the vertex adds roundings. Range: 4 to 64.
pub(crate) const OVER_VERTEX: f64 = 16.0;

/// Depth below the terrain that is rounding, as a multiple of machine epsilon times the size of the body. The smaller of this and
/// [`GRAZE_OF_WAY`] counts. A contact that passes through the terrain by less does not touch it. Range: 1 to 16.
pub(crate) const GRAZE_OF_SIZE: f64 = 2.0;

/// Depth below the terrain that is rounding, as a multiple of machine epsilon times the distance covered. Range: 4 to 64.
pub(crate) const GRAZE_OF_WAY: f64 = 16.0;

/// Speed of the body below which it has stopped together with one of its contacts. Unit: the speeds that count as zero. The speeds have
/// decreased together, to the rounding of the time at which they vanish. Range: 10 to 1e5.
pub(crate) const BODY_STOPPED: f64 = 1e3;

/// Sliding speed that is rounding, relative to that of another contact that slides. Range: 1e-13 to 1e-8.
pub(crate) const SLOWER_SLIDE: f64 = 1e-10;

/// Duration of a phase with frozen geometry. Unit: time elapsed. The error of the rates is of second order in it, below their rounding up
/// to 1e-8, and small enough for the end of an accumulation. Range: 1e-9 to 1e-5.
pub(crate) const FROZEN_PHASE: f64 = 1e-6;

/// Relative difference of the energies of two equal swings. A swing has some twenty steps with one rounding each.
/// Range: 4e-15 to 1e-12.
pub(crate) const SWING_REPEATS: f64 = 1e-14;

/// Angle between pieces of ground up to which the rotation is taken from the difference of the rows of their contacts. Unit: distance of
/// the contacts over the radius of gyration. The difference is smaller by this factor than the terms that cancel otherwise.
/// Range: 1e-5 to 1e-2.
pub(crate) const PARALLEL_GROUND: f64 = 1e-3;

/// Part of a row outside the span of others that is rounding. Unit: length of the row. The row then follows from the others in exact
/// arithmetic too. Range: 1 to 16 machine epsilons over [`NEARLY_EQUAL_ROWS`].
pub(crate) const IMPLIED_ROW: f64 = 4.0 * f64::EPSILON / NEARLY_EQUAL_ROWS;

/// Difference of two rows below which they are nearly equal, and part of a row outside the span of others below which the row is not used
/// beside them. Unit: length of the row. Range: 1e-5 to 1e-1.
pub(crate) const NEARLY_EQUAL_ROWS: f64 = 1e-3;

/// Difference of a gap from the value that the other closed contacts imply that is rounding. Unit: machine epsilon times size and
/// displacement of the body. A contact that differs by more is above uneven ground. Range: 16 to 1e3.
pub(crate) const UNEVEN_GAP: f64 = 64.0;

/// Part of a velocity left by a projection below which the projection is repeated. Relative. Range: 1e-12 to 1e-4.
pub(crate) const CORRECTED_VELOCITY: f64 = 1e-8;

/// Determinant of a friction matrix below which it is singular. Unit: product of the lengths of its columns. Its rounding is 1e-15; steps
/// towards a jam that come closer do not move the body. Range: 2e-15 to 1e-12.
pub(crate) const SINGULAR_FRICTION_MATRIX: f64 = 1e-14;

/// Distance of a force from the edge of the hull of two cones that is rounding. Unit: the force. Range: 16 to 256 machine epsilons.
pub(crate) const HULL_EDGE: f64 = 64.0 * f64::EPSILON;

/// Drift of a fixed contact that is corrected. Unit: distances of the body. Range: 1 to 8 machine epsilons.
pub(crate) const DRIFT: f64 = 2.0 * f64::EPSILON;

/// Potential energy of a drift above which it is not corrected. Unit: kinetic energy. One rounding of a position can be more than all
/// the energy of a small motion. Range: 4 to 64 machine epsilons.
pub(crate) const DRIFT_ENERGY: f64 = 16.0 * f64::EPSILON;

/// Coefficient of the rate of a row that is more than rounding. Unit: the terms it is computed from. Range: 1e-13 to 1e-7.
pub(crate) const RATE_COEFFICIENT: f64 = 1e-9;

/// Force outside its cone that is rounding. Unit: the largest force. Range: 1e-13 to 1e-7.
pub(crate) const FORCE_OUTSIDE_CONE: f64 = 1e-9;

/// Speed of a contact without friction in a vertex of its terrain below which it has come to rest there. Unit: the largest speed of the
/// run. The speed is a difference of the body's speeds and has a few of their roundings. Range: 1e-15 to 1e-13.
pub(crate) const WEDGED: f64 = 1e-14;

/// Ratio of the slopes of two pieces above which the gap over the steeper one loses more of its digits than its rounding accounts for.
/// Range: 2 to 64.
pub(crate) const STEEPER_PIECE: f64 = 8.0;

// --- Choice of the model and proved bounds ---

/// Factor by which the estimated error of the local model must be below the tolerance, for what the estimate leaves out.
/// Range: 1 to 10.
pub(crate) const SHADOW_SAFETY: f64 = 2.0;

/// Error of the first flight and impact of the local model above which the full model is solved at once. Unit: tolerance. The error of a
/// whole run is seldom smaller. A larger value costs runs in vain, a smaller one runs that would have been accepted; no answer depends on
/// it beyond the tolerance. Range: 1 to 100.
pub(crate) const FIRST_DEFECT: f64 = 4.0;

/// Change 2Gh/u² of the squared landing speed between the models above which their events are not compared. Range: 0.01 to 0.5.
pub(crate) const LANDING_SPEED_CHANGE: f64 = 0.25;

/// Part of the tolerance for the motions that are bounded instead of followed. Range: 1/256 to 1/4.
pub(crate) const UNFOLLOWED_PART: f64 = 1.0 / 32.0;

/// Rotation up to which the full equations are followed along a local run. Unit: rad. The polynomials for sine and cosine have errors
/// below 1e-9 there. Range: up to 0.1.
pub(crate) const SHADOW_TURN: f64 = 0.1;

/// ω²|d|/g up to which the arcs of a flight count as concave. Range: below 1.
pub(crate) const CONCAVE_ARC: f64 = 0.5;

/// Safety factor on the estimated change of a sum that is not followed. Range: 1 to 16.
pub(crate) const UNFOLLOWED_FACTOR: f64 = 4.0;

/// Flight that is shorter than the rounding of the time. Unit: time elapsed. Range: 1/16 to 1 machine epsilon.
pub(crate) const FLIGHT_UNRESOLVED: f64 = f64::EPSILON / 8.0;

/// Width of the enclosure of a Zeno time below which it is not narrowed further. Unit: time elapsed. It is below one rounding of its ends.
/// Range: 1/64 to 1 machine epsilon; only width and cost depend on it.
pub(crate) const NARROW_ENOUGH: f64 = f64::EPSILON / 8.0;

/// Distance of a Zeno time from its proved bounds above which the run has a warning. Unit: time elapsed. Range: 1e-15 to 1e-12.
pub(crate) const OUTSIDE_PROVED_BOUNDS: f64 = 1e-13;

/// Rounding of the clock of a run in the error of a Zeno time. Unit: half a unit in the last place. Range: 1 to 16.
pub(crate) const CLOCK_ROUNDINGS: f64 = 4.0;

// --- Stability ---

/// Margin below which rounding may decide a verdict. Unit: size of the body, or load. Range: 1e-13 to 1e-8.
pub(crate) const DELICATE_MARGIN: f64 = 1e-10;

/// Cross product of two edges below which they are parallel. Unit: terms of the product. Range: 4 to 64 machine epsilons.
pub(crate) const PARALLEL_EDGES: f64 = 8.0 * f64::EPSILON;

/// Moment of a combination of forces with zero sum that counts as zero. Unit: the terms it is a difference of. Range: 1e-15 to 1e-11.
pub(crate) const SQUEEZE_MOMENT: f64 = 1e-13;

/// Component of a direction without bound in a family of forces that counts as zero. Unit: sum of its weights. Range: 1e-12 to 1e-6.
pub(crate) const UNBOUNDED_DIRECTION: f64 = 1e-9;

/// Distance of two shapes below which the orbit has returned. Unit: one plus the size of a coordinate. A chaotic orbit returns as close by
/// chance about once in 1e9 impacts; each return is then tested by its tangent map. Range: 1e-12 to 1e-7.
pub(crate) const RECURRENCE: f64 = 1e-9;

/// Distance from an attracting cycle, by its tangent map, below which the cycle counts as reached. Unit: one plus the size of a
/// coordinate. Range: 1e-9 to 1e-4.
pub(crate) const CYCLE_REACHED: f64 = 1e-6;

/// Rounding of a shape up to which the fate found is that of the motion from its start on. Unit: one plus the size of a coordinate. A
/// chaotic transient exceeds it after some fifty impacts. Range: 1e-9 to 1e-4.
pub(crate) const SHAPE_LOST: f64 = 1e-6;

/// Landing speed of the reduced map that counts as zero: the contact rests on the terrain. Unit: the size of the reduced state. Its own
/// bounces would last less than the rounding of any time here. Range: 1e-140 to 1e-20.
pub(crate) const SHAPE_AT_REST: f64 = 1e-100;

/// Time left of a clattering tail at which it is added as an interval. Unit: time of the flight so far. Range: 1e-15 to 1e-6; only width
/// and cost of the enclosure depend on it.
pub(crate) const CORNER_TAIL: f64 = 1e-12;

/// Difference of two directions at which an orbit has closed. Unit: rad. Only the start of a search depends on it; the certificate is
/// proved in intervals. Range: 1e-13 to 1e-6.
pub(crate) const ORBIT_CLOSED: f64 = 1e-9;

/// Strict decrease that a certificate asks of its potential on each step. Relative. Range: 1e-12 to 1e-6; a larger value refuses
/// certificates.
pub(crate) const STRICT_DECREASE: f64 = 1e-9;

/// Rounding of a limit of a cell of directions: a tangent and its argument. Relative to one plus its size. Range: 1e-15 to 1e-9.
pub(crate) const CELL_LIMIT_ROUNDING: f64 = 1e-14;

/// Sine y/r of a direction below which an orbit that is searched for a cycle counts as ended at a slide or at rest.
/// Range: 1e-15 to 1e-6; only the search depends on it.
pub(crate) const SLIDE_END: f64 = 1e-12;

/// Error of a sine, a cosine or an arc tangent of a computed angle, absolute; of a tangent, times 1 + tan². It is more than two units in
/// the last place. Range: above 2.3e-16.
pub(crate) const TRIGONOMETRIC_ERROR: f64 = 4e-16;

/// Margin of a proved bound for the rounding of the few operations, logarithms and exponential functions in it. Relative.
/// Range: above 1e-14.
pub(crate) const BOUND_MARGIN: f64 = 1e-12;

/// Part by which a random start is lifted more than to the ground, so that rounding leaves no gap negative. Relative.
/// Range: 1e-14 to 1e-3.
pub(crate) const START_LIFT: f64 = 1e-9;

/// Depth of a corner of the ground in the body from which on it has entered the body. Unit: largest distance of a corner of the body
/// from its centre of mass. Above the rounding of positions along a run. A larger value would miss entries that are not deeper; the time of
/// an entry is that of depth zero and does not depend on it.
/// Range: 1e-12 to 1e-6.
pub(crate) const EDGE_DEPTH: f64 = 1e-9;

/// Turn of a body up to which a cubic stands for the way of a point, so that its error in the middle is nearly its largest one. Unit:
/// rad. Range: 0.1 to 1; only cost depends on it.
pub(crate) const CUBIC_TURN: f64 = 0.5;

/// Bound of the error of a cubic. Unit: its error in the middle of the interval, where it is largest but for higher orders. Range: 1.5
/// to 10.
pub(crate) const MEASURED_ERROR: f64 = 2.0;
