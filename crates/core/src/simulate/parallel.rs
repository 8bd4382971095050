//! Many independent results on several threads. No result depends on the thread that computes it.

use std::cell::Cell;
use std::num::NonZero;
use std::ops::Range;
use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::thread::{self, available_parallelism};
use std::time::Duration;

use crate::error::Error;

/// Interval between two calls of `cancel`.
const POLL: Duration = Duration::from_millis(20);

/// Most results in a block, and least number of blocks per thread, so that threads finish at nearly the same time.
const TURN: usize = 512;
const TURNS: usize = 8;

/// Resources of the machine that many results may use. Results do not depend on them.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Resources {
    /// Threads; 0 counts as 1.
    pub threads: usize,
}

impl Default for Resources {
    /// All resources of the machine.
    fn default() -> Self {
        Self { threads: available_parallelism().map_or(1, NonZero::get) }
    }
}

/// The number of a result that could not be computed, and its error.
pub type FailedAt = (usize, Error);

/// Answers one item. Its second argument returns true once the computation is to stop; the result is then [`Error::Cancelled`].
pub type Answer<'a, T, A> = dyn Fn(&T, &dyn Fn() -> bool) -> Result<A, Error> + Sync + 'a;

/// Computes a block from a range of numbers. Once its second argument, called from time to time, returns true, the result is
/// [`Error::Cancelled`].
type Work<'w, B> = dyn Fn(Range<usize>, &dyn Fn() -> bool) -> Result<B, FailedAt> + Sync + 'w;

/// The blocks that `work` computes from 0..count, in order. A block has `least` numbers or more if there are as many. The error of
/// the lowest number if there are errors; [`Error::Cancelled`] once `cancel` returns true.
pub(crate) fn in_blocks<B: Send>(
    count: usize,
    least: usize,
    threads: usize,
    cancel: &dyn Fn() -> bool,
    work: &Work<'_, B>,
) -> Result<Vec<B>, FailedAt> {
    let threads = threads.clamp(1, count.max(1));
    let turn = count.div_ceil(threads * TURNS).clamp(least, TURN);
    if threads == 1 || count <= turn {
        let starts = (0..count).step_by(TURN);
        return starts.map(|from| work(from..(from + TURN).min(count), cancel)).collect();
    }
    let (next, stop) = (AtomicUsize::new(0), AtomicBool::new(false));
    let wrong: Mutex<Option<FailedAt>> = Mutex::new(None);
    let turns = || {
        let stopped = || stop.load(Ordering::Relaxed);
        let mut blocks = Vec::new();
        while !stopped() {
            let from = next.fetch_add(1, Ordering::Relaxed) * turn;
            if from >= count {
                break;
            }
            match work(from..(from + turn).min(count), &stopped) {
                Ok(block) => blocks.push((from, block)),
                Err((_, Error::Cancelled)) => break,
                Err((at, error)) => {
                    // Blocks are started in order and completed, so the first error is always found.
                    let mut slot = lock(&wrong);
                    if slot.as_ref().is_none_or(|(first, _)| at < *first) {
                        *slot = Some((at, error));
                    }
                    next.store(count, Ordering::Relaxed);
                    break;
                }
            }
        }
        blocks
    };
    let mut blocks = thread::scope(|scope| {
        let (done, ends) = channel::<()>();
        // If the system refuses threads, the existing ones do the work; if there are none, this one does.
        let workers: Vec<_> = (0..threads)
            .map_while(|_| {
                let done = done.clone();
                let work = || {
                    let blocks = turns();
                    drop(done);
                    blocks
                };
                thread::Builder::new().spawn_scoped(scope, work).ok()
            })
            .collect();
        drop(done);
        if workers.is_empty() {
            return turns();
        }
        while ends.recv_timeout(POLL) == Err(RecvTimeoutError::Timeout) {
            if cancel() {
                stop.store(true, Ordering::Relaxed);
            }
        }
        let joined = workers.into_iter().map(thread::ScopedJoinHandle::join);
        joined
            .flat_map(|blocks| blocks.unwrap_or_else(|panic| std::panic::resume_unwind(panic)))
            .collect::<Vec<_>>()
    });
    if stop.into_inner() {
        return Err((0, Error::Cancelled));
    }
    if let Some(wrong) = lock(&wrong).take() {
        return Err(wrong);
    }
    blocks.sort_unstable_by_key(|(from, _)| *from);
    Ok(blocks.into_iter().map(|(_, block)| block).collect())
}

/// The answers to many items, each computed by itself, in the order of the items. They do not depend on the number of threads.
///
/// `cancel` and `done` are called from time to time, always on the thread that has called this function: once `cancel` returns true, the
/// result is [`Error::Cancelled`]; `done` gets the number of items that have been answered since its last call.
///
/// ```
/// use standfast::simulate::{Resources, many};
/// use standfast::stability::stability;
/// use standfast::{Error, Lamina, Posture};
///
/// let rod = |e: u32| Posture::rod(0.5, &Lamina { gyration_radius: Some(0.2), restitution: f64::from(e) / 100.0, ..Lamina::default() });
/// let rods = (0..100).map(rod).collect::<Result<Vec<_>, _>>()?;
/// let verdicts = many(&rods, Resources::default(), &|| false, &|_| (), &|rod, _| stability(rod));
/// assert_eq!(verdicts.unwrap()[10].frictional_stability, stability(&rods[10])?.frictional_stability);
/// let stopped = many(&rods, Resources { threads: 1 }, &|| true, &|_| (), &|rod, _| stability(rod));
/// assert!(matches!(stopped, Err((0, Error::Cancelled))));
/// # Ok::<(), Error>(())
/// ```
///
/// # Errors
///
/// The number of the first item with an error, from 0, and its error.
pub fn many<T: Sync, A: Send>(
    items: &[T],
    resources: Resources,
    cancel: &dyn Fn() -> bool,
    done: &dyn Fn(usize),
    answer: &Answer<'_, T, A>,
) -> Result<Vec<A>, FailedAt> {
    let (answered, known) = (AtomicUsize::new(0), Cell::new(0));
    let report = || {
        let now = answered.load(Ordering::Relaxed);
        let since = now - known.replace(now);
        if since > 0 {
            done(since);
        }
    };
    let cancel = || {
        report();
        cancel()
    };
    let work = |numbers: Range<usize>, stop: &dyn Fn() -> bool| {
        let mut block = Vec::with_capacity(numbers.len());
        for at in numbers {
            if stop() {
                return Err((at, Error::Cancelled));
            }
            block.push(answer(&items[at], stop).map_err(|error| (at, error))?);
            answered.fetch_add(1, Ordering::Relaxed);
        }
        Ok(block)
    };
    let blocks = in_blocks(items.len(), 1, resources.threads, &cancel, &work)?;
    report();
    Ok(blocks.into_iter().flatten().collect())
}

/// A poisoned lock is ignored: the panic of its thread is propagated.
fn lock<T>(mutex: &Mutex<T>) -> std::sync::MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(std::sync::PoisonError::into_inner)
}
