//! Where the bytes of pictures go: a file that is there whole or not at all, or the standard output.

use openrt::frame::NewFile;
use std::cell::RefCell;
use std::fs;
use std::io::{self, Stdout, Write};
use std::path::Path;
use std::rc::Rc;

/// Name that stands for the standard output.
pub const STANDARD: &str = "-";

enum Place {
    File(NewFile),
    Standard(Stdout),
}

impl Write for Place {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        match self {
            Place::File(file) => file.write(bytes),
            Place::Standard(out) => out.write(bytes),
        }
    }

    fn flush(&mut self) -> io::Result<()> {
        match self {
            Place::File(file) => file.flush(),
            Place::Standard(out) => out.flush(),
        }
    }
}

struct State {
    place: Place,
    /// The first error; encoders that write when they are dropped keep it to themselves.
    error: Option<io::Error>,
}

/// A place to write to. Encoders get a [`Destination::writer`]; when they are dropped it is [`Destination::complete`].
pub struct Destination(Rc<RefCell<State>>);

#[derive(Clone)]
pub struct Writer(Rc<RefCell<State>>);

impl Destination {
    /// Begins the file `path`, whose folder is made, or goes on with the standard output for `-`.
    pub fn create(path: &Path) -> Result<Self, String> {
        let place = if path == Path::new(STANDARD) {
            Place::Standard(io::stdout())
        } else {
            create_folder(path)?;
            Place::File(NewFile::create(path).map_err(|e| format!("{}: {e}", path.display()))?)
        };
        Ok(Self(Rc::new(RefCell::new(State { place, error: None }))))
    }

    pub fn writer(&self) -> Writer {
        Writer(self.0.clone())
    }

    /// Puts the file in its place, unless an error was met before.
    pub fn complete(self, path: &Path) -> Result<(), String> {
        let state = Rc::try_unwrap(self.0).map_err(|_| format!("{}: still in use", path.display()))?.into_inner();
        let written = match (state.error, state.place) {
            (Some(error), _) => Err(error),
            (None, Place::File(file)) => file.complete(),
            (None, Place::Standard(mut out)) => out.flush(),
        };
        written.map_err(|e| format!("{}: {e}", path.display()))
    }
}

impl Write for Writer {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let mut state = self.0.borrow_mut();
        let written = state.place.write(bytes);
        if let Err(error) = &written
            && error.kind() != io::ErrorKind::Interrupted
            && state.error.is_none()
        {
            state.error = Some(io::Error::new(error.kind(), error.to_string()));
        }
        written
    }

    fn flush(&mut self) -> io::Result<()> {
        self.0.borrow_mut().place.flush()
    }
}

pub fn create_folder(path: &Path) -> Result<(), String> {
    match path.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => {
            fs::create_dir_all(folder).map_err(|e| format!("{}: {e}", folder.display()))
        }
        _ => Ok(()),
    }
}
