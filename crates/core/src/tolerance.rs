//! Every tolerance of the crate: what counts as zero, as equal or as reached although numbers are rounded. Each comment gives the quantity
//! that is compared, its unit, the reason for the value, and under "Range:" the values for which that reason holds. A range is an order of
//! magnitude; no test varies the values within it.
//!
//! ε is machine epsilon, 2⁻⁵² ≈ 2.2e-16. One operation has a relative rounding error of at most ε/2. A quantity whose unit is "its terms"
//! is compared with the sum of the absolute values of the terms of which it is the sum or difference. "Time elapsed" is the time since the
//! start of the run. "Size of the body" is `Posture::size`.
//!
//! Not here: limits of input (`simulate/limits.rs`, `error.rs`, `body/posture.rs`); proved bounds of rounding errors (`math/ball.rs`,
//! `math/interval.rs`, `stability/corner.rs`, `enclosure/`); limits on numbers of steps; and parameters of a search that change only its
//! cost (`stability/certify.rs`, `stability/trials.rs`).

// --- Starts and terrain ---

/// Least |n_y| of a ground onto which a contact is put by a vertical displacement of the body. Dimensionless. At this value the
/// displacement is a million times the gap. Range: 1e-9 to 1e-3.
pub(crate) const STEEPEST_REACHED: f64 = 1e-6;

/// Change of the gap rate of a closed contact by a kick that counts as zero. Unit: ε times the terms of the change. Otherwise the rounding
/// error of a kick along the ground would lift the contact or drive it into the ground. Range: 2 to 16.
pub(crate) const KICK_ROUNDINGS: f64 = 4.0;

/// Gap below which a contact counts as touching, at the start and at a vertex of the terrain. Unit: size of the body. Also the distance
/// from a side of the body within which a corner of the ground counts as touching that side at the start of a motion; unit there: largest
/// distance of a corner of the body from its centre of mass. Positions have rounding errors of about ε times their size. A larger value
/// would accept a wrong start, a smaller value would refuse a right start. Range: 1e-14 to 1e-9.
pub const TOUCH: f64 = 1e-12;

/// Distance of a vertex of the terrain from the line between two other vertices below which it counts as on that line. Unit: ε times the
/// coordinates of the vertex and of the nearest point of the line. Coordinates that the user computed from a slope have a rounding error of
/// a few ε. A larger value would remove real bends; a smaller value would keep vertices at which nothing changes. Range: 4 to 64.
pub(crate) const STRAIGHT_VERTEX: f64 = 8.0;

/// Two lines of ground are drawn as one where their directions (rad) and their distances (in sizes of the body) differ by less than this. It
/// decides about pictures only: at this distance two lines cannot be told apart. Range: 1e-9 to 1e-4.
pub(crate) const SAME_LINE: f64 = 1e-6;

/// Height of a contact relative to the ground line of another contact that counts as zero. Unit: size of the body plus its displacement.
/// Coordinates and slopes are often given with three digits only. Range: 1e-6 to 1e-2.
pub(crate) const SAME_GROUND: f64 = 1e-3;

/// Height over its ground of a contact that does not touch any more after a kick, up to which the body still stands as before. Unit: size of
/// the body. Three contacts on different lines touch together in isolated placements only: where friction has stopped the body a little
/// away, one of them hovers at a height of the order of the displacement. Bodies on one or two lines do not need it. A larger value
/// would count a body that leans far over as standing. Range: 0.01 to 0.3.
pub(crate) const HOVERS: f64 = 0.1;

/// Gap, and gap rate, of a contact at the start of a run that count as zero. Unit: ε times the terms of the gap, and of the gap rate. With
/// this value a run that starts from the final state of another run keeps its closed contacts closed: the rounding errors of the steps of a
/// rotation add up in that state. Also used for the position of a contact relative to its ground. Range: 8 to 1e3.
pub(crate) const FINAL_GAP_ROUNDINGS: f64 = 32.0;

/// Excess of the product ψ_1ψ_2 over 1, its largest possible value, that is accepted. Relative. The user computes the product with a
/// rounding error of a few ε. Range: 4 ε to 64 ε.
pub(crate) const COUPLING_ROUNDING: f64 = 8.0 * f64::EPSILON;

/// Distance from the start beyond which a body has left for ever. Unit: m. Its square must not overflow: the largest double is 1.8e308.
/// Range: below 1e150.
pub(crate) const DEPARTED: f64 = 1e140;

/// Time elapsed before which a run does not examine whether the body has left for ever. Unit: s. Range: below the time in which a body
/// falls by [`DEPARTED`].
pub(crate) const DEPARTS_AFTER: f64 = 1e18;

// --- Flight ---

/// Newton step in the search for a touchdown below which it is the last step. Unit: the time to the touchdown. The relative error after
/// this step is of third order in the step, below 1e-17. The sine and cosine of the rotation are updated by a Taylor series of the same
/// order. Range: up to 4e-6.
pub(crate) const LAST_NEWTON_STEP: f64 = 2e-6;

/// Value of h − c − |d|, the lowest gap of a spinning body within a turn, that counts as zero. Unit: its terms. Range: 4 ε to 64 ε.
pub(crate) const LOWEST_GAP_ROUNDING: f64 = 8.0 * f64::EPSILON;

/// Rounding error of u − ωb, the mean gap rate of a spinning body. Unit: its terms. Range: 2 ε to 16 ε.
pub(crate) const GAP_DIFFERENCE_ROUNDING: f64 = 4.0 * f64::EPSILON;

/// Margin by which the bracket of a touchdown time is widened, so that rounding errors cannot exclude the touchdown. Relative. A wider
/// bracket costs steps, not accuracy. Range: 1e-14 to 1e-3.
pub(crate) const BRACKET_MARGIN: f64 = 1e-9;

/// Number of turns in one flight after which the angle is reduced modulo 2π again. An angle of so many turns keeps ten digits of one turn.
/// Range: 1e3 to 1e8.
pub(crate) const MANY_TURNS: f64 = 1e6;

/// Rotation in one flight beyond which at most four digits of the final angle modulo 2π are correct. Unit: rad. Range: 1e10 to 1e13.
pub(crate) const PHASE_LOST: f64 = 1e12;

