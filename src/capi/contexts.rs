//! All contexts of the process by name: making them, destroying them, and letting threads take them up.

use super::arrays::ClientArrays;
use super::current::{Session, UserData, current_name, exchange};
use super::loaded_scenes::LoadedScenes;
use super::types::RTuint;
use crate::api::{CancelHandle, Config, Context, Error, Result};
use crate::memory;
use std::collections::BTreeMap;
use std::sync::atomic::{AtomicU32, Ordering};
use std::sync::{Mutex, MutexGuard, PoisonError};

struct Table {
    last_name: RTuint,
    contexts: BTreeMap<RTuint, Entry>,
    /// The context made by `rtInit`, 0 for none.
    initial: RTuint,
}

struct Entry {
    /// None: current on some thread, which owns it.
    parked: Option<Box<Session>>,
    cancel: CancelHandle,
}

static TABLE: Mutex<Table> = Mutex::new(Table { last_name: 0, contexts: BTreeMap::new(), initial: 0 });

/// The table stays consistent when a panic passes: entries are inserted and removed whole.
fn table() -> MutexGuard<'static, Table> {
    TABLE.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Gives back the session of a thread.
pub(super) fn park(session: Box<Session>) {
    if let Some(entry) = table().contexts.get_mut(&session.name) {
        entry.parked = Some(session);
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
    memory::check()?;
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
    if current_name() == name {
        return Ok(());
    }
    let before = exchange(|| match name {
        0 => Ok(None),
        _ => match table().contexts.get_mut(&name) {
            None => Err(no_such_context(name)),
            Some(Entry { parked: None, .. }) => Err(current_elsewhere(name)),
            Some(Entry { parked, .. }) => Ok(parked.take()),
        },
    })?;
    if let Some(before) = before {
        park(before);
    }
    Ok(())
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
    // Waits for a frame in flight, with no lock held.
    drop(take_out(name)?);
    Ok(())
}

/// Takes context `name` out of the table, or from this thread.
fn take_out(name: RTuint) -> Result<Option<Box<Session>>> {
    let mut table = table();
    let entry = table.contexts.get_mut(&name).ok_or_else(|| no_such_context(name))?;
    let doomed = match entry.parked.take() {
        None if current_name() == name => exchange(|| Ok(None))?,
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
        let doomed = take_out(name);
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
