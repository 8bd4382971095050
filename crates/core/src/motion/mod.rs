//! The event loop: flight, impacts, accumulations of impacts and contact phases, until a run ends.

mod arrivals;
mod bounces;
mod cycles;
mod driver;
pub(crate) mod drops;
mod ground;
mod ground_watch;
mod impacts;
pub(crate) mod moving;
mod nested;
mod plain;
pub(crate) mod record;
pub(crate) mod replay;
mod rest;
mod rocking;
mod series;
mod sides;
mod slow;
mod stages;
pub(crate) mod subject;
mod vertices;

pub(crate) use driver::Driver;