/// Displacement in one flight beyond which at most four digits of the distances between the contacts are correct. Unit: size of the body.
/// Range: 1e10 to 1e13.
pub(crate) const PLACE_LOST: f64 = 1e12;

/// Difference of two touchdown times below which the two contacts land together. Unit: the earlier time. Each time has a rounding error of
/// a few ε, from its gap, from gravity and from a square root. Range: 4 ε to 64 ε.
pub(crate) const SIMULTANEOUS: f64 = 8.0 * f64::EPSILON;

// --- Impact ---

/// Impulse of a contact that counts as zero. Unit: the larger of the two impulses that each contact would need alone. Range: 2 ε to 64 ε.
pub(crate) const UNLOADED: f64 = 4.0 * f64::EPSILON;

/// Error with which a condition of the law of simultaneous impacts holds. Unit: the sum of the sizes of its terms. The equations of a word
/// have rounding errors of ε times their condition number, which is large for contacts that are close together. A larger value would
/// take a contact that leaves slowly for one that is hit. Range: 1e-14 to 1e-10.
pub(crate) const WITHIN_LAW: f64 = 1e-12;

/// Pivot of the equations of simultaneous impacts below which they depend on each other. Unit: the size of its column. The matrix has the
/// squares of the part of a row that is orthogonal to the others. Range: 1e-15 to 1e-10.
pub(crate) const DEPENDENT_IMPULSES: f64 = 1e-13;

/// Difference below which two velocities after an impact, and two impulses, are the same. Unit: the largest of them. Range: 1e-11 to 1e-6.
pub(crate) const ONE_VELOCITY: f64 = 1e-9;

/// Entry of a pivoted table below which it is rounding error. Unit: the largest rate before the impact, with rows of length one. Range:
/// 1e-13 to 1e-9.
pub(crate) const PIVOT_ZERO: f64 = 1e-11;

/// Rate dv_n/dp of a sliding contact (normal velocity per normal impulse) below which the contact jams. Unit: the same rate without
/// friction. A slide that jams ends where the rate vanishes. Range: 1e-12 to 1e-6.
pub(crate) const JAMMED_SLIDE: f64 = 1e-9;

// --- Mechanisms ---

/// Difference of M_ij and M_ji up to which a mass matrix counts as symmetric; their mean is taken. Unit: the larger of M_ii, M_jj and |M_ij|.
/// Libraries compute the two entries in different orders. A larger value would accept a wrong entry. Range: 1e-14 to 1e-9.
pub(crate) const ASYMMETRY: f64 = 1e-12;

/// Pivot of the Cholesky factor of a mass matrix at or below which the matrix counts as not positive definite. Unit: the entry of the diagonal.
/// The pivot of a coordinate without inertia of its own has a rounding error of a few ε. Range: 1e-15 to 1e-12.
pub(crate) const INDEFINITE: f64 = 1e-14;

/// Relative difference up to which the accelerations of the contact points of a body that falls, or the masses of a base along its two
/// coordinates, count as equal. It decides about one error message only. Range: 1e-12 to 1e-6.
pub(crate) const ONE_SIZE: f64 = 1e-9;

/// Deviation of rows, mass matrix and load from those of a rigid body up to which a mechanism counts as one. Unit: length of a row, mass, load.
/// Libraries compute them with rounding errors of a few ε. A larger value would take a mechanism with a small other inertia for a body. Range:
/// 1e-14 to 1e-10.
pub(crate) const RIGID_ROWS: f64 = 1e-12;

/// Distance of contact forces outside a friction cone that counts as zero where the forces of least norm are sought. Unit: the distance of the
/// forces without cones from their cone. The value is above the rounding error of its few operations. Range: 1e-14 to 1e-9.
pub(crate) const CONE_SLACK: f64 = 1e-12;

/// Difference of two factors on the friction at which a sign of two sliding contacts changes, up to which they count as one. Unit: the factor.
/// Roots that are equal in exact arithmetic differ by some ε. Range: 1e-15 to 1e-10.
pub(crate) const SAME_ROOT: f64 = 1e-12;

/// Distance up to which sides and corners of two bodies of an assembly touch, and depth up to which they do not overlap. Unit: size of the smaller
/// body. Corners that are computed by sines and cosines have errors of some ε. A larger value would close gaps that are meant. Range: 1e-12 to 1e-6.
pub(crate) const TOUCHING_SIDES: f64 = 1e-9;

/// Height of a unit normal up to which it counts as level: a vertical joint between two bodies is then named after the later body. It decides names and signs
/// only. Range: 1e-12 to 1e-6.
pub(crate) const UPRIGHT_NORMAL: f64 = 1e-9;

/// Part of a sum of squares that its terms may have left by rounding. Unit: size of the terms. Range: 1e-15 to 1e-12.
pub(crate) const SQUARE_ROUNDING: f64 = 1e-14;

/// Derivative of a sum of squares that counts as zero. Unit: size of its terms. The value is above the rounding error of a few operations. A larger
/// value would leave torques too large where the units of the joints differ by 1e5. Range: 1e-15 to 1e-10.
pub(crate) const REDUCED_GRADIENT: f64 = 1e-14;

/// Component of the unit vector of internal forces and torques that counts as zero where its sign is chosen. The value is above the rounding
/// error of a component. Range: 1e-14 to 1e-6.
pub(crate) const INTERNAL_COMPONENT: f64 = 1e-9;

// --- Contact modes ---

/// Margin of a test of Table I within which the test counts as a tie. Unit: load.
///
/// A tie is decided for the closed and static word: if |a_n| is below this value, the contact is not S; if |a_t| is below it, the contact
/// is neither R nor L; and f_n ≥ −`TIE` suffices for a closed contact. Exception: if no word is consistent by these rules, a strict test
/// holds as soon as its a_n or a_t is positive. Rows have length one and loads have size one, so that rounding errors are about 1e-16 times
/// the condition number of the system of a word. A larger value would blur modes that differ. Range: 1e-12 to 1e-8.
pub const TIE: f64 = 1e-10;

