//! The floating-point environment that all arithmetic of the library needs: round to nearest, denormals kept, exceptions masked.
//!
//! Threads of our own are started with it. On a thread of the application its register is not ours to change, so what computes there and must give the same
//! bits as everywhere runs inside [`with_default_floats`]: nearly always a look at the register, else a call from assembly that loads the default before
//! and the application's value after.

#[cfg(target_arch = "x86_64")]
static DEFAULT: u32 = 0x1f80;
/// The bits of MXCSR that change results or raise signals; the others say what has happened.
#[cfg(target_arch = "x86_64")]
const CONTROL: u32 = 0xffc0;

/// Sets the default. Only for threads that are ours.
pub(super) fn set_default() {
    #[cfg(target_arch = "x86_64")]
    {
        // SAFETY: loads MXCSR from a valid u32 with the value every thread of a Rust program starts with.
        unsafe { std::arch::asm!("ldmxcsr [{0}]", in(reg) &raw const DEFAULT, options(nostack, readonly)) };
    }
    #[cfg(target_arch = "aarch64")]
    {
        // SAFETY: FPCR 0 is the architectural default: round to nearest, no flushing, no traps.
        unsafe { std::arch::asm!("msr fpcr, xzr", options(nomem, nostack)) };
    }
}

/// Runs `f` in the default environment and leaves the thread's own as it was, also when `f` panics. Costs nothing worth telling where the default is set
/// already. (On processors other than x86-64 `f` runs in the environment that is there.)
#[inline(always)]
pub fn with_default_floats<R>(f: impl FnOnce() -> R) -> R {
    #[cfg(target_arch = "x86_64")]
    {
        let found = control();
        if found & CONTROL != DEFAULT & CONTROL {
            return elsewhere(found, f);
        }
    }
    f()
}

#[cfg(target_arch = "x86_64")]
#[inline(always)]
fn control() -> u32 {
    let mut value = 0u32;
    // SAFETY: stores MXCSR to a valid u32.
    unsafe { std::arch::asm!("stmxcsr [{0}]", in(reg) &raw mut value, options(nostack)) };
    value
}

#[cfg(target_arch = "x86_64")]
#[cold]
#[inline(never)]
fn elsewhere<R, F: FnOnce() -> R>(found: u32, f: F) -> R {
    use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};

    struct Job<F, R> {
        f: Option<F>,
        result: Option<std::thread::Result<R>>,
    }

    unsafe extern "sysv64" fn run<R, F: FnOnce() -> R>(job: *mut Job<F, R>) {
        // SAFETY: `elsewhere` passes its own job, which nobody else has.
        let job = unsafe { &mut *job };
        // A panic must not pass through the assembly below. What it leaves behind is the caller's matter: it goes on from there.
        job.result = job.f.take().map(|f| catch_unwind(AssertUnwindSafe(f)));
    }

    let mut job = Job { f: Some(f), result: None };
    let run: unsafe extern "sysv64" fn(*mut Job<F, R>) = run::<R, F>;
    // SAFETY: loads MXCSR from two valid u32, the second of which puts back what was there, as leaving an assembly block demands. The call obeys
    // the convention named, and the registers that hold what is needed after it are preserved by it. It does not unwind.
    unsafe {
        std::arch::asm!(
            "ldmxcsr [r12]",
            "call {run}",
            "ldmxcsr [r13]",
            run = in(reg) run,
            in("r12") &raw const DEFAULT,
            in("r13") &raw const found,
            in("rdi") &raw mut job,
            clobber_abi("sysv64"),
        );
    }
    match job.result.expect("the job has run") {
        Ok(value) => value,
        Err(panic) => resume_unwind(panic),
    }
}

#[cfg(all(test, target_arch = "x86_64"))]
mod tests {
    use super::*;

    fn set(value: u32) {
        // SAFETY: a valid control word; no float is computed before it is restored.
        unsafe { std::arch::asm!("ldmxcsr [{0}]", in(reg) &raw const value, options(nostack, readonly)) };
    }

    #[test]
    fn the_default_is_there_within_and_the_callers_own_after() {
        // A thread of its own: the test harness must keep its register.
        let seen = std::thread::spawn(|| {
            // Rounds up and flushes to zero; then all exceptions are unmasked.
            [0xdfc0, 0x0000, 0x1f80].map(|own| {
                set(own);
                let within = with_default_floats(control);
                let panicked = std::panic::catch_unwind(|| with_default_floats(|| panic!("on purpose"))).is_err();
                let after = control();
                set(DEFAULT);
                (own, within & CONTROL, after & CONTROL, panicked)
            })
        })
        .join()
        .expect("no panic");
        for (own, within, after, panicked) in seen {
            assert_eq!((within, after, panicked), (DEFAULT & CONTROL, own & CONTROL, true), "{own:x}");
        }
    }
}
