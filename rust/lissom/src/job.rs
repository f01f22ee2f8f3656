//! Progress and cancellation of long work.

use std::sync::atomic::{AtomicU8, AtomicU64, Ordering};
use std::sync::{Arc, Mutex, PoisonError};

use rayon::prelude::*;

use crate::{Error, Result};

/// Items worked on between two looks at the job.
const BATCH: usize = 4096;

/// Phases of a job.
const RUNNING: u8 = 0;
const CANCELLED: u8 = 1;
const FINISHED: u8 = 2;

/// A handle shared by the thread that works and the one that watches.
///
/// The worker calls [`Job::report`] and, at least every 50 ms of work, [`Job::check`]; the watcher
/// reads [`Job::progress`] and may [`Job::cancel`].
#[derive(Debug, Clone, Default)]
pub struct Job(Arc<State>);

#[derive(Debug, Default)]
struct State {
    /// [`RUNNING`], [`CANCELLED`] or [`FINISHED`].
    phase: AtomicU8,
    fraction: AtomicU64,
    stage: Mutex<&'static str>,
}

impl Job {
    /// Says how far the work is: a fraction in 0-1 and the name of the stage.
    pub fn report(&self, fraction: f64, stage: &'static str) {
        self.0.fraction.store(fraction.clamp(0.0, 1.0).to_bits(), Ordering::Relaxed);
        *self.0.stage.lock().unwrap_or_else(PoisonError::into_inner) = stage;
    }

    /// Reports the next part of work whose number of parts is not known here: a third of the way that is left.
    ///
    /// # Errors
    ///
    /// [`Error::Cancelled`], see [`Job::check`].
    pub fn part(&self, stage: &'static str) -> Result<()> {
        let fraction = self.progress().0;
        self.report(fraction + (1.0 - fraction) / 3.0, stage);
        self.check()
    }

    /// The last report.
    pub fn progress(&self) -> (f64, &'static str) {
        let stage = *self.0.stage.lock().unwrap_or_else(PoisonError::into_inner);
        (f64::from_bits(self.0.fraction.load(Ordering::Relaxed)), stage)
    }

    /// Asks the worker to stop.
    pub fn cancel(&self) {
        self.leave(CANCELLED);
    }

    /// Ends what can be cancelled: what the work changes from here on, it changes whole.
    ///
    /// # Errors
    ///
    /// [`Error::Cancelled`], see [`Job::check`].
    pub fn finish(&self) -> Result<()> {
        self.leave(FINISHED);
        self.check()
    }

    /// The first to leave decides.
    fn leave(&self, phase: u8) {
        let _ = self.0.phase.compare_exchange(RUNNING, phase, Ordering::Relaxed, Ordering::Relaxed);
    }

    /// Whether the worker has been asked to stop.
    pub fn is_cancelled(&self) -> bool {
        self.0.phase.load(Ordering::Relaxed) == CANCELLED
    }

    /// [`Error::Cancelled`] once the watcher has asked to stop.
    pub fn check(&self) -> Result<()> {
        if self.is_cancelled() { Err(Error::Cancelled) } else { Ok(()) }
    }

    /// `of(0), of(1), ...` on all threads, with a look at the job now and then.
    ///
    /// # Errors
    ///
    /// [`Error::Cancelled`], see [`Job::check`].
    pub fn in_batches<T: Send>(&self, count: usize, of: impl Fn(usize) -> T + Sync) -> Result<Vec<T>> {
        let mut all = Vec::with_capacity(count);
        for start in (0..count).step_by(BATCH) {
            self.check()?;
            all.par_extend((start..count.min(start + BATCH)).into_par_iter().map(&of));
        }
        Ok(all)
    }
}