/// Acceleration that counts as an exact zero if the held rows and the biases alone determine it. Unit: load.
///
/// Such a zero may have a reason that the numbers do not show: a body on four contacts, for instance, rebounds with −e times its velocity.
/// Its rounding error is about 1e-16 times the condition number of the rows. A larger value would hide ties; a smaller value would report
/// rounding errors as ties. Range: 1e-15 to 1e-12.
pub(crate) const FIXED_ACCELERATION: f64 = 1e-14;

/// Part of a contact row orthogonal to other rows below which it depends linearly on them. Unit: length of the row, which is about one.
/// Rows have rounding errors of about ε. A larger value would treat two contacts that are close together as one contact. Range: 1e-12 to
/// 1e-8.
pub(crate) const DEPENDENT_ROW: f64 = 1e-10;

/// Length of the part of the unit vector of a coordinate that is orthogonal to the rows at rest, up to which the coordinate rests, too.
/// Unit: ε. Range: 4 to 64.
pub(crate) const RESTING_COORDINATE: f64 = 8.0;

/// The same for contacts whose rates are rounding errors and are set to zero. A row that is nearly dependent would multiply them by the
/// inverse of this value, and stop a real rotation. Range: 1e-9 to 1e-5.
pub(crate) const STOPPED_ROW: f64 = 1e-7;

/// A component of the internal force of two fixed contacts of a mechanism that is at most this times the force is the rounding error of an
/// exact zero: friction may then allow internal forces without bound. Range: 4 ε to 1e4 ε.
pub(crate) const NO_INTERNAL_FORCE: f64 = 64.0 * f64::EPSILON;

/// Acceleration that may come from a force outside its cone, as a multiple of the amount by which the force is outside; an acceleration
/// below it does not count as different from zero. Rows have length about one. Range: 10 to 1e3.
pub(crate) const CONE_TIE_ACCELERATION: f64 = 100.0;

/// Deviation of the length of a given tangent from one that is accepted. Decimals such as 0.8 and 0.6 are rounded. Range: 1e-15 to 1e-6.
pub(crate) const UNIT_TANGENT: f64 = 1e-12;

/// Accelerations below which the solution of a convex programme counts as zero; they are tried in this order. Unit: load. Clarabel's
/// tolerance of 1e-8 in the objective allows at most 1e-4 in the acceleration. Range: 0 to 1e-3.
#[cfg(feature = "qp")]
pub(crate) const QP_ZERO: [f64; 3] = [0.0, 1e-6, 1e-4];

/// Accuracy of convex programmes with few entries in each row. Relative. Clarabel reaches it for assemblies of 300 bodies. Range: 1e-11 to 1e-8.
#[cfg(feature = "qp")]
pub(crate) const SPARSE_ACCURACY: f64 = 1e-10;

/// Finest accuracy of such programmes. Relative. Asked of one programme whose solution at `SPARSE_ACCURACY` breaks Coulomb's law by more than `LAW`; with 300 bodies Clarabel
/// does not always reach it. Range: 1e-13 to 1e-11.
#[cfg(feature = "qp")]
pub(crate) const SPARSE_FINEST: f64 = 1e-12;

/// Accuracy with which such a programme is accepted where Clarabel goes no further. Relative. Range: 1e-9 to 1e-7.
#[cfg(feature = "qp")]
pub(crate) const SPARSE_REDUCED: f64 = 1e-8;

/// Breach of Coulomb's law, a force or an acceleration, up to which a contact mode of a large assembly is accepted. Unit: largest component of the load, in the
/// mass metric. Range: 1e-9 to 1e-7.
#[cfg(feature = "qp")]
pub(crate) const LAW: f64 = 1e-9;

/// Change of the sliding accelerations from one convex programme to the next below which the words of their solutions are solved. Unit: largest component of the
/// load. Range: 1e-4 to 1e-1.
#[cfg(feature = "qp")]
pub(crate) const NEAR_FIXED_POINT: f64 = 1e-2;

/// What is added to the squares of the changes of the last programmes in the extrapolation from them, where some depend on others. Relative to the sum of these squares. A smaller value
/// extrapolates from errors of the programmes. Range: 1e-14 to 1e-8.
#[cfg(feature = "qp")]
pub(crate) const DEPENDENT_STEP: f64 = 1e-14;

/// Least acceleration of a contact, normal or along, of a word that counts as one that moves. Unit: largest component of the load, in the mass metric. The
/// least multiple of a load at which an assembly moves is off by the multiples that belong to smaller accelerations, about as much. Range: 1e-8 to 1e-4.
pub(crate) const LEAST_MOTION: f64 = 1e-6;

/// Acceleration of a contact of a mode that is shown, in the same unit: large enough that errors of linear programmes do not count. Range: 1e-6 to 1e-3.
pub(crate) const SHOWN_MOTION: f64 = 1e-5;

/// Distance above the static factor of a load at which the mode is asked that begins there. Unit: largest component of gravity, in the mass metric. Larger than the
/// error of the factor. Range: 1e-8 to 1e-4.
pub(crate) const JUST_ABOVE: f64 = 1e-6;

/// The same distance for assemblies with too many contacts for a mechanism, whose modes are known to fewer digits. Range: 1e-4 to 1e-2.
pub(crate) const ABOVE_LARGE: f64 = 1e-3;

/// Breach of Coulomb's law, a force or an acceleration, that counts as zero in a linear programme. Unit: largest component of the load, in the mass metric.
/// Less than `LEAST_MOTION`. Range: 1e-11 to 1e-8.
pub(crate) const BROKEN_LAW: f64 = 1e-9;

/// Accelerations below which a solution found by pivoting counts as zero; they are tried in this order. Unit: load. Pivots leave rounding errors.
/// Range: 0 to 1e-6.
#[cfg(feature = "qp")]
pub(crate) const PIVOTED_ZERO: [f64; 3] = [1e-13, 1e-11, 1e-8];

/// Accuracies that Clarabel is asked for, tried in this order. Only the active edges of the cones are needed, and a rough solution shows
/// them in most cases. Range: 1e-10 to 1e-3.
#[cfg(feature = "qp")]
pub(crate) const QP_ACCURACIES: [f64; 2] = [1e-5, 1e-9];

