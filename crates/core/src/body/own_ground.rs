//! Ground lines that the user can hardly have intended. Without a terrain each contact meets only its own straight line, and nothing
//! keeps a contact above the line of another contact.
//!
//! ```text
//!   (i)   1 |  2 falls below the line of 1      (ii)  3 ┌───┐ 4   the line of 3 and 4 is no floor of 1 and 2:
//!           |                                           │   │     turned over, the box rests on it
//!   ────────2────────                               ────1───2────
//! ```
//!
//! A line with a `segment` is not compared with other contacts.

use nalgebra::Vector2;
use smallvec::SmallVec;

use crate::body::contact::Contact;
use crate::body::geometry::ContactGeometry;
use crate::tolerance::SAME_GROUND;

/// A contact that is on or above the line of another contact in the nominal posture and can fall below that line, because its own line does
/// not prevent it.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Above {
    contact: usize,
    other: usize,
    /// Height of the contact over the line of the other contact in the nominal posture, in m.
    height: f64,
}

/// The pairs of contacts and lines that a run checks.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct OwnGround {
    above: SmallVec<[Above; 2]>,
    /// A contact that is below the line of another contact in the nominal posture, and that other contact. If there is such a pair, the
    /// lines cannot be one ground.
    below: Option<[usize; 2]>,
    /// Distance by which the contacts may move from the nominal posture before a check is needed, in m.
    pub(crate) room: f64,
}

/// Returns true if the line of a contact has no ends.
fn is_endless(contact: &Contact) -> bool {
    contact.segment == [f64::NEG_INFINITY, f64::INFINITY]
}

/// Height of one contact, of its nearest point, over the line of another in the nominal posture, in m.
fn height(contacts: &[Contact], lines: &[ContactGeometry], one: usize, other: usize) -> f64 {
    let (from, to) = (Vector2::from(contacts[other].point), contacts[one].center());
    lines[other].normal.dot(&(to - from)) - contacts[one].radius
}

impl OwnGround {
    /// `None`: no contact can fall below the line of another one. `lines`: the lines of the contacts. `size`: size of the body, in m.
    pub(crate) fn of(contacts: &[Contact], lines: &[ContactGeometry], size: f64) -> Option<Self> {
        let mut own = Self { above: SmallVec::new(), below: None, room: f64::INFINITY };
        let count = contacts.len();
        for j in (0..count).filter(|&j| is_endless(&contacts[j])) {
            for i in (0..count).filter(|&i| i != j) {
                let height = height(contacts, lines, i, j);
                if height < -SAME_GROUND * size {
                    own.below.get_or_insert([i, j]);
                    own.room = own.room.min(size);
                } else if !(is_endless(&contacts[i]) && lines[i].normal == lines[j].normal) {
                    own.above.push(Above { contact: i, other: j, height });
                    own.room = own.room.min((height + SAME_GROUND * size) * (1.0 - SAME_GROUND));
                }
            }
        }
        (own.below.is_some() || !own.above.is_empty()).then_some(own)
    }

    /// Distance by which the contacts may move from here before the next check, in m; or the warning. `lines`: the lines of the contacts.
    /// `size`: size of the body, in m. `moved`: displacement of each contact from its nominal point. `touches`: whether each contact is on
    /// its own line. `time`: in s.
    pub(crate) fn room(
        &self,
        contacts: &[Contact],
        lines: &[ContactGeometry],
        size: f64,
        moved: impl Fn(usize) -> Vector2<f64>,
        touches: impl Fn(usize) -> bool,
        time: impl Fn() -> f64,
    ) -> Result<f64, String> {
        let mut room = f64::INFINITY;
        for Above { contact, other, height } in &self.above {
            let way = moved(*contact);
            let left = height + lines[*other].normal.dot(&way) + SAME_GROUND * (size + way.norm());
            if left < 0.0 {
                return Err(format!(
                    "contact {} is below the ground line of contact {} at t = {:?} s, but on or above it in the nominal posture: {REMEDY}",
                    contact + 1,
                    other + 1,
                    time()
                ));
            }
            room = room.min(left * (1.0 - SAME_GROUND)); // the tolerance grows with the displacement
        }
        let Some([lower, upper]) = self.below else { return Ok(room) };
        let mut far = None;
        for k in (0..contacts.len()).filter(|&k| is_endless(&contacts[k])) {
            let left = size - moved(k).norm();
            if left < 0.0 && touches(k) {
                far = far.or(Some(k));
            }
            room = room.min(left.max(0.0));
        }
        let Some(k) = far else { return Ok(room) };
        // The line that is touched, if it cannot be ground.
        let under = |&i: &usize| height(contacts, lines, i, k) < -SAME_GROUND * size;
        let [lower, upper] =
            (0..contacts.len()).find(under).map_or([lower, upper], |lower| [lower, k]);
        Err(format!(
            "contact {} touches its own ground line at t = {:?} s, farther from its nominal point than the size of the body, but contact {} lies below the ground line of contact {} in the nominal posture, so that the lines cannot be one ground: {REMEDY}",
            k + 1,
            time(),
            lower + 1,
            upper + 1
        ))
    }
}

const REMEDY: &str = "without terrain= each contact meets only the straight line of its own slope through its own point; give one ground by terrain=, or the extent of each line by segment=";
