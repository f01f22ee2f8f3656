//! Harmonic fields: values given at handles, spread as smoothly as a membrane over the rest.

use crate::Vec3;
use crate::linear::{Columns, ConstrainedSystem};

/// `L r = 0` at free vertices, `r` as given elsewhere (Zayer, Rössl, Karni & Seidel 2005).
pub(super) fn harmonic(system: &ConstrainedSystem, given: &[Vec3]) -> Vec<Vec3> {
    let mut field = Columns::from_vectors(given);
    system.solve(&Columns::zeros(given.len(), 3), &mut field);
    field.vectors(0)
}
