//! The handles, as callers give them, and what is checked of them.

use crate::{Error, Fault, Result};

/// Vertices that move together.
#[derive(Debug, Clone)]
pub struct Handle {
    /// The vertices.
    pub vertices: Vec<u32>,
    /// How much each belongs to the handle, above 0 and at most 1; `None` where all do wholly. A vertex
    /// of membership `m < 1` stays free, and is pulled with the weight `m / (1 - m)`.
    pub membership: Option<Vec<f64>>,
}

impl From<Vec<u32>> for Handle {
    fn from(vertices: Vec<u32>) -> Self {
        Self { vertices, membership: None }
    }
}

/// How the handles hold their vertices.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum Hold {
    /// Exactly: they are eliminated.
    #[default]
    Hard,
    /// With this weight, squared in the energy (thesis 2.2, equation 2-4).
    Soft(f64),
}

/// Refuses handles that are not right for a mesh of `n` vertices.
pub(super) fn check(n: usize, handles: &[Handle], hold: Hold) -> Result<()> {
    owners(n, handles)?;
    pulls(n, handles, hold)?;
    Ok(())
}

/// The handle that each vertex is in.
pub(super) fn owners(n: usize, handles: &[Handle]) -> Result<Vec<Option<u32>>> {
    let invalid = |fault: Fault| Err(Error::InvalidConstraint(fault));
    if handles.is_empty() {
        return invalid(Fault::new("handles", "there is no handle"));
    }
    let empty = handles.iter().enumerate().filter(|(_, h)| h.vertices.is_empty()).map(|(h, _)| h);
    if let Some(fault) = Fault::at("handles", "empty handle", empty) {
        return invalid(fault);
    }
    if let Some(fault) = Fault::out_of_range("handles", handles.iter().flat_map(|h| &h.vertices), n) {
        return invalid(fault);
    }
    let mut owner = vec![None; n];
    let mut twice = Vec::new();
    let mut rivals = None;
    for (h, handle) in (0u32..).zip(handles) {
        for &v in &handle.vertices {
            if let Some(other) = owner[v as usize].replace(h) {
                twice.push(v as usize);
                rivals.get_or_insert((other, h));
            }
        }
    }
    if let Some((a, b)) = rivals {
        let problem = if a == b {
            format!("vertex twice in handle {a}")
        } else {
            format!("vertex in two handles, first in {a} and {b}")
        };
        if let Some(fault) = Fault::at("handles", problem, twice) {
            return invalid(fault);
        }
    }
    Ok(owner)
}

/// Whether each vertex is in the region.
pub(super) fn membership(n: usize, roi: &[u32]) -> Result<Vec<bool>> {
    if roi.is_empty() {
        return Err(Error::InvalidConstraint(Fault::new("roi", "the region of interest is empty")));
    }
    if let Some(fault) = Fault::out_of_range("roi", roi, n) {
        return Err(Error::InvalidConstraint(fault));
    }
    let mut inside = vec![false; n];
    for &v in roi {
        inside[v as usize] = true;
    }
    Ok(inside)
}

/// The weight that pulls each handle vertex; `None` where it is held exactly or in no handle.
pub(super) fn pulls(n: usize, handles: &[Handle], hold: Hold) -> Result<Vec<Option<f64>>> {
    if let Hold::Soft(weight) = hold
        && !(weight > 0.0 && weight.is_finite())
    {
        return Err(Error::InvalidValue(Fault::new("weight", "must be a positive number")));
    }
    let mut pull = vec![None; n];
    for (h, handle) in handles.iter().enumerate() {
        let ones = vec![1.0; handle.vertices.len()];
        let membership = handle.membership.as_ref().unwrap_or(&ones);
        if membership.len() != handle.vertices.len() {
            let (given, wanted) = (membership.len(), handle.vertices.len());
            let problem = format!("{given} weights for {wanted} vertices of handle {h}");
            return Err(Error::InvalidConstraint(Fault::new("handle_weights", problem)));
        }
        let bad = membership.iter().enumerate().filter(|(_, m)| !(**m > 0.0 && **m <= 1.0));
        let problem = format!("weights of handle {h} must be above 0 and at most 1");
        if let Some(fault) = Fault::at("handle_weights", problem, bad.map(|(i, _)| i)) {
            return Err(Error::InvalidConstraint(fault));
        }
        for (&v, &m) in handle.vertices.iter().zip(membership) {
            let full = match hold {
                Hold::Hard => 1.0,
                Hold::Soft(weight) => weight * weight,
            };
            pull[v as usize] = match hold {
                _ if m < 1.0 => Some(full * m / (1.0 - m)),
                Hold::Soft(_) => Some(full),
                Hold::Hard => None,
            };
        }
    }
    Ok(pull)
}
