//! Crates that read and write files have panics of their own. Here they are errors, and silent.

#![forbid(unsafe_code)]

use std::cell::Cell;
use std::fmt;
use std::panic::{AssertUnwindSafe, PanicHookInfo, catch_unwind, set_hook, take_hook};
use std::sync::Once;

thread_local! {
    /// A panic on this thread is caught and told as an error.
    static QUIET: Cell<bool> = const { Cell::new(false) };
}

static HOOK: Once = Once::new();

type Hook = Box<dyn Fn(&PanicHookInfo<'_>) + Sync + Send>;

/// Tells `before` of the panics that are not caught here.
fn hook_over(before: Hook) -> Hook {
    Box::new(move |panic| {
        if !QUIET.try_with(Cell::get).unwrap_or(false) {
            before(panic);
        }
    })
}

/// First line of the text of a panic that was caught.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct GaveUp(String);

impl fmt::Display for GaveUp {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "gave up on it ({})", self.0)
    }
}

/// Runs `reader`; a panic inside it is an error with its text. Nothing is printed, and panics elsewhere are told by the hook
/// that was set before, as ever.
pub fn caught<T>(reader: impl FnOnce() -> T) -> Result<T, GaveUp> {
    HOOK.call_once(|| set_hook(hook_over(take_hook())));
    let outer = QUIET.replace(true);
    // What a reader leaves half done is dropped with its result.
    let result = catch_unwind(AssertUnwindSafe(reader));
    QUIET.set(outer);
    result.map_err(|payload| {
        let text = payload.downcast_ref::<&str>().map(|s| (*s).to_owned());
        let text = text.or_else(|| payload.downcast_ref::<String>().cloned()).unwrap_or_default();
        GaveUp(text.lines().next().unwrap_or_default().to_owned())
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::atomic::{AtomicU32, Ordering};

    #[test]
    fn panics_are_errors_and_silent() {
        static TOLD: AtomicU32 = AtomicU32::new(0);
        let before = take_hook();
        set_hook(hook_over(Box::new(move |panic| {
            if panic.payload().downcast_ref::<&str>().is_some_and(|text| text.starts_with("on purpose")) {
                TOLD.fetch_add(1, Ordering::Relaxed);
            } else {
                before(panic);
            }
        })));
        let result: Result<(), GaveUp> = caught(|| panic!("on purpose\nwith a second line"));
        assert_eq!(result.unwrap_err().to_string(), "gave up on it (on purpose)");
        assert_eq!(caught(|| caught(|| 5)), Ok(Ok(5)));
        assert_eq!(TOLD.load(Ordering::Relaxed), 0, "silent");
        assert!(catch_unwind(|| panic!("on purpose, elsewhere")).is_err());
        assert_eq!(TOLD.load(Ordering::Relaxed), 1, "other panics are told");
    }
}
