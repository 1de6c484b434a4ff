//! The context that is current on a thread, and what else the thread has.
//!
//! A context is current on at most one thread, which owns it then; otherwise it is parked in the table of [`super::contexts`]. So a call takes no
//! lock, and that two threads cannot share a context needs no proof. A call borrows the context; what the application is called back for within it
//! finds it busy, and what comes after the call does not.
//!
//! What a thread has lies in storage without a destructor, which a call finds by an addition in a static library and by one call of the dynamic
//! loader in a shared one. That a thread which ends gives its context back is the business of a second variable, touched when one is made current.

use super::arrays::ClientArrays;
use super::constants::RT_NO_ERROR;
use super::contexts::park;
use super::loaded_scenes::LoadedScenes;
use super::types::{RTenum, RTerrorCallback, RTuint};
use crate::api::{Context, Error, Result};
use std::borrow::Cow;
use std::cell::{Cell, RefCell};
use std::ffi::c_void;
use std::ops::{Deref, DerefMut};
use std::ptr;

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

/// What a thread has.
pub(super) struct Slot {
    /// From `Box::into_raw`, owned; NULL for none.
    session: Cell<*mut Session>,
    /// A [`Borrowed`] of it exists.
    busy: Cell<bool>,
    /// The thread has given its context back for good.
    ended: Cell<bool>,
    /// First error of a call without a context.
    pub homeless: Cell<RTenum>,
    /// What `rtGetError` returned last.
    pub last_code: Cell<RTenum>,
    /// The error callback of the application is running; errors that it makes are recorded, not told.
    pub telling: Cell<bool>,
}

thread_local! {
    static SLOT: Slot = const {
        Slot {
            session: Cell::new(ptr::null_mut()),
            busy: Cell::new(false),
            ended: Cell::new(false),
            homeless: Cell::new(RT_NO_ERROR),
            last_code: Cell::new(RT_NO_ERROR),
            telling: Cell::new(false),
        }
    };
    static OWNER: Owner = const { Owner { texts: Texts { last: empty(), homeless: empty() } } };
}

const fn empty() -> RefCell<Cow<'static, str>> {
    RefCell::new(Cow::Borrowed(""))
}

/// Texts of errors.
pub(super) struct Texts {
    /// Of what `rtGetError` returned last.
    pub last: RefCell<Cow<'static, str>>,
    /// Of the first error of a call without a context.
    pub homeless: RefCell<Cow<'static, str>>,
}

/// Gives the thread's context back when the thread ends, so that another one can take it. All that is to be dropped is here, as the system must
/// remember each such variable and ends the process where it has no memory for that.
struct Owner {
    texts: Texts,
}

/// Texts of the thread's errors; None on a thread that has ended.
pub(super) fn texts_of_thread<R>(f: impl FnOnce(&Texts) -> R) -> Option<R> {
    OWNER.try_with(|owner| f(&owner.texts)).ok()
}

impl Drop for Owner {
    fn drop(&mut self) {
        slot(|slot| {
            slot.ended.set(true);
            if let Some(session) = slot.take() {
                park(session);
            }
        });
    }
}

impl Slot {
    /// Takes the session out; None where there is none.
    fn take(&self) -> Option<Box<Session>> {
        let session = self.session.replace(ptr::null_mut());
        // SAFETY: what was not NULL came from `into_raw` in `exchange`, and is there no more. Nobody has borrowed it, see the callers.
        (!session.is_null()).then(|| unsafe { Box::from_raw(session) })
    }

    /// Whether no context is current, or the one that is has no error.
    #[inline]
    pub fn has_no_error(&self) -> bool {
        let session = self.session.get();
        // SAFETY: not NULL, so a session of this thread, which nobody uses meanwhile.
        self.homeless.get() == RT_NO_ERROR
            && (session.is_null() || !self.busy.get() && unsafe { &*session }.context.has_no_error())
    }
}

/// What the thread has.
#[inline]
pub(super) fn slot<R>(f: impl FnOnce(&Slot) -> R) -> R {
    SLOT.with(f)
}

/// The session of this thread, for the duration of a call.
pub(super) struct Borrowed {
    session: *mut Session,
    /// Where it came from.
    slot: *const Slot,
}

/// Borrows the session that is current on this thread; None for the reasons that [`missing`] tells.
#[inline(always)]
pub(super) fn borrow() -> Option<Borrowed> {
    slot(|slot| {
        let session = slot.session.get();
        if session.is_null() || slot.busy.replace(true) {
            return None;
        }
        Some(Borrowed { session, slot })
    })
}

impl Deref for Borrowed {
    type Target = Session;

    #[inline(always)]
    fn deref(&self) -> &Session {
        // SAFETY: a session of this thread. While the slot is busy nobody takes it out, and there is one `Borrowed`.
        unsafe { &*self.session }
    }
}

impl DerefMut for Borrowed {
    #[inline(always)]
    fn deref_mut(&mut self) -> &mut Session {
        // SAFETY: as above.
        unsafe { &mut *self.session }
    }
}

impl Drop for Borrowed {
    #[inline(always)]
    fn drop(&mut self) {
        // SAFETY: the storage of this thread; it has no destructor and is there as long as the thread runs code.
        unsafe { &*self.slot }.busy.set(false);
    }
}

/// Why [`borrow`] gave none.
#[cold]
pub(super) fn missing() -> Error {
    slot(|slot| {
        Error::invalid_operation(if !slot.session.get().is_null() {
            "the context is busy with another call of this thread"
        } else if slot.ended.get() {
            // Functions that `atexit()` runs come after the thread's storage: its context is parked by then.
            "the thread has let go of its context, as it has ended or the process is ending"
        } else {
            "no context is current on this thread: call rtInit or rtMakeCurrent first"
        })
    })
}

/// Name of the context that is current on this thread; 0 for none.
pub(super) fn current_name() -> RTuint {
    slot(|slot| {
        let session = slot.session.get();
        // SAFETY: a session of this thread. Its name never changes, so it may be read while a call has borrowed the rest.
        if session.is_null() { 0 } else { unsafe { (&raw const (*session).name).read() } }
    })
}

/// Makes `next`, if any, the session of this thread and returns the one before. Fails while a call has borrowed that, and on a thread that has ended;
/// `next` is asked for only if it does not.
pub(super) fn exchange(next: impl FnOnce() -> Result<Option<Box<Session>>>) -> Result<Option<Box<Session>>> {
    slot(|slot| {
        if slot.busy.get() || slot.ended.get() || OWNER.try_with(|_| ()).is_err() {
            return Err(missing());
        }
        let next = next()?;
        let before = slot.take();
        slot.session.set(next.map_or(ptr::null_mut(), Box::into_raw));
        Ok(before)
    })
}
