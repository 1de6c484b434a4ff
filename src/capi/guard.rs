//! The one way from C into the library: which context is current, what happens to errors and to panics.
//!
//! A context is current on at most one thread, and then *lives* in that thread's storage; otherwise it is
//! parked in a table. So the vertex path takes no lock (3 ns instead of 14 ns with a process-wide mutex), and
//! that two threads cannot share a context needs no proof. Callbacks to the application run after the context
//! is put down, so they may call the library.
//!
//! A panic is a defect of ours. It is caught here, the context is marked unusable, and the application goes on.

use super::arrays::ClientArrays;
use super::constants::*;
use super::loaded_scenes::LoadedScenes;
use super::texts;
use super::types::{RTboolean, RTenum, RTerrorCallback, RTint, RTuint};
use crate::api::{CancelHandle, Config, Context, Error, ErrorCode, Result};
use std::any::{Any, type_name};
use std::borrow::Cow;
use std::cell::{Cell, RefCell};
use std::collections::BTreeMap;
use std::ffi::{CString, c_char, c_void};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::atomic::{AtomicU32, Ordering};
use std::sync::{Mutex, MutexGuard, PoisonError};

/// A context and what the C face keeps with it.
pub(super) struct Session {
    pub name: RTuint,
    pub context: Context,
    pub callback: RTerrorCallback,
    pub user_data: UserData,
    pub arrays: ClientArrays,
    pub scenes: LoadedScenes,
}

impl Session {
    /// Fails between begin and end, and after a defect.
    pub fn outside_begin(&self) -> Result<()> {
        // The name 0 is never an object: asking has no other effect.
        self.context.is_object(0).map(|_| ())
    }
}

/// A pointer of the application that we only hand back to its functions.
#[derive(Clone, Copy)]
pub(super) struct UserData(pub *mut c_void);

// SAFETY: we never read through it; the manual of each function that takes one says on which threads it comes back.
unsafe impl Send for UserData {}
// SAFETY: as above.
unsafe impl Sync for UserData {}

/// All contexts of the process by name.
struct Table {
    last_name: RTuint,
    contexts: BTreeMap<RTuint, Entry>,
    /// The context made by `rtInit`, 0 for none.
    initial: RTuint,
}

struct Entry {
    /// None: current on some thread, which holds it.
    parked: Option<Box<Session>>,
    cancel: CancelHandle,
}

static TABLE: Mutex<Table> = Mutex::new(Table { last_name: 0, contexts: BTreeMap::new(), initial: 0 });

/// The table stays consistent when a panic passes: entries are inserted and removed whole.
fn table() -> MutexGuard<'static, Table> {
    TABLE.lock().unwrap_or_else(PoisonError::into_inner)
}

/// The context that is current on a thread.
struct Slot(RefCell<Option<Box<Session>>>);

impl Drop for Slot {
    /// A thread that ends gives its context back, so that another thread can take it.
    fn drop(&mut self) {
        if let Some(session) = self.0.get_mut().take() {
            park(session);
        }
    }
}

fn park(session: Box<Session>) {
    if let Some(entry) = table().contexts.get_mut(&session.name) {
        entry.parked = Some(session);
    }
}

thread_local! {
    static SLOT: Slot = const { Slot(RefCell::new(None)) };
    /// The error callback of the application is running; errors that it makes are recorded, not told.
    static TELLING: Cell<bool> = const { Cell::new(false) };
    /// First error of a thread on which no context was current.
    static HOMELESS_ERROR: Cell<RTenum> = const { Cell::new(RT_NO_ERROR) };
    /// What `rtGetError` returned last on this thread, and its text for `rtGetErrorString`.
    static LAST_CODE: Cell<RTenum> = const { Cell::new(RT_NO_ERROR) };
    static LAST_TEXT: RefCell<Cow<'static, str>> = const { RefCell::new(Cow::Borrowed("")) };
    static HOMELESS_TEXT: RefCell<Cow<'static, str>> = const { RefCell::new(Cow::Borrowed("")) };
}

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
    // Unwind safety: after a panic the context is poisoned, and what is poisoned answers nothing but errors.
    let outcome = catch_unwind(AssertUnwindSafe(|| {
        let outcome = SLOT.try_with(|slot| match slot.0.try_borrow_mut() {
            Ok(mut current) => match &mut *current {
                Some(session) => call(session),
                None => Err(no_context()),
            },
            Err(_) => Err(Error::invalid_operation("the context is busy with another call of this thread")),
        });
        outcome.unwrap_or_else(|_| Err(thread_has_ended()))
    }));
    match outcome {
        Ok(Ok(value)) => value,
        Ok(Err(error)) => refuse(closure, error),
        Err(payload) => defect(closure, payload),
    }
}

