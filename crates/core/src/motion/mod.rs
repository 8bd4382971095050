//! The event loops: flight, impacts, accumulations of impacts and contact phases in turn, until a run ends.

pub(crate) mod any;
pub(crate) mod frame;
pub(crate) mod ground_watch;
pub(crate) mod pair;
pub(crate) mod record;
pub(crate) mod rounds;
