//! Work on threads owned by Rust, which Python watches.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::mpsc::{Receiver, RecvTimeoutError, channel};
use std::sync::{Arc, Mutex, OnceLock, PoisonError};
use std::time::{Duration, Instant};

use lissom::{Error, Job};
use pyo3::prelude::*;
use pyo3::types::PyType;

use crate::errors;

/// How often a waiting call looks at signals (Ctrl-C) and at cancellation.
const GLANCE: Duration = Duration::from_millis(20);

/// How long a cancelled job may take to stop by itself. One inside a factorization cannot, so it is
/// left behind: its thread ends when the factorization does, and its result is dropped.
const PATIENCE: Duration = Duration::from_millis(100);

/// Turns a result into a Python object, once the interpreter is held again.
type Convert = Box<dyn FnOnce(Python<'_>) -> PyResult<Py<PyAny>> + Send>;

/// What a process is told of work that its parent had under way when it forked.
pub const ELSEWHERE: &str =
    "under way in the process that this one was forked from, where it stays: begin anew here";

enum Outcome {
    Done(Convert),
    Failed(Error),
    Panicked(Box<dyn std::any::Any + Send>),
}

enum State {
    Running(Receiver<Outcome>),
    Finished(PyResult<Py<PyAny>>),
}

/// Work that goes on in the background.
///
/// `progress` is (fraction in 0-1, name of the stage); `result()` waits and returns what the blocking
/// call would, or raises what it would; `cancel()` makes it raise `lissom.Cancelled`, and so does dropping
/// the job.
#[pyclass(name = "Job", module = "lissom", frozen)]
pub struct PyJob {
    job: Job,
    state: Mutex<State>,
    /// Where its thread is.
    process: u32,
    /// What the caller makes of the result.
    then: OnceLock<Py<PyAny>>,
}

impl Drop for PyJob {
    /// Nobody can ask for the result any more.
    fn drop(&mut self) {
        self.job.cancel();
    }
}

/// The process that imported the module.
pub static HOME: OnceLock<u32> = OnceLock::new();

/// The pool of a forked process, and which.
static FORKED: Mutex<Option<(u32, Arc<rayon::ThreadPool>)>> = Mutex::new(None);

/// Runs `work` with threads that exist: those of rayon's own pool do not survive a fork (as by Python's
/// multiprocessing), and waiting for them would be forever.
fn in_own_pool<T: Send>(work: impl FnOnce() -> lissom::Result<T> + Send) -> lissom::Result<T> {
    let process = std::process::id();
    if *HOME.get_or_init(|| process) == process {
        return work();
    }
    let pool = {
        let mut forked = FORKED.lock().unwrap_or_else(PoisonError::into_inner);
        match &*forked {
            Some((owner, pool)) if *owner == process => pool.clone(),
            _ => {
                let made = rayon::ThreadPoolBuilder::new().build();
                let made = Arc::new(made.map_err(|error| Error::SolveFailed(error.to_string()))?);
                // A pool of the parent is left alone: to drop it would wait for its threads.
                std::mem::forget(forked.replace((process, made.clone())));
                made
            }
        }
    };
    pool.install(work)
}

impl PyJob {
    /// Starts `work` on a thread of its own; `convert` makes a Python object of what it returns.
    pub fn start<T: Send + 'static>(
        work: impl FnOnce(&Job) -> lissom::Result<T> + Send + 'static,
        convert: impl FnOnce(Python<'_>, T) -> PyResult<Py<PyAny>> + Send + 'static,
    ) -> PyResult<Self> {
        let job = Job::default();
        let (sender, receiver) = channel();
        let shared = job.clone();
        let run = move || {
            let outcome = match catch_unwind(AssertUnwindSafe(|| in_own_pool(|| work(&shared)))) {
                Ok(Ok(value)) => Outcome::Done(Box::new(move |py: Python<'_>| convert(py, value))),
                Ok(Err(error)) => Outcome::Failed(error),
                Err(payload) => Outcome::Panicked(payload),
            };
            // Nobody listens any more where the job was cancelled and left behind.
            let _ = sender.send(outcome);
        };
        std::thread::Builder::new().name("lissom".into()).spawn(run)?;
        let (state, process) = (Mutex::new(State::Running(receiver)), std::process::id());
        Ok(Self { job, state, process, then: OnceLock::new() })
    }

    /// Waits up to `time` with the interpreter released; whether the job has finished.
    fn wait(&self, py: Python<'_>, time: Duration) -> PyResult<bool> {
        if self.process != std::process::id() {
            // The thread that works or waits, maybe with the lock, does not survive a fork.
            return match self.state.try_lock().as_deref() {
                Ok(State::Finished(_)) => Ok(true),
                _ => Err(errors::to_python(Error::SolveFailed(format!("the job is {ELSEWHERE}")))),
            };
        }
        // The lock is only ever taken without the interpreter, or two waiting threads would hold one
        // each and wait for the other.
        let outcome = py.detach(|| {
            let state = self.state.lock().unwrap_or_else(PoisonError::into_inner);
            match &*state {
                State::Finished(_) => None,
                State::Running(receiver) => Some(receiver.recv_timeout(time)),
            }
        });
        let result = match outcome {
            None => return Ok(true),
            Some(Err(RecvTimeoutError::Timeout)) => return Ok(false),
            // Another thread that waits has taken the outcome and is about to store it.
            Some(Err(RecvTimeoutError::Disconnected)) => {
                py.detach(|| std::thread::sleep(Duration::from_millis(1)));
                return Ok(false);
            }
            Some(Ok(_)) if self.job.is_cancelled() => Err(errors::to_python(Error::Cancelled)),
            Some(Ok(Outcome::Done(convert))) => convert(py).and_then(|made| match self.then.get() {
                Some(then) => then.call1(py, (made,)),
                None => Ok(made),
            }),
            Some(Ok(Outcome::Failed(error))) => Err(errors::to_python(error)),
            Some(Ok(Outcome::Panicked(payload))) => Err(errors::from_panic(&*payload)),
        };
        self.finish(py, result);
        Ok(true)
    }

    fn finish(&self, py: Python<'_>, result: PyResult<Py<PyAny>>) {
        py.detach(|| {
            *self.state.lock().unwrap_or_else(PoisonError::into_inner) = State::Finished(result);
        });
    }
}

#[pymethods]
impl PyJob {
    /// (fraction in 0-1, name of the stage).
    #[getter]
    fn progress(&self) -> (f64, &'static str) {
        self.job.progress()
    }

    /// Whether `result()` returns at once.
    #[getter]
    fn done(&self, py: Python<'_>) -> PyResult<bool> {
        self.wait(py, Duration::ZERO)
    }

    /// Lets `then` make the result of what the job returns; the job itself.
    fn _then(this: Py<Self>, then: Py<PyAny>) -> Py<Self> {
        // Only whoever starts a job calls this, once.
        let _ = this.get().then.set(then);
        this
    }

    /// `Job[Posed]`, for annotations.
    #[classmethod]
    fn __class_getitem__(class: Py<PyType>, _item: &Bound<'_, PyAny>) -> Py<PyType> {
        class
    }

    /// Asks the job to stop; `result()` then raises `lissom.Cancelled` within 0.2 s.
    fn cancel(&self) {
        self.job.cancel();
    }

    /// Waits for the job and returns its result, or raises its error. Ctrl-C cancels it.
    pub fn result(&self, py: Python<'_>) -> PyResult<Py<PyAny>> {
        let mut cancelled: Option<Instant> = None;
        while !self.wait(py, GLANCE)? {
            if let Err(interrupt) = py.check_signals() {
                self.job.cancel();
                return Err(interrupt);
            }
            if self.job.is_cancelled() && cancelled.get_or_insert_with(Instant::now).elapsed() > PATIENCE {
                self.finish(py, Err(errors::to_python(Error::Cancelled)));
            }
        }
        let copy = |result: &PyResult<Py<PyAny>>| match result {
            Ok(value) => Ok(value.clone_ref(py)),
            Err(error) => Err(error.clone_ref(py)),
        };
        match &*self.state.lock().unwrap_or_else(PoisonError::into_inner) {
            State::Finished(result) => copy(result),
            State::Running(_) => Err(errors::InternalError::new_err("a finished job went on")),
        }
    }
}

/// Panics inside the core, to show that the caller survives it.
#[pyfunction]
pub fn _panic(py: Python<'_>) -> PyResult<Py<PyAny>> {
    PyJob::start(|_| -> lissom::Result<()> { panic!("asked to") }, |py, ()| Ok(py.None()))?.result(py)
}
