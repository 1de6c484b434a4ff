//! Contexts and errors.

use super::constants::RT_NO_ERROR;
use super::contexts;
use super::current::{UserData, current_name};
use super::guard::{self, guard_session, guard_thread};
use super::types::*;
use crate::api::{Error, MAX_THREADS, Result};
use std::ffi::{c_char, c_int, c_void};

/// Starts the library: makes the initial context and makes it current on the calling thread. argc and argv are
/// those of main(), or NULL. They are there for back-ends that take options from the command line, which then
/// are removed from it; rendering in this process takes none.
///
/// Variables of the environment: OPENRT_NUM_THREADS (number of worker threads, unless rtThreads() was called;
/// otherwise as many as the process may use), OPENRT_SIMD (scalar, sse, avx2 or avx512: lowers the instruction set that is used), OPENRT_ACCEL
/// (bsp, sah, fast_build, refit, rotate, grid, lazy or visibility_field: an update strategy for all objects), OPENRT_TOPLEVEL (bsp or bvh: the
/// structure over the instances), OPENRT_MERGE (now or never: when RT_STATIC instances are merged; otherwise while
/// frames are rendered). Other values are ignored.
///
/// Errors: RT_INVALID_OPERATION when it was called before without rtExit(), or a context is current on this
/// thread; RT_IO_ERROR when the system refuses threads; RT_OUT_OF_MEMORY.
///
/// Threads: a context belongs to the thread on which it is current. All other functions work on the context
/// that is current on the calling thread, and report RT_INVALID_OPERATION when there is none.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rtInit(argc: *mut c_int, argv: *mut *mut c_char) {
    let _ = (argc, argv);
    #[allow(clippy::redundant_closure, reason = "errors name the call by the type of its closure")]
    guard_thread(|| contexts::init())
}

/// Ends what rtInit() began: destroys the initial context with everything in it, as rtDestroyContext() does.
/// rtInit() may be called again. It may be given to atexit(): a program that ends lets go of its contexts before.
///
/// Errors: RT_INVALID_OPERATION without rtInit(), or when the initial context is current on another thread.
#[unsafe(no_mangle)]
pub extern "C" fn rtExit() {
    #[allow(clippy::redundant_closure, reason = "errors name the call by the type of its closure")]
    guard_thread(|| contexts::exit())
}

/// Makes a further context, with objects, shaders, textures and frames of its own, and returns its name; 0 on
/// failure. It is not made current.
///
/// Errors: RT_IO_ERROR when the system refuses threads; RT_OUT_OF_MEMORY.
#[unsafe(no_mangle)]
pub extern "C" fn rtCreateContext() -> RTuint {
    guard_thread(|| contexts::create(0))
}

/// As rtCreateContext(), with as many worker threads as threads says; 0 for as many as rtThreads() has said.
///
/// Errors: RT_INVALID_VALUE when threads is negative or above 1024, RT_IO_ERROR when the system refuses threads.
#[unsafe(no_mangle)]
pub extern "C" fn rtCreateContextThreads(threads: RTsizei) -> RTuint {
    guard_thread(|| contexts::create(thread_count(threads)?))
}

/// Sets how many worker threads each context has that rtInit() and rtCreateContext() make from now on, in this
/// process; 0, as it is at first, lets OPENRT_NUM_THREADS and the system say. rtGetIntegerv(RT_THREADS, ...) tells
/// how many the current context has.
///
/// Errors: RT_INVALID_VALUE when threads is negative or above 1024.
#[unsafe(no_mangle)]
pub extern "C" fn rtThreads(threads: RTsizei) {
    guard_thread(|| {
        contexts::set_threads(thread_count(threads)?);
        Ok(())
    })
}

fn thread_count(threads: RTsizei) -> Result<u32> {
    u32::try_from(threads)
        .ok()
        .filter(|&n| n <= MAX_THREADS)
        .ok_or_else(|| Error::invalid_value(format_args!("threads is {threads}; it must be 0 to {MAX_THREADS}")))
}

/// Destroys a context with everything in it. A frame in flight is cancelled and waited for, so its frame buffer
/// must still exist. If the context is current on this thread, no context is current afterwards.
///
/// Errors: RT_INVALID_VALUE when there is no such context, RT_INVALID_OPERATION when it is current on another
/// thread.
#[unsafe(no_mangle)]
pub extern "C" fn rtDestroyContext(context: RTuint) {
    guard_thread(|| contexts::destroy(context))
}

/// Makes a context current on the calling thread; 0 makes none current. The context that was current before
/// keeps its state and can be made current on any thread. A thread that ends lets go of its context.
///
/// Errors: RT_INVALID_VALUE when there is no such context, RT_INVALID_OPERATION when it is current on another
/// thread.
#[unsafe(no_mangle)]
pub extern "C" fn rtMakeCurrent(context: RTuint) {
    guard_thread(|| contexts::make_current(context))
}

/// Name of the context that is current on the calling thread; 0 for none.
#[unsafe(no_mangle)]
pub extern "C" fn rtGetCurrentContext() -> RTuint {
    guard_thread(|| Ok(current_name()))
}

/// Returns the first error since the last call of this function and forgets it; RT_NO_ERROR when there was
/// none. A call that is in error changes nothing else. Errors of calls made while no context was current are
/// kept for the thread.
///
/// Errors: RT_INVALID_OPERATION between rtBegin() and rtEnd(), returning RT_NO_ERROR.
#[unsafe(no_mangle)]
pub extern "C" fn rtGetError() -> RTenum {
    if guard::has_no_error() {
        return RT_NO_ERROR;
    }
    #[allow(clippy::redundant_closure, reason = "errors name the call by the type of its closure")]
    guard_thread(|| guard::take_error())
}

/// A text for people. If error is what rtGetError() returned last on this thread, the text says what exactly was
/// wrong, as "rtInstantiateObject: there is no object 77"; otherwise, and after a megabyte of different texts, it
/// names the error. It never returns NULL. The text belongs to the library and is valid until the process ends.
#[unsafe(no_mangle)]
pub extern "C" fn rtGetErrorString(error: RTenum) -> *const c_char {
    guard_thread(|| Ok(guard::error_text(error)))
}

/// From now on, callback is called with every error of the current context, also with those that rtGetError()
/// does not return because an earlier one was not read yet. NULL stops that. userData is handed to the callback
/// and otherwise not touched.
///
/// Errors: RT_INVALID_OPERATION between rtBegin() and rtEnd().
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rtErrorCallback(callback: RTerrorCallback, userData: *mut c_void) {
    guard_session(|session| {
        session.context.is_object(0)?;
        session.callback = callback;
        session.user_data = UserData(userData);
        Ok(())
    })
}