/// Residual of the balance of forces that counts as zero. Unit: the largest force. A sum of up to 64 forces has a smaller rounding error; a
/// set of active edges with one edge too many leaves a larger residual. Range: 1e-14 to 1e-11.
#[cfg(feature = "qp")]
pub(crate) const FORCE_BALANCE: f64 = 1e-13;

/// Change of the acceleration of free fall during a sum of impacts that counts as none. Unit: its rounding error. Range: 0.1 to 100.
pub(crate) const STEADY_FALL: f64 = 1.0;

/// How far ahead the load is taken where a body at rest begins to move under a load that changes: so that the words differ by more than ties do.
/// Unit: the time in which the load changes by itself. Range: 1e-8 to 1e-4.
pub(crate) const LOAD_AHEAD: f64 = 1e-6;

/// Longest step under a load that changes, in units of time: the roots of cubics keep their digits. Range: 1 to 100.
pub(crate) const CHANGING_LOAD_REACH: f64 = 4.0;

/// Entry of a tableau of Lemke's method that counts as zero, and difference of two ratios that counts as a tie. The coefficients are of order one.
/// After hundreds of pivots entries have errors of 1e-12: with that value a stack of 20 books ended in a false ray. Range: 1e-11 to 1e-8.
#[cfg(feature = "qp")]
pub(crate) const LEMKE_ZERO: f64 = 1e-10;

/// Entry of a simplex tableau that counts as zero. The programmes have coefficients of order one. Range: 1e-14 to 1e-9.
pub(crate) const SIMPLEX_ZERO: f64 = 1e-12;

// --- Zeno points ---

/// Estimated error of the sum of a tail below which the sum is taken. Unit: time elapsed.
///
/// The estimate for a clattering tail can be 9 times too low. With this value, about ε/44, the error is still below half an ulp of the
/// time. Range: 1e-20 to 1e-17.
pub(crate) const TAIL: f64 = 5e-18;

/// Value of (2gh/u²)²τ below which the sum of a clattering tail is tried. Unit: time elapsed. τ is the last flight; h, u and g are the gap,
/// its rate and the gravity of the contact that lands next. The error of the sum grows like this value. A larger tolerance costs attempts
/// that fail; a smaller tolerance costs collisions that could have been summed. No result depends on it beyond [`TAIL`]. Range: 10 to 1e4
/// times [`TAIL`].
pub(crate) const TRY_TAIL: f64 = 1e2 * TAIL;

/// Estimated error of the sum of the bounces of one contact below which the sum is taken. Unit: ε times the time elapsed, the smallest gap
/// of the others or the size of the body, and the largest speed after these bounces. To follow the bounces one by one adds about one such
/// error each. Range: 0.01 to 4.
pub(crate) const BOUNCE_SUM: f64 = 0.5;

/// Error of such a sum that is its rounding error. Unit: ε times the change of each quantity until the limit. Range: 1 to 16.
pub(crate) const BOUNCE_CHANGE: f64 = 4.0;

/// What the coefficient before the last one adds to the estimate of the error of a polynomial: either may vanish by chance. Range: 0.01 to 1.
pub(crate) const NEXT_TERM: f64 = 0.1;

/// Remaining time of an accumulation without a closed form below which its end counts as reached. Unit: time elapsed. The value is below
/// the rounding error of the time. Range: 1e-18 to 1e-16.
pub(crate) const REACHED: f64 = 1e-17;

/// Largest relative change over one cycle of impacts for which the cycle counts as repeated. Compared are quantities without scale, such as
/// ratios of speeds. Range: 1e-8 to 1e-4.
pub(crate) const SELF_SIMILAR: f64 = 1e-6;

/// Ratio of the speeds of a clattering state to g T0 above which the sum leaves gravity out. T0 = h_b/d is the time left, so that g T0 is
/// the speed that gravity can add. Range: above 4.
pub(crate) const GRAVITY_NEGLIGIBLE: f64 = 16.0;

/// Value of 1 − ψ_1ψ_2 below which the rows of two gaps count as parallel. It has a rounding error of a few ε. Range: 8 ε to 64 ε.
pub(crate) const PARALLEL_GAP_ROWS: f64 = 16.0 * f64::EPSILON;

/// Largest error of the sum of a regular motion. Unit: time of its end. An error of ε in the energy of each of n impacts leaves about nε. Range:
/// 1e-14 to 1e-10.
pub(crate) const REGULAR_ERROR: f64 = 1e-12;

/// Error of the sum of a regular motion above which a polynomial of a higher degree is not tried. Unit: [`REGULAR_ERROR`]. Only the cost depends on
/// it. Range: 1e2 to 1e8.
pub(crate) const REGULAR_PROMISING: f64 = 1e5;

/// Largest loss 1 − f of a regular cycle, f the factor of the size of the motion. Up to rest some 40/(1 − f) cycles are left, and a sum costs as much
/// as some ten thousand of them. Only the cost depends on it. Dimensionless. Range: 1e-4 to 1e-3.
pub(crate) const REGULAR_LOSS: f64 = 3e-4;

/// Growth of the distance of shapes from a regular cycle, squared, in a cycle. Unit: loss 1 − f of the cycle. While the speeds fall by 17 digits, the
/// distance then grows by a fifth at most. Range: 1e-3 to 1e-2.
pub(crate) const REGULAR_DRIFT: f64 = 1e-2;

/// Least distance from a regular cycle, in shapes, that a sum is made for: the disc is more than a point. Range: 1e-8 to 1e-4.
pub(crate) const REGULAR_RADIUS: f64 = 1e-6;

/// Half the distance of the two shapes whose difference tells the tangent map of a cycle of impacts. Dimensionless. Range: 1e-8 to 1e-4.
pub(crate) const REGULAR_TANGENT: f64 = 1e-6;

/// Ratio (2u_a − g_aτ)/u_a below which contact a returns to the ground at nearly the time τ of the other touchdown. The order of the two is
/// then decided from the difference of the times. Range: 1e-15 to 1e-6.
pub(crate) const LANDING_ORDER_CLOSE: f64 = 1e-14;

/// Next flight of an accumulation below which its remaining time is computed and compared with [`REACHED`]. Unit: time elapsed. Range:
/// 1e-17 to 1e-12; only the cost depends on it.
pub(crate) const NEARLY_REACHED: f64 = 1e-16;

