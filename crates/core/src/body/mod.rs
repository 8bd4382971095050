//! The body, its contacts and the terrain under them.

mod chain;
mod chain_equations;
pub(crate) mod contact;
mod contact_space;
mod drawn;
pub(crate) mod fields;
pub(crate) mod geometry;
pub(crate) mod ground;
mod holding;
pub(crate) mod lines;
pub(crate) mod local_model;
pub(crate) mod mechanism;
pub(crate) mod outline;
pub(crate) mod own_ground;
mod placing;
pub(crate) mod posture;
mod raised;
mod shape;
pub(crate) mod side;
pub(crate) mod state;
pub(crate) mod terrain;

pub use crate::tolerance::TOUCH;
pub use chain::{Base, Chain, ChainFields, Foot, Joint, JointKind, Link};
pub use chain_equations::ChainPoints;
pub use contact::Contact;
pub use contact_space::ContactSpace;
pub(crate) use contact_space::rows_of;
pub use drawn::GroundPiece;
pub use fields::{ContactRows, GroundKind, MechanismFields, PostureFields, Surface};
pub use holding::HoldingTorques;
pub use local_model::{LocalModel, LocalModelFields, LocalState};
pub use mechanism::{MAX_DOF, Mechanism};
pub use posture::{MAX_CONTACTS, Posture};
pub use shape::Lamina;
pub use state::State;
pub use terrain::MAX_VERTICES;