/// Runs `call`, which needs no context (it makes, changes or asks for the current one).
pub(super) fn guard_thread<T: Refused, F: FnOnce() -> Result<T>>(call: F) -> T {
    match catch_unwind(AssertUnwindSafe(call)) {
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

#[cold]
fn no_context() -> Error {
    Error::invalid_operation("no context is current on this thread: call rtInit or rtMakeCurrent first")
}

/// Functions that `atexit()` runs come after the thread's storage: its context is parked by then.
#[cold]
fn thread_has_ended() -> Error {
    Error::invalid_operation("the thread has let go of its context, as it has ended or the process is ending")
}

/// Records `error` where `rtGetError` of this thread will find it, then tells the callback.
#[cold]
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
    let told = SLOT.try_with(|slot| {
        let mut current = slot.0.try_borrow_mut().ok()?;
        let session = current.as_mut()?;
        let text = session.callback.is_some().then(|| c_text(&error.message));
        session.context.latch(error.clone());
        Some((session.callback, session.user_data, text))
    });
    match told {
        // A callback that makes errors of its own must not call itself without end.
        Ok(Some((Some(callback), user_data, Some(text)))) => {
            if !TELLING.replace(true) {
                // SAFETY: the application gave this function to rtErrorCallback for such calls; `text` lives until after it.
                unsafe { callback(code, text.as_ptr(), user_data.0) };
                TELLING.set(false);
            }
        }
        Ok(Some(_)) => {}
        _ => {
            let _ = HOMELESS_ERROR.try_with(|first| {
                if first.get() == RT_NO_ERROR {
                    first.set(code);
                    let _ = HOMELESS_TEXT.try_with(|text| *text.borrow_mut() = error.message);
                }
            });
        }
    }
}

/// A panic came out of the library: the context cannot be trusted any more.
#[cold]
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
    let _ = SLOT.try_with(|slot| {
        if let Ok(mut current) = slot.0.try_borrow_mut()
            && let Some(session) = current.as_mut()
        {
            session.context.poison(text.clone());
        }
    });
    refuse(closure, Error::new(ErrorCode::InternalError, text))
}

/// A text for C; zero bytes cannot be part of it.
pub(super) fn c_text(text: &str) -> CString {
    CString::new(text.replace('\0', " ")).unwrap_or_default()
}

/// The error of the current context, else of this thread, which is thereby forgotten.
pub(super) fn take_error() -> Result<RTenum> {
    let of_context = SLOT.try_with(|slot| -> Result<Option<(RTenum, Cow<'static, str>)>> {
        let mut current = slot.0.borrow_mut();
        let Some(session) = current.as_mut() else { return Ok(None) };
        let context = &mut session.context;
        // Asked of the name 0, which is never an object: fails between begin and end, and does nothing.
        if !context.is_poisoned() {
            context.is_object(0)?;
        }
        Ok(match context.get_error() {
            ErrorCode::NoError => None,
            code => Some((number_of(code), context.error_text().clone())),
        })
    });
    let of_context = of_context.unwrap_or(Ok(None))?;
    let found = of_context.or_else(|| match HOMELESS_ERROR.replace(RT_NO_ERROR) {
        RT_NO_ERROR => None,
        code => Some((code, HOMELESS_TEXT.try_with(RefCell::take).unwrap_or_default())),
    });
    let code = found.as_ref().map_or(RT_NO_ERROR, |found| found.0);
    LAST_CODE.set(code);
    if let Some((_, text)) = found {
        // The text is lost on a thread that has ended; its code is not.
        let _ = LAST_TEXT.try_with(|last| last.replace(text));
    }
    Ok(code)
}

