//! Typed errors that carry the argument, the first offending indices and their number.

use std::borrow::Cow;
use std::fmt;

/// How many offending indices a message shows.
const SHOWN: usize = 5;

/// What is wrong with an argument.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Fault {
    /// Name of the argument, as the caller knows it.
    pub argument: String,
    /// What is wrong, and what to do about it.
    pub problem: String,
    /// The first offending indices; empty where the fault is of the whole.
    pub indices: Vec<usize>,
    /// How many offenders there are in all.
    pub count: usize,
}

impl Fault {
    /// A fault of the whole argument.
    pub fn new(argument: impl Into<String>, problem: impl Into<String>) -> Self {
        Self { argument: argument.into(), problem: problem.into(), indices: Vec::new(), count: 0 }
    }

    /// A fault of single elements; `None` where there are no offenders.
    pub fn at(
        argument: impl Into<String>,
        problem: impl Into<String>,
        offenders: impl IntoIterator<Item = usize>,
    ) -> Option<Self> {
        let mut fault = Self::new(argument, problem);
        for index in offenders {
            if fault.count < SHOWN {
                fault.indices.push(index);
            }
            fault.count += 1;
        }
        (fault.count > 0).then_some(fault)
    }

    /// Of vertices that a mesh of `n` does not have.
    pub fn out_of_range<'a>(
        argument: &str,
        vertices: impl IntoIterator<Item = &'a u32>,
        n: usize,
    ) -> Option<Self> {
        let outside = vertices.into_iter().map(|&v| v as usize).filter(|&v| v >= n);
        Self::at(argument, format!("vertex index out of range, the mesh has {n} vertices"), outside)
    }
}

impl fmt::Display for Fault {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(out, "{}: {}", self.argument, self.problem)?;
        if self.count > 0 {
            let shown: Vec<String> = self.indices.iter().map(usize::to_string).collect();
            let more = if self.count > self.indices.len() { ", ..." } else { "" };
            write!(out, " (at {}{more}; {} in all)", shown.join(", "), self.count)?;
        }
        Ok(())
    }
}

/// Everything that can go wrong.
#[derive(Debug, Clone, thiserror::Error)]
pub enum Error {
    /// The mesh itself cannot be worked with.
    #[error("{0}")]
    InvalidMesh(Fault),
    /// Handles, markers, targets or a region contradict the mesh or each other.
    #[error("{0}")]
    InvalidConstraint(Fault),
    /// An option or a number is out of its range.
    #[error("{0}")]
    InvalidValue(Fault),
    /// The linear algebra gave up, or the result overflowed.
    #[error("{0}")]
    SolveFailed(String),
    /// It would take more memory than there is; nothing has been allocated.
    #[error("{what} would take {}, there are {} left", amount(*needed), amount(*available))]
    OutOfMemory {
        /// What was to be allocated.
        what: Cow<'static, str>,
        /// Bytes that it takes.
        needed: u64,
        /// Bytes that there are.
        available: u64,
    },
    /// The caller cancelled the job.
    #[error("cancelled")]
    Cancelled,
}

impl Error {
    /// The same fault by the name that the caller knows the argument by.
    pub(crate) fn renamed(self, argument: impl Into<String>) -> Self {
        let renamed = |fault: Fault| Fault { argument: argument.into(), ..fault };
        match self {
            Self::InvalidMesh(fault) | Self::InvalidValue(fault) => Self::InvalidValue(renamed(fault)),
            other => other,
        }
    }
}

/// Bytes, in a unit that suits them.
fn amount(bytes: u64) -> String {
    let bytes = bytes as f64;
    match bytes {
        1e9.. => format!("{:.1} GB", bytes / 1e9),
        1e6.. => format!("{:.1} MB", bytes / 1e6),
        _ => format!("{bytes} bytes"),
    }
}

/// Result of everything that can fail.
pub type Result<T> = std::result::Result<T, Error>;