/// Bound of the time to rest above which a run does not examine whether the geometry can be frozen. Unit: time elapsed. Range: 1e-6 to
/// 1e-1; only the cost depends on it.
pub(crate) const TAIL_TOO_LONG: f64 = 1e-3;

/// Safety factor on the estimated change of the geometry within a tail. Range: 1 to 16.
pub(crate) const FROZEN_CHANGE_MARGIN: f64 = 4.0;

/// Difference |b_1 − b_2| of two arms above which equal gap rates over one ground prove ω = 0. Unit: √(b² + ρ²). If the arms differ by
/// less, the rates of a turning body can be equal within their rounding errors. Range: 1e-6 to 1e-2.
pub(crate) const CONTACTS_APART: f64 = 1e-3;

/// Speed of the body at a touchdown, with another contact held, that counts as zero. Unit: the largest speed of the run, or gravity times the
/// time elapsed if that is larger. The value is about 50 ε. Range: 1e-15 to 1e-13.
pub(crate) const QUIET_LANDING: f64 = 1e-14;

/// Speed of a mechanism at a touchdown of one of three or more contacts, with another one held, that counts as zero. Unit: that of `QUIET_LANDING`. Nested
/// accumulations of several contacts that are hit one after the other go on for ever with speeds of about 1e-10, which rounding errors of the gaps leave. Range: 5e-10 to 1e-8.
pub(crate) const QUIET_CHATTER: f64 = 1e-9;

/// Rounding error of the ratio of two landing speeds that are one cycle apart. Unit: ε. Range: 16 to 256.
pub(crate) const CYCLE_RATIO_ROUNDINGS: f64 = 64.0;

/// Safety factor on what the sum of a series of cycles leaves out: on the time v/g for which a speed v set to zero stands, and on the
/// distance that a contact still covers along the ground. Range: 1 to 16.
pub(crate) const REMAINDER_FACTOR: f64 = 4.0;

/// Value of √(u² + 2gh) of a contact below which the contact has come to rest. Unit: the largest speed of the run. The speeds of the body
/// have rounding errors of this size. Range: 5e-17 to 1e-14.
pub(crate) const CONTACT_STOPPED: f64 = 1e-16;

/// Speed below which a contact may take part in one sequence of impacts with a contact below [`CONTACT_STOPPED`], so that both must be slow
/// before either of them rests. Unit: [`CONTACT_STOPPED`]. Range: 10 to 1e6.
pub(crate) const HIT_IN_TURN: f64 = 1e3;

/// Effective gravity of a contact that counts as zero. Unit: ε times the sum of gravity and the acceleration |c| ω² of the contact. At a
/// vertical wall the component of gravity along the normal is a rounding error of either sign, and a time that is inversely proportional
/// to it would be arbitrary. Range: 2 to 64.
pub(crate) const PULL_ROUNDINGS: f64 = 8.0;

/// Relative rounding error of the change of velocity over one cycle of impacts at one instant. Unit: ε. Range: 16 to 256.
pub(crate) const SEQUENCE_RATIO_ROUNDINGS: f64 = 64.0;

/// Impacts at one instant are summed as a geometric series, and the rounding error of its ratio causes an error of the summed velocity. If
/// that error is above this value, the series is not summed. Unit: the largest speed of the run. At this value half of the digits are
/// correct. Range: 1e-12 to 1e-6.
pub(crate) const SUMMED_VELOCITY: f64 = 1e-8;

/// Growth of the largest speed by impacts of one instant from which on they end the run: a law that raises the energy of a wedged body does so
/// without bound. Unit: the largest speed before them. Range: 1e3 to 1e9.
pub(crate) const RUNS_AWAY: f64 = 1e6;

/// Ratio of the largest speeds of two successive blocks of 256 impacts below which the speeds count as constant. Contacts that lose a
/// hundredth of their speed in each impact have a larger ratio. Range: 2 to 100.
pub(crate) const SLOWER_STRETCH: f64 = 8.0;

/// Ratio of the fastest impacts in two successive blocks of impacts above which a message says that the impacts become faster or slower.
/// Range: 1.001 to 1.1.
pub(crate) const CHANGED_SPEED: f64 = 1.02;

// --- Sustained contact ---

/// Speed of a whole body that counts as zero where no contact mode is consistent with it. Unit: the largest speed of the run. Impacts of two
/// contacts one after the other (in a wedge, at a wall) leave such speeds of a motion that ends. A slower body that really slides could jam.
/// Range: 1e-12 to 1e-8.
pub(crate) const LEFT_OF_ZERO: f64 = 1e-10;

/// Sliding speed that counts as zero if friction can hold the contact. Unit: the largest speed of the run. Also the acceleration of a body
/// at rest that counts as zero. Unit: gravity. Sums of rounded impulses leave speeds of about 1e-15. A larger value would end nested
/// accumulations too early, by the same fraction of their time. Range: 1e-14 to 1e-12.
pub(crate) const STILL: f64 = 3e-14;

/// Distance of a contact from a piece of ground, or from an end of a piece, that counts as zero. Unit: displacement, arm and size of the
/// body. Also the speed of a contact at a vertex that counts as zero. Unit: speed of the body. The rounding errors of both corners on which
/// a body stands tilt the body. Range: 16 ε to 256 ε.
pub(crate) const PLACE: f64 = 64.0 * f64::EPSILON;

/// Arm of the centre of a disc below which it counts as zero: the centre is then the centre of mass. Unit: machine epsilon times the sum of
/// the coordinates of both and the radius. Reason: the rounding errors of cos, sin and of four products and sums. Range: 4 to 64.
pub(crate) const DISC_CENTER: f64 = 8.0;

/// Length below which a part of the ground of the centre of a disc, between two others, is left out. Unit: the radius, or 1 rad of an arc. Reason:
/// rounding errors of its two ends. Range: 1e-15 to 1e-11.
pub(crate) const SHORT_PART: f64 = 1e-13;

/// Distance below which the ends of two parts of the ground of the centre of a disc are one joint. Unit: the radius and the coordinates of the
/// joint. Reason: where two arcs nearly touch each other, their joint is known up to the square root of a rounding error. Range: 1e-10 to 1e-6.
pub(crate) const SAME_JOINT: f64 = 1e-8;

