//! The opacity of a picture's pixels.

use crate::{Error, Fault, Result};

/// Alpha of a picture, row by row from the top.
#[derive(Debug, Clone, Copy)]
pub struct Alpha<'a> {
    /// In 0-1, `width` times as many as there are rows.
    pub values: &'a [f64],
    /// Pixels in a row.
    pub width: usize,
}

impl Alpha<'_> {
    /// Number of rows.
    pub fn height(&self) -> usize {
        self.values.len().checked_div(self.width).unwrap_or(0)
    }

    /// Refuses what is no opacity.
    pub(super) fn check(&self) -> Result<()> {
        let invalid = |fault| Err(Error::InvalidValue(fault));
        if self.values.is_empty() {
            return invalid(Fault::new("alpha", "the image has no pixels"));
        }
        let bad = |of: fn(f64) -> bool| (0..self.values.len()).filter(move |&i| of(self.values[i]));
        if let Some(fault) = Fault::at("alpha", "not a finite number", bad(|a| !a.is_finite())) {
            return invalid(fault);
        }
        let range = "must be from 0 to 1; divide bytes by 255";
        match Fault::at("alpha", range, bad(|a| !(0.0..=1.0).contains(&a))) {
            Some(fault) => invalid(fault),
            None => Ok(()),
        }
    }
}
