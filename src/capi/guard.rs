//! The one way from C into the library: what happens to errors and to panics.
//!
//! Callbacks to the application run after the context is put down, so they may call the library.
//!
//! What a call computes does not depend on the floating-point environment of its thread, nor does it raise signals there.
//!
//! A panic is a defect of ours. It is caught here, the context is marked unusable, and the application goes on.

use super::constants::*;
use super::current::{Session, borrow, missing, slot, texts_of_thread};
use super::texts;
use super::types::{RTboolean, RTenum, RTint, RTuint};
use crate::api::{Context, Error, ErrorCode, Result, with_default_floats};
use crate::memory;
use std::any::{Any, type_name};
use std::borrow::Cow;
use std::ffi::{CString, c_char};
use std::panic::{AssertUnwindSafe, catch_unwind};

/// What an export returns when its call is refused.
pub(super) trait Refused {
    const REFUSED: Self;
}

impl Refused for () {
    const REFUSED: () = ();
}

/// Names, handles, counts and error codes.
impl Refused for RTuint {
    const REFUSED: RTuint = 0;
}

impl Refused for RTint {
    const REFUSED: RTint = 0;
}

impl Refused for super::scenes::RTscene {
    const REFUSED: Self = std::ptr::null_mut();
}

impl Refused for RTboolean {
    const REFUSED: RTboolean = RT_FALSE;
}

impl Refused for *const c_char {
    const REFUSED: Self = std::ptr::null();
}

/// Runs `call`, a closure of an export, on the context that is current on this thread.
#[inline]
pub(super) fn guard<T: Refused, F: FnOnce(&mut Context) -> Result<T>>(call: F) -> T {
    guarded(type_name::<F>(), |session| call(&mut session.context))
}

/// As [`guard`], with what the C face keeps beside the context.
#[inline]
pub(super) fn guard_session<T: Refused, F: FnOnce(&mut Session) -> Result<T>>(call: F) -> T {
    guarded(type_name::<F>(), call)
}

#[inline]
fn guarded<T: Refused>(closure: &'static str, call: impl FnOnce(&mut Session) -> Result<T>) -> T {
    let Some(mut session) = borrow() else { return refuse(closure, missing()) };
    // Unwind safety: after a panic the context is poisoned, and what is poisoned answers nothing but errors.
    let outcome = catch_unwind(AssertUnwindSafe(|| {
        if memory::check_enough().is_err() && !frees_memory(closure) {
            return Err(Error::out_of_memory());
        }
        with_default_floats(|| call(&mut session))
    }));
    drop(session);
    match outcome {
        Ok(Ok(value)) => value,
        Ok(Err(error)) => refuse(closure, error),
        Err(payload) => defect(closure, payload),
    }
}

/// Runs `call`, which needs no context (it makes, changes or asks for the current one).
pub(super) fn guard_thread<T: Refused, F: FnOnce() -> Result<T>>(call: F) -> T {
    match catch_unwind(AssertUnwindSafe(|| with_default_floats(call))) {
        Ok(Ok(value)) => value,
        Ok(Err(error)) => refuse(type_name::<F>(), error),
        Err(payload) => defect(type_name::<F>(), payload),
    }
}

/// The export that a closure is in, by the path of the closure's type (`openrt::capi::view::rtUseLight::{{closure}}`): so texts name the call, and
/// calls that go well pay nothing for it.
fn call_of(closure: &str) -> &str {
    closure.split("::").find(|part| part.starts_with("rt")).unwrap_or("openrt")
}

/// Whether a call goes on while hardly anything of the memory put aside is left, since it takes none, or leads to some.
#[cold]
fn frees_memory(closure: &'static str) -> bool {
    ["rtDelete", "rtClear", "rtEnd", "rtPop", "rtFinish", "rtGet", "rtIs"]
        .iter()
        .any(|few| call_of(closure).starts_with(few))
}

/// Records `error` where `rtGetError` of this thread will find it, then tells the callback.
#[cold]
#[inline(never)]
fn refuse<T: Refused>(closure: &'static str, error: Error) -> T {
    // Reporting must not fail: whatever goes wrong here is dropped.
    let _ = catch_unwind(AssertUnwindSafe(|| {
        let message = &error.message;
        report(Error::new(error.code, format_args!("{}: {message}", call_of(closure))));
    }));
    T::REFUSED
}