/// Rounding error of a place on a straight part of the ground of the centre of a disc. Unit: ε times the length of the part. Reason: a product and
/// two sums. Range: 2 to 64.
pub(crate) const PLACE_ON_PART: f64 = 8.0;

/// Distance of a contact in its nominal position from a vertex that counts as zero. Unit: sum of the absolute coordinates of the contact.
/// Coordinates are given with a rounding error of a few ε. Range: 2 ε to 16 ε.
pub(crate) const SAME_VERTEX: f64 = 8.0 * f64::EPSILON;

/// Distance of the point of a disc from its ground, or from the circle about a given centre. Unit: size of the numbers. Files may hold a point
/// with few digits. Range: 1e-12 to 1e-6.
pub(crate) const DISC_POINT: f64 = 1e-9;

/// Rise of √(2T), with the kinetic energy T, in an impact that is more than its rounding error. Unit: √(2T) before. Range: 1e-12 to 1e-6.
pub(crate) const ENERGY_GAIN: f64 = 1e-9;

/// The same for slow motions after faster ones. Unit: ε times the largest speed so far. Range: 16 to 1e4.
pub(crate) const GAIN_ROUNDINGS: f64 = 1e3;

/// Bound of the rounding errors of the distance of a box and of a thing in it. Relative. Range: 1e-15 to 1e-3; a larger value costs time only.
pub(crate) const BOX_DISTANCE: f64 = 1e-12;

/// Distance from a piece of ground beyond which a point is not struck now: far more than its way in the rounding error of the clock. Unit: size
/// of the body. Range: 1e-9 to 1; a larger value costs time only.
pub(crate) const STRUCK_NEAR: f64 = 1e-3;

/// Difference of two rows of contacts that counts as rounding error: they are turned step by step between two computations from the angle. Unit:
/// the length of both rows of a contact. A foot that is so near to a line has a gap of that size. Range: 32 ε to 1e-12.
pub(crate) const ROWS_ALIKE: f64 = 256.0 * f64::EPSILON;

/// Distance from a straight line through two contacts up to which another contact is on it. Unit: size of the body. Range: 2 ε to 32 ε.
pub(crate) const ON_A_LINE: f64 = 8.0 * f64::EPSILON;

/// Bound of the rounding error of a rate or gap computed from others above which the bound of its stored value replaces it. Unit: the velocity or
/// displacement. Range: 1e-11 to 1e-6.
pub(crate) const USELESS_BOUND: f64 = 1e-9;

/// Largest sliding speed that counts as zero just after a sum of impacts. Unit: the sliding speed that counts as zero elsewhere. The error
/// of the time of the sum, times gravity, is an error of the speed; nested sums have errors of some hundred units. Range: 1e2 to 1e4.
pub(crate) const SLOWEST_KNOWN: f64 = 1e3;

/// Gap below which a contact lands together with another contact. Unit: bound of the rounding error of the gap. The bound leaves out the
/// errors of the motion of the body, which are a few times as large for all gaps. Range: 4 to 64.
pub(crate) const LANDS_TOGETHER: f64 = 16.0;

/// Largest ratio of the gap rates of two contacts that enters the gap at which they land together. That gap grows with the ratio. Range: 2
/// to 100.
pub(crate) const LANDS_TOGETHER_SPEED: f64 = 8.0;

/// Gap rate of a contact in a vertex that counts as zero. Unit: ε times the terms of the rate. A contact that passes horizontally over a
/// vertex has rate zero there, and its acceleration decides on which piece it goes on. A contact in a narrow vertex has rate zero on both
/// pieces, and rests. Each crossing of the vertex adds rounding errors. Range: 4 to 64.
pub(crate) const OVER_VERTEX: f64 = 16.0;

/// Depth below the ground that a contact may reach without landing, as long as it comes up again. Unit: ε times the size of the body. The
/// smaller one of this depth and [`GRAZE_OF_WAY`] is the limit. Range: 1 to 16.
pub(crate) const GRAZE_OF_SIZE: f64 = 4.0;

/// As [`GRAZE_OF_SIZE`], but with the unit: ε times the distance that the contact has covered in this word. Range: 4 to 64.
pub(crate) const GRAZE_OF_WAY: f64 = 16.0;

/// Speed of the body below which the whole body has stopped when one of its contacts stops sliding. Unit: the sliding speed that counts as
/// zero. All speeds decrease to zero together, and the instant at which they vanish has a rounding error. Range: 10 to 1e5.
pub(crate) const BODY_STOPPED: f64 = 1e3;

/// Sliding speed that counts as zero beside another contact that slides. Unit: the speed of that contact. Range: 1e-13 to 1e-8.
pub(crate) const SLOWER_SLIDE: f64 = 1e-10;

/// Relative difference of the energies of two swings below which the energies count as equal. A swing has about twenty steps, each with one
/// rounding error. Range: 4e-15 to 1e-12.
pub(crate) const SWING_REPEATS: f64 = 1e-14;

/// Value of |n_i − n_j| ρ/|b_i − b_j| below which two pieces of ground count as parallel, and the rotation is computed from the difference
/// of the rows of their contacts. The terms of that difference are smaller by this factor than the terms that cancel otherwise. Range: 1e-5
/// to 1e-2.
pub(crate) const PARALLEL_GROUND: f64 = 1e-3;

/// Part of a row orthogonal to other rows that counts as zero. Unit: length of the row. The row then follows from the others in exact
/// arithmetic too. Range: 1 ε to 16 ε, divided by [`NEARLY_EQUAL_ROWS`].
pub(crate) const IMPLIED_ROW: f64 = 4.0 * f64::EPSILON / NEARLY_EQUAL_ROWS;

/// Difference of two rows below which they count as nearly equal. Also the part of a row orthogonal to other rows below which the row is
/// not used beside them. Unit: length of the row. Range: 1e-5 to 1e-1.
pub(crate) const NEARLY_EQUAL_ROWS: f64 = 1e-3;

/// Difference between a gap and its value computed from the gaps of the other closed contacts below which the computed value is taken.
/// Unit: ε times the sum of size and displacement of the body. A larger difference means that the ground under this contact is uneven.
/// Range: 16 to 1e3.
pub(crate) const UNEVEN_GAP: f64 = 64.0;

