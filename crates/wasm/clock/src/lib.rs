//! What Clarabel uses of the crate `web-time`, with a clock that stands still. The real one asks the browser and brings its imports along;
//! Clarabel only reports times, as no limit of time is set, so they change no result.

pub use std::time::Duration;

/// A time.
#[derive(Debug, Clone, Copy)]
pub struct Instant;

impl Instant {
    /// Now.
    #[must_use]
    pub fn now() -> Self {
        Self
    }

    /// No time has gone by.
    #[must_use]
    pub fn elapsed(&self) -> Duration {
        Duration::ZERO
    }
}
