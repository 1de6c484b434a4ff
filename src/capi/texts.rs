//! Texts that are handed to C programs for ever: each is kept once, and never given back.
//!
//! Names of shader classes and of their parameters are few. Texts of errors hold values, so there could be any number; of them a megabyte is kept.

use std::collections::HashSet;
use std::ffi::CStr;
use std::sync::{Mutex, PoisonError};

/// Bytes of texts that [`bounded`] has kept, and all that are kept.
struct Texts {
    kept: Option<HashSet<&'static [u8]>>,
    bounded: usize,
}

static TEXTS: Mutex<Texts> = Mutex::new(Texts { kept: None, bounded: 0 });

const MOST_BOUNDED: usize = 1 << 20;

/// `text` for ever; without its zero bytes, which C could not show. None without memory for it.
pub(super) fn forever(text: &str) -> Option<&'static CStr> {
    keep(text, false)
}

/// As [`forever`], but None also if much has been kept in this way.
pub(super) fn bounded(text: &str) -> Option<&'static CStr> {
    keep(text, true)
}

fn keep(text: &str, bounded: bool) -> Option<&'static CStr> {
    let mut bytes = Vec::new();
    bytes.try_reserve_exact(text.len() + 1).ok()?;
    bytes.extend(text.bytes().filter(|&byte| byte != 0));
    bytes.push(0);
    // A panic cannot pass between the changes.
    let mut texts = TEXTS.lock().unwrap_or_else(PoisonError::into_inner);
    let Texts { kept, bounded: sum } = &mut *texts;
    let kept = kept.get_or_insert_default();
    let bytes = match kept.get(&bytes[..]) {
        Some(&bytes) => bytes,
        None => {
            if bounded && *sum + bytes.len() > MOST_BOUNDED {
                return None;
            }
            kept.try_reserve(1).ok()?;
            *sum += if bounded { bytes.len() } else { 0 };
            let bytes: &'static [u8] = bytes.leak();
            kept.insert(bytes);
            bytes
        }
    };
    CStr::from_bytes_with_nul(bytes).ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn equal_texts_are_one_and_errors_end_at_a_megabyte() {
        let a = forever("a text").expect("there is memory");
        assert_eq!(a, c"a text");
        assert_eq!(forever("a\0 text").map(CStr::as_ptr), Some(a.as_ptr()));
        assert_eq!(bounded("a text").map(CStr::as_ptr), Some(a.as_ptr()));
        let long = "x".repeat(MOST_BOUNDED / 8);
        let kept = (0..9).filter(|i| bounded(&format!("{i}{long}")).is_some()).count();
        assert!(kept < 8, "{kept} of nine eighths of a megabyte");
        assert!(bounded("a text").is_some() && forever("another").is_some());
    }
}