/// Ratio of the velocity after a projection to the velocity before it below which the projection is repeated, because the part removed has
/// a rounding error too. Range: 1e-12 to 1e-4.
pub(crate) const CORRECTED_VELOCITY: f64 = 1e-8;

/// Determinant of a friction matrix below which the matrix is singular. Unit: product of the lengths of its columns. The rounding error of
/// the determinant is about 1e-15. Steps towards a jam that come closer than this do not move the body. Range: 2e-15 to 1e-12.
pub(crate) const SINGULAR_FRICTION_MATRIX: f64 = 1e-14;

/// Distance of a force from the edge of the hull of two friction cones that counts as zero. Unit: the force. Range: 16 ε to 256 ε.
pub(crate) const HULL_EDGE: f64 = 64.0 * f64::EPSILON;

/// Drift of the position of a fixed contact above which it is corrected. Unit: displacement of the body plus arm of the contact. Range: 1 ε
/// to 8 ε.
pub(crate) const DRIFT: f64 = 2.0 * f64::EPSILON;

/// Potential energy of a drift above which the drift is not corrected. Unit: kinetic energy. The rounding error of a position can be worth
/// more than all the energy of a small motion. Range: 4 ε to 64 ε.
pub(crate) const DRIFT_ENERGY: f64 = 16.0 * f64::EPSILON;

/// Taylor coefficient of the rate of a row above which it is not zero. Unit: its terms. Range: 1e-13 to 1e-7.
pub(crate) const RATE_COEFFICIENT: f64 = 1e-9;

/// Part of a force outside its friction cone that counts as zero. Unit: the largest force. Range: 1e-13 to 1e-7.
pub(crate) const FORCE_OUTSIDE_CONE: f64 = 1e-9;

/// Speed of a frictionless contact in a vertex of its terrain below which it has come to rest there. Unit: the largest speed of the run.
/// The speed is a difference of speeds of the body, with a rounding error of a few ε of them. Range: 1e-15 to 1e-13.
pub(crate) const WEDGED: f64 = 1e-14;

/// Ratio n_y,next/n_y,old above which the gap over the old, steeper piece is not converted to a gap over the next piece, because this would
/// lose more digits than the rounding error of the gap accounts for. The gap is then computed from the position. Range: 2 to 64.
pub(crate) const STEEPER_PIECE: f64 = 8.0;

// --- Proved bounds ---

/// Duration of a flight below which it does not change the time. Unit: time elapsed. Range: ε/16 to ε.
pub(crate) const FLIGHT_UNRESOLVED: f64 = f64::EPSILON / 8.0;

/// Width of the enclosure of a Zeno time below which the enclosure is not narrowed further. Unit: time elapsed. The width is then below the
/// rounding error of its ends. Range: ε/64 to ε; only width and cost depend on it.
pub(crate) const NARROW_ENOUGH: f64 = f64::EPSILON / 8.0;

/// Distance of a Zeno time from its proved bounds above which the run has a warning. Unit: time elapsed. Range: 1e-15 to 1e-12.
pub(crate) const OUTSIDE_PROVED_BOUNDS: f64 = 1e-13;

/// Rounding error of the time of a run, as part of the error of a Zeno time. Unit: ε times the time elapsed. Range: 1 to 16.
pub(crate) const CLOCK_ROUNDINGS: f64 = 4.0;

// --- Films ---

/// Shortest time before a Zeno point that a film by Zeno time shows where there is no gravity or no body to say which gap can still be
/// seen. Unit: the time from the Zeno point before, or from the start. A smaller value makes the film longer. Range: 1e-14 to 1e-6.
pub(crate) const NEAREST_FRAME: f64 = 1e-12;

/// Rounding error of the clock of a run, as the shortest time before a Zeno point that a film shows. Unit: ε times the time on the clock.
/// The time left is a difference of two times on the clock. Range: 2 to 64.
pub(crate) const NEAREST_FRAME_ROUNDINGS: f64 = 4.0;

// --- Stability ---

/// Margin of a condition below which rounding errors may decide the verdict. Unit: size of the body, or load. Range: 1e-13 to 1e-8.
pub(crate) const DELICATE_MARGIN: f64 = 1e-10;

/// Distance of a contact from the line through two others with equal slopes below which it counts as on this line. Unit: size of the body. The
/// coordinates of points on a slope are rounded, in decimals too. Range: 1e-14 to 1e-9.
pub(crate) const ON_ONE_LINE: f64 = 1e-12;

/// Part of a row orthogonal to other rows up to which it may or may not depend on them, so that nothing is decided that needs their rank; also the gap along a
/// unit direction up to which a contact may be open or closed. Unit: length of the row. Up to [`DEPENDENT_ROW`] rows do depend and gaps are closed. The value
/// is far above the width of numbers in decimals times the condition of the rows. Range: 1e-9 to 1e-4.
pub(crate) const FIRM_RANK: f64 = 1e-7;

/// Cross product of two edges of friction cones below which the edges are parallel. Unit: terms of the product. Range: 4 ε to 64 ε.
pub(crate) const PARALLEL_EDGES: f64 = 8.0 * f64::EPSILON;

/// Moment of a combination of forces with zero sum that counts as zero. Unit: the moments of the single forces. Range: 1e-15 to 1e-11.
pub(crate) const SQUEEZE_MOMENT: f64 = 1e-13;

/// Component of a force in a direction in which the family of forces is unbounded that counts as zero. Unit: sum of the weights of that
/// direction. Range: 1e-12 to 1e-6.
pub(crate) const UNBOUNDED_DIRECTION: f64 = 1e-9;

/// Distance of two shapes below which the orbit has returned. Unit: one plus the absolute value of the coordinate. A chaotic orbit returns
/// as close by chance about once in 1e9 impacts; each return is then tested by its tangent map. Range: 1e-12 to 1e-7.
pub(crate) const RECURRENCE: f64 = 1e-9;

/// Distance of a shape from an attracting cycle, computed with the tangent map, below which the cycle counts as reached. Unit: one plus the
/// absolute value of the coordinate. Range: 1e-9 to 1e-4.
pub(crate) const CYCLE_REACHED: f64 = 1e-6;

