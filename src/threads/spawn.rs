//! Threads of the system's own making.
//!
//! Those of the standard library take memory without asking when they start: where there is none, that is the end of the process. Here it is an
//! error, as any other refusal. What such a thread lacks is a name that Rust knows; the system knows it.

use crate::memory;
use std::io;

/// Not much of a name is kept.
const NAME_BYTES: usize = 16;

/// A thread, which goes on by itself if nobody waits for it.
pub(super) struct Thread(system::Thread);

impl Thread {
    /// Waits for its end.
    pub fn join(self) {
        self.0.join();
    }
}

/// Runs `body` on a thread. A panic of `body` ends there.
///
/// # Errors
/// The system refuses the thread, or has no memory for it, which is [`io::ErrorKind::OutOfMemory`].
pub(super) fn spawn(name: &str, stack: usize, body: impl FnOnce() + Send + 'static) -> io::Result<Thread> {
    // SAFETY: the body may live as long as it likes.
    unsafe { spawn_unbounded(name, stack, body) }
}

/// # Safety
/// - What `body` borrows lives until the thread has been waited for.
pub(super) unsafe fn spawn_unbounded(name: &str, stack: usize, body: impl FnOnce() + Send) -> io::Result<Thread> {
    let mut kept = [0; NAME_BYTES];
    for (to, byte) in kept[..NAME_BYTES - 1].iter_mut().zip(name.bytes()) {
        *to = byte;
    }
    let body = memory::boxed(Body { name: kept, run: body }).map_err(|_| io::ErrorKind::OutOfMemory)?;
    // SAFETY: the caller's promise.
    let started = unsafe { system::start(stack, body) };
    match started {
        Ok(thread) => Ok(Thread(thread)),
        // For a thread too many and for one without memory the system has the same word.
        Err((error, _)) if error.kind() != io::ErrorKind::WouldBlock => Err(error),
        Err((_, body)) if memory::is_there(size_of_val(&*body)) && memory::is_there(stack) => {
            // SAFETY: the caller's promise.
            unsafe { system::start(stack, body) }.map(Thread).map_err(|(error, _)| error)
        }
        Err(_) => Err(io::ErrorKind::OutOfMemory.into()),
    }
}

struct Body<F> {
    name: [u8; NAME_BYTES],
    run: F,
}

#[cfg(unix)]
mod system {
    use super::Body;
    use std::ffi::c_void;
    use std::io;
    use std::mem::{ManuallyDrop, MaybeUninit};
    use std::panic::{AssertUnwindSafe, catch_unwind};
    use std::ptr::null_mut;

    pub struct Thread(libc::pthread_t);

    // SAFETY: the system lets any thread wait for another.
    unsafe impl Send for Thread {}

    impl Thread {
        pub fn join(self) {
            // SAFETY: it is waited for once, as it is consumed, and not let go.
            unsafe { libc::pthread_join(ManuallyDrop::new(self).0, null_mut()) };
        }
    }

    impl Drop for Thread {
        /// Nobody waits for it: the system cleans up after it.
        fn drop(&mut self) {
            // SAFETY: it was not waited for.
            unsafe { libc::pthread_detach(self.0) };
        }
    }

    /// # Safety
    /// - What the body borrows lives until the thread has been waited for.
    pub unsafe fn start<F: FnOnce() + Send>(
        stack: usize,
        body: Box<Body<F>>,
    ) -> Result<Thread, (io::Error, Box<Body<F>>)> {
        let body = Box::into_raw(body);
        let mut thread = MaybeUninit::uninit();
        let mut attributes = MaybeUninit::uninit();
        // SAFETY: attributes are used between their beginning and their end; `run` gets what it expects, and nobody else touches it.
        let error = unsafe {
            libc::pthread_attr_init(attributes.as_mut_ptr());
            libc::pthread_attr_setstacksize(attributes.as_mut_ptr(), stack);
            let error = libc::pthread_create(thread.as_mut_ptr(), attributes.as_ptr(), run::<F>, body.cast());
            libc::pthread_attr_destroy(attributes.as_mut_ptr());
            error
        };
        if error == 0 {
            // SAFETY: the system has written it.
            return Ok(Thread(unsafe { thread.assume_init() }));
        }
        // SAFETY: no thread has begun, so it is still ours.
        Err((io::Error::from_raw_os_error(error), unsafe { Box::from_raw(body) }))
    }

    extern "C" fn run<F: FnOnce() + Send>(body: *mut c_void) -> *mut c_void {
        // SAFETY: `start` gave it to this thread alone.
        let Body { name, run } = *unsafe { Box::from_raw(body.cast::<Body<F>>()) };
        set_name(&name);
        // The panic hook has reported it; the payload's own destructor may panic.
        if let Err(payload) = catch_unwind(AssertUnwindSafe(run)) {
            let _ = catch_unwind(AssertUnwindSafe(|| drop(payload)));
        }
        null_mut()
    }

    #[cfg(target_os = "linux")]
    fn set_name(name: &[u8; super::NAME_BYTES]) {
        // SAFETY: the name ends with a zero byte.
        unsafe { libc::pthread_setname_np(libc::pthread_self(), name.as_ptr().cast()) };
    }

    #[cfg(not(target_os = "linux"))]
    fn set_name(_: &[u8; super::NAME_BYTES]) {}
}

#[cfg(not(unix))]
mod system {
    use super::Body;
    use std::io;

    pub struct Thread(std::thread::JoinHandle<()>);

    impl Thread {
        pub fn join(self) {
            let _ = self.0.join();
        }
    }

    /// # Safety
    /// - What the body borrows lives until the thread has been waited for.
    pub unsafe fn start<F: FnOnce() + Send>(
        stack: usize,
        body: Box<Body<F>>,
    ) -> Result<Thread, (io::Error, Box<Body<F>>)> {
        let length = body.name.iter().position(|&byte| byte == 0).unwrap_or(0);
        let name = String::from_utf8_lossy(&body.name[..length]).into_owned();
        let body = std::sync::Arc::new(std::sync::Mutex::new(Some(body)));
        let of_thread = body.clone();
        let run = move || {
            let taken = of_thread.lock().ok().and_then(|mut body| body.take());
            if let Some(body) = taken {
                (body.run)();
            }
        };
        // SAFETY: the caller's promise.
        let started = unsafe { std::thread::Builder::new().name(name).stack_size(stack).spawn_unchecked(run) };
        started.map(Thread).map_err(|error| {
            let body = body.lock().ok().and_then(|mut body| body.take());
            (error, body.expect("no thread has begun"))
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::mpsc;

    #[test]
    fn a_thread_runs_its_body_with_its_stack_and_panics_end_in_it() {
        let (send, receive) = mpsc::channel();
        let deep = move || {
            let large = std::hint::black_box([1u8; 3 << 20]);
            send.send(large.iter().map(|&byte| u64::from(byte)).sum::<u64>()).expect("receiver waits");
        };
        spawn("a name longer than fits", 4 << 20, deep).expect("a thread").join();
        assert_eq!(receive.recv(), Ok(3 << 20));
        spawn("panics", 1 << 20, || panic!("on purpose")).expect("a thread").join();
    }

    #[test]
    fn what_cannot_be_had_is_an_error() {
        let error = spawn("too large", 1 << 60, || unreachable!("there is no such stack")).err();
        assert_eq!(error.map(|error| error.kind()), Some(io::ErrorKind::OutOfMemory));
    }
}