/// Text of `code`: in full when it is what `rtGetError` returned last on this thread.
pub(super) fn error_text(code: RTenum) -> *const c_char {
    let full = || LAST_TEXT.try_with(|text| texts::bounded(&text.borrow())).ok().flatten();
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
    let is_last = code != RT_NO_ERROR && code == LAST_CODE.get();
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

/// Worker threads of the contexts that are made from now on; 0 lets the environment say.
static THREADS: AtomicU32 = AtomicU32::new(0);

pub(super) fn set_threads(threads: u32) {
    THREADS.store(threads, Ordering::Relaxed);
}

/// Makes a context, which is current nowhere yet, with so many threads; 0 for as many as [`set_threads`] said.
pub(super) fn create(threads: u32) -> Result<RTuint> {
    let threads = if threads == 0 { THREADS.load(Ordering::Relaxed) } else { threads };
    let threads = (threads > 0).then_some(threads as usize);
    // Made before the table is locked: starting threads takes time.
    let context = Context::with_config(Config { threads, ..Config::default() })?;
    let cancel = context.cancel_handle();
    let mut table = table();
    let name = table.last_name.checked_add(1).ok_or_else(Error::out_of_memory)?;
    table.last_name = name;
    let session = Session {
        name,
        context,
        callback: None,
        user_data: UserData(std::ptr::null_mut()),
        arrays: ClientArrays::default(),
        scenes: LoadedScenes::default(),
    };
    table.contexts.insert(name, Entry { parked: Some(Box::new(session)), cancel });
    Ok(name)
}

/// Makes context `name` current on this thread, or none for 0. The one before is parked.
pub(super) fn make_current(name: RTuint) -> Result<()> {
    let made = SLOT.try_with(|slot| {
        let mut current = slot.0.try_borrow_mut().map_err(|_| Error::invalid_operation("the context is busy"))?;
        if current.as_ref().map_or(0, |s| s.name) == name {
            return Ok(());
        }
        let next = match name {
            0 => None,
            _ => match table().contexts.get_mut(&name) {
                None => return Err(no_such_context(name)),
                Some(Entry { parked: None, .. }) => return Err(current_elsewhere(name)),
                Some(Entry { parked, .. }) => parked.take(),
            },
        };
        if let Some(before) = std::mem::replace(&mut *current, next) {
            park(before);
        }
        Ok(())
    });
    made.unwrap_or_else(|_| Err(thread_has_ended()))
}

/// Name of the context that is current on this thread; 0 for none.
pub(super) fn current_name() -> RTuint {
    let name = SLOT.try_with(|slot| slot.0.try_borrow().map_or(0, |current| current.as_ref().map_or(0, |s| s.name)));
    name.unwrap_or(0)
}

fn no_such_context(name: RTuint) -> Error {
    Error::invalid_value(format_args!("there is no context {name}"))
}

fn current_elsewhere(name: RTuint) -> Error {
    Error::invalid_operation(format_args!("context {name} is current on another thread"))
}

/// Cancels the frame of context `name`, wherever it is current.
pub(super) fn cancel(name: RTuint) -> Result<()> {
    table().contexts.get(&name).ok_or_else(|| no_such_context(name))?.cancel.cancel();
    Ok(())
}

/// Destroys context `name`, which must not be current on another thread.
pub(super) fn destroy(name: RTuint) -> Result<()> {
    let doomed = SLOT.try_with(|slot| {
        let mut current = slot.0.try_borrow_mut().map_err(|_| Error::invalid_operation("the context is busy"))?;
        take_out(name, &mut current)
    });
    let doomed = doomed.unwrap_or_else(|_| take_out(name, &mut None))?;
    // Waits for a frame in flight, with no lock held.
    drop(doomed);
    Ok(())
}

/// Takes context `name` out of the table; `current` is the one of this thread.
fn take_out(name: RTuint, current: &mut Option<Box<Session>>) -> Result<Option<Box<Session>>> {
    let mut table = table();
    let entry = table.contexts.get_mut(&name).ok_or_else(|| no_such_context(name))?;
    let doomed = match entry.parked.take() {
        None if current.as_ref().is_some_and(|s| s.name == name) => current.take(),
        None => return Err(current_elsewhere(name)),
        parked => parked,
    };
    entry.cancel.cancel();
    table.contexts.remove(&name);
    if table.initial == name {
        table.initial = 0;
    }
    Ok(doomed)
}

/// `rtInit`: makes the initial context and makes it current.
pub(super) fn init() -> Result<()> {
    if table().initial != 0 {
        return Err(Error::invalid_operation("it was called before, and rtExit not since"));
    }
    if current_name() != 0 {
        return Err(Error::invalid_operation("a context is current on this thread already"));
    }
    let name = create(0)?;
    {
        let mut table = table();
        if table.initial != 0 {
            let lost_race = table.contexts.remove(&name);
            drop(table);
            drop(lost_race);
            return Err(Error::invalid_operation("it was called on another thread"));
        }
        table.initial = name;
    }
    make_current(name).inspect_err(|_| {
        let doomed = take_out(name, &mut None);
        drop(doomed);
    })
}

/// `rtExit`: destroys the initial context.
pub(super) fn exit() -> Result<()> {
    let initial = table().initial;
    match initial {
        0 => Err(Error::invalid_operation("rtInit was not called")),
        name => destroy(name),
    }
}