/// Accumulated rounding error of a shape up to which the fate found is the fate of the given start. Unit: one plus the absolute value of
/// the coordinate. A chaotic transient exceeds it after about fifty impacts. Range: 1e-9 to 1e-4.
pub(crate) const SHAPE_LOST: f64 = 1e-6;

/// Landing speed of the reduced map below which the contact rests on the terrain. Unit: the size of the reduced state. The bounces of this
/// contact would last less than the rounding error of any time here. Range: 1e-140 to 1e-20.
pub(crate) const SHAPE_AT_REST: f64 = 1e-100;

/// Half-width of the largest box of shapes around a self-similar cycle that is tried: how much the impacts of all shapes in the box may
/// differ. Unit: the shape. Range: 1e-5 to 1e-2; the proof is in intervals, and only its success depends on it.
pub(crate) const SIMILAR_BOX: f64 = 1e-3;

/// Difference of two directions below which an orbit has closed. Unit: rad. Only the start of a search depends on it; the certificate is
/// proved in intervals. Range: 1e-13 to 1e-6.
pub(crate) const ORBIT_CLOSED: f64 = 1e-9;

/// Energy 2E per unit mass below which a frictionless flight is not followed further. Unit: square of the landing speed at its start. All that may
/// follow is part of what is proved, so that the value changes only how much is decided. Range: 1e-20 to 1e-8.
pub(crate) const CUT_ENERGY: f64 = 1e-8;

/// Decrease of its potential that a certificate requires on each step, in addition to the logarithm of the growth. Range: 1e-12 to 1e-6; a
/// larger value refuses certificates.
pub(crate) const STRICT_DECREASE: f64 = 1e-9;

/// Rounding error of a limit of a cell of directions, which is a tangent of an angle. Unit: one plus its absolute value. Range: 1e-15 to
/// 1e-9.
pub(crate) const CELL_LIMIT_ROUNDING: f64 = 1e-14;

/// Sine y/r of a direction below which an orbit that is searched for a cycle counts as ended, in a slide or at rest. Range: 1e-15 to 1e-6;
/// only the search depends on it.
pub(crate) const SLIDE_END: f64 = 1e-12;

/// Absolute error of a sine, a cosine or an arc tangent of a computed angle; the error of a tangent is 1 + tan² times as large. The value
/// is more than two ulp. Range: above 2.3e-16.
pub(crate) const TRIGONOMETRIC_ERROR: f64 = 4e-16;

/// Margin of a proved bound for the rounding errors of its few operations, logarithms and exponential functions. Relative. Range: above
/// 1e-14.
pub(crate) const BOUND_MARGIN: f64 = 1e-12;

/// Excess of the height to which a random start is lifted over the height at which it touches the ground, so that rounding errors leave no
/// gap negative. Relative. Range: 1e-14 to 1e-3.
pub(crate) const START_LIFT: f64 = 1e-9;

/// Share of the terms of a lower bound of a gap above which the bound counts as positive, so that no root is sought. The value is far above the
/// rounding error of its few operations. Relative. Range: 1e-14 to 1e-3.
pub(crate) const STAYS_OPEN: f64 = 1e-12;

/// Depth below a side of the body from which on a corner of the ground has entered the body. Unit: largest distance of a corner of the body
/// from its centre of mass. The value is above the rounding error of positions along a run. A larger value would miss shallower entries.
/// The reported time of an entry is the time of depth zero and does not depend on this value. Range: 1e-12 to 1e-6.
pub(crate) const EDGE_DEPTH: f64 = 1e-9;

/// Rotation of a body within an interval of time up to which the path of a point is approximated by a cubic; the error of the cubic is then
/// nearly largest at the middle of the interval. Unit: rad. Range: 0.1 to 1; only the cost depends on it.
pub(crate) const CUBIC_TURN: f64 = 0.5;

/// Bound of the error of that cubic. Unit: its error at the middle of the interval, which is the largest error except for terms of higher
/// order. Range: 1.5 to 10.
pub(crate) const MEASURED_ERROR: f64 = 2.0;

/// Relative error of the ends of intervals of pushes, unless another one is given. Runs near an end stand almost still for a time, and have
/// more rounding error than others. Range: 1e-14 to 1e-3.
pub(crate) const PUSH: f64 = 1e-9;

/// Push below which a push counts as none. Unit: the largest one that is tried. Bodies that any push makes fall have an interval from there
/// on. Range: 1e-300 to 1e-12.
pub(crate) const NO_PUSH: f64 = 1e-15;

/// Step of the central differences along a run. Unit: the size of what is changed. The error of a derivative is about its square, and that of
/// rounding is ε over it. Range: 1e-7 to 1e-4.
pub(crate) const SENSITIVITY_STEP: f64 = 1e-6;

/// Growth of a small change of the start beyond which it is no longer followed: all digits have long been lost. Range: above 1e32.
pub(crate) const FOLLOWED_GROWTH: f64 = 1e100;

/// Rate of an impact below which a change of the start is not followed through it. Unit: the largest rate of an impact since contacts were
/// last held for long. It is one of the last impacts of an accumulation. Range: 1e-8 to 1e-4.
pub(crate) const SLOW_IMPACT: f64 = 1e-6;

/// Rate of an impact from which on a change of the start is followed again. Unit: the largest rate of an impact since contacts were last
/// held for long. Range: 1e-5 to 1e-2.
pub(crate) const FRESH_IMPACT: f64 = 1e-4;

/// Time for which contacts are held up to which a phase belongs to an accumulation of impacts. Unit: √(size/g). Range: 1e-6 to 1e-1.
pub(crate) const LASTING_PHASE: f64 = 1e-3;

/// Part of a row of a held contact that is orthogonal to other rows, below which it depends on them. Unit: the length of the row. Range:
/// 1e-12 to 1e-6.
pub(crate) const SINGULAR_HOLD: f64 = 1e-9;

/// Estimated relative error of the end of a run from which on a warning says how much the end depends on the start. Half of all digits are
/// known then. Range: 1e-12 to 1e-3.
pub(crate) const FEW_DIGITS: f64 = 1e-8;