fn report(error: Error) {
    let code = number_of(error.code);
    let Some(mut session) = borrow() else {
        return slot(|slot| {
            if slot.homeless.get() == RT_NO_ERROR {
                slot.homeless.set(code);
                // The text is lost on a thread that has ended; its code is not.
                let _ = texts_of_thread(|texts| texts.homeless.replace(error.message));
            }
        });
    };
    let told = session.callback.map(|callback| (callback, c_text(&error.message), session.user_data));
    session.context.latch(error);
    drop(session);
    // A callback that makes errors of its own must not call itself without end.
    if let Some((callback, text, user_data)) = told
        && !slot(|slot| slot.telling.replace(true))
    {
        // SAFETY: the application gave this function to rtErrorCallback for such calls; `text` lives until after it.
        unsafe { callback(code, text.as_ptr(), user_data.0) };
        slot(|slot| slot.telling.set(false));
    }
}

/// A panic came out of the library: the context cannot be trusted any more.
#[cold]
#[inline(never)]
fn defect<T: Refused>(closure: &'static str, payload: Box<dyn Any + Send>) -> T {
    let why = if let Some(text) = payload.downcast_ref::<&str>() {
        (*text).to_owned()
    } else if let Some(text) = payload.downcast_ref::<String>() {
        text.clone()
    } else {
        "of unknown kind".to_owned()
    };
    // The payload's own destructor may panic.
    let _ = catch_unwind(AssertUnwindSafe(|| drop(payload)));
    let text = format!("a defect of openrt: {why}");
    if let Some(mut session) = borrow() {
        session.context.poison(text.clone());
    }
    refuse(closure, Error::new(ErrorCode::InternalError, text))
}

/// A text for C; zero bytes cannot be part of it.
pub(super) fn c_text(text: &str) -> CString {
    CString::new(text.replace('\0', " ")).unwrap_or_default()
}

/// `rtGetError` for those who ask after every call.
#[inline]
pub(super) fn has_no_error() -> bool {
    slot(|slot| {
        let nothing = slot.has_no_error();
        if nothing {
            slot.last_code.set(RT_NO_ERROR);
        }
        nothing
    })
}

/// The error of the current context, else of this thread, which is thereby forgotten.
pub(super) fn take_error() -> Result<RTenum> {
    let of_context = match borrow() {
        Some(mut session) => error_of(&mut session.context)?,
        None => None,
    };
    let found = of_context.or_else(|| match slot(|slot| slot.homeless.replace(RT_NO_ERROR)) {
        RT_NO_ERROR => None,
        code => Some((code, texts_of_thread(|texts| texts.homeless.take()).unwrap_or_default())),
    });
    let code = found.as_ref().map_or(RT_NO_ERROR, |found| found.0);
    slot(|slot| slot.last_code.set(code));
    if let Some((_, text)) = found {
        // The text is lost on a thread that has ended; its code is not.
        let _ = texts_of_thread(|texts| texts.last.replace(text));
    }
    Ok(code)
}

fn error_of(context: &mut Context) -> Result<Option<(RTenum, Cow<'static, str>)>> {
    // Asked of the name 0, which is never an object: fails between begin and end, and does nothing.
    if !context.is_poisoned() {
        context.is_object(0)?;
    }
    Ok(match context.get_error() {
        ErrorCode::NoError => None,
        code => Some((number_of(code), context.error_text().clone())),
    })
}

/// Text of `code`: in full when it is what `rtGetError` returned last on this thread.
pub(super) fn error_text(code: RTenum) -> *const c_char {
    let full = || texts_of_thread(|thread| texts::bounded(&thread.last.borrow())).flatten();
    let general = match code {
        RT_NO_ERROR => c"no error",
        RT_INVALID_ENUM => c"invalid enumerant",
        RT_INVALID_VALUE => c"invalid value",
        RT_INVALID_OPERATION => c"invalid operation",
        RT_STACK_OVERFLOW => c"stack overflow",
        RT_STACK_UNDERFLOW => c"stack underflow",
        RT_OUT_OF_MEMORY => c"out of memory",
        RT_IO_ERROR => c"input or output failed",
        RT_INTERNAL_ERROR => c"a defect of openrt",
        _ => c"not an error code",
    };
    let is_last = code != RT_NO_ERROR && code == slot(|slot| slot.last_code.get());
    is_last.then(full).flatten().unwrap_or(general).as_ptr()
}

fn number_of(code: ErrorCode) -> RTenum {
    match code {
        ErrorCode::NoError => RT_NO_ERROR,
        ErrorCode::InvalidEnum => RT_INVALID_ENUM,
        ErrorCode::InvalidValue => RT_INVALID_VALUE,
        ErrorCode::InvalidOperation => RT_INVALID_OPERATION,
        ErrorCode::StackOverflow => RT_STACK_OVERFLOW,
        ErrorCode::StackUnderflow => RT_STACK_UNDERFLOW,
        ErrorCode::OutOfMemory => RT_OUT_OF_MEMORY,
        ErrorCode::Io => RT_IO_ERROR,
        ErrorCode::InternalError => RT_INTERNAL_ERROR,
    }
}
