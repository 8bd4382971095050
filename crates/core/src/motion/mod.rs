//! The event loop: flight, impacts, accumulations of impacts and contact phases, until a run ends.

mod any;
mod arrivals;
mod bounces;
mod driver;
mod ground_watch;
mod impacts;
mod lines;
mod mechanism;
mod mechanism_contact;
mod mechanism_impacts;
pub(crate) mod plain;
pub(crate) mod record;
mod nested;
mod sides;
mod slow;
mod stages;
pub(crate) mod subject;
mod vertices;

pub(crate) use any::AnyContacts;
pub(crate) use driver::Driver;
pub(crate) use mechanism::Jointed;
