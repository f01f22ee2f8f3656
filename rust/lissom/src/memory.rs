//! What does not fit in memory is refused before it is allocated.
//!
//! An allocation that is too large does not fail on most systems: the process is ended when it writes there,
//! and the unsaved work of the application around it is lost.

use std::borrow::Cow;

use sysinfo::{MemoryRefreshKind, System};

use crate::{Error, Fault, Result};

/// Environment variable that says how many bytes one allocation may take, in place of what the machine has
/// left.
pub const LIMIT: &str = "LISSOM_MEMORY_LIMIT";

/// Below, in bytes, a look at the machine costs more than it is worth.
const SMALL: u64 = 16 << 20;

/// Refuses to allocate `bytes` for `what` where there is no room for them.
///
/// # Errors
///
/// [`Error::OutOfMemory`]; [`Error::InvalidValue`] where [`LIMIT`] is set to anything but a number.
pub fn check(what: impl Into<Cow<'static, str>>, bytes: u128) -> Result<()> {
    let needed = u64::try_from(bytes).unwrap_or(u64::MAX);
    let available = match std::env::var(LIMIT) {
        Ok(limit) => parse(&limit)?,
        Err(_) if needed < SMALL => return Ok(()),
        Err(_) => available(),
    };
    if needed > available { Err(Error::OutOfMemory { what: what.into(), needed, available }) } else { Ok(()) }
}

fn parse(limit: &str) -> Result<u64> {
    match limit.trim().parse::<f64>() {
        Ok(bytes) if bytes >= 0.0 => Ok(bytes as u64),
        _ => Err(Error::InvalidValue(Fault::new(LIMIT, format!("'{limit}' is not a number of bytes")))),
    }
}

/// What this process can still get. A container's files in cache are not counted against it: they give way.
fn available() -> u64 {
    let mut system = System::new();
    system.refresh_memory_specifics(MemoryRefreshKind::everything());
    let left = system.available_memory();
    let left = match system.cgroup_limits() {
        Some(group) => left.min(group.total_memory.saturating_sub(group.rss)),
        None => left,
    };
    // Where the system does not tell, nothing is refused.
    if left == 0 { u64::MAX } else { left.saturating_add(system.free_swap()) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn row_39_more_than_any_machine_has_is_refused_with_the_numbers() {
        let error = check("the test", u128::MAX).unwrap_err();
        let Error::OutOfMemory { what, needed, available } = &error else { panic!("{error}") };
        assert_eq!((&**what, *needed), ("the test", u64::MAX));
        assert!((SMALL..u64::MAX).contains(available), "this machine has {available}");
        assert!(error.to_string().starts_with("the test would take 18446744073.7 GB, there are "));
        assert!(check("little", 1 << 20).is_ok());
    }

    #[test]
    fn row_39_limits() {
        assert_eq!(parse(" 2e9 ").unwrap(), 2_000_000_000);
        for wrong in ["", "much", "-1", "nan"] {
            assert!(parse(wrong).unwrap_err().to_string().contains("not a number of bytes"));
        }
    }
}
