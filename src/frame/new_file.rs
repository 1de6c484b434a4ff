//! Files that are there whole or not at all.
//!
//! What is written goes to a file beside the one that is meant, which takes its place when it is complete. Whatever ends the writing before, a full
//! disk, an error or the end of the process, leaves the file that was there. A process that is killed may leave the other one, `.openrt-….part`.

use std::fs::{self, File, OpenOptions};
use std::io::{self, BufWriter, ErrorKind, Write};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU32, Ordering};

/// A file in the making: write to it, then [`NewFile::complete`] it. Dropped before that, it goes away.
pub struct NewFile {
    file: BufWriter<File>,
    /// Where it is written, and whose place it takes; None when it is written in place.
    beside: Option<(PathBuf, PathBuf)>,
}

impl NewFile {
    /// Begins a file that shall become `path`. A symbolic link stays one, and permissions are those of the file before.
    /// What is no regular file, such as a pipe, is written in place; so is a file in a folder that takes no others.
    ///
    /// # Errors
    /// The file system refuses.
    pub fn create(path: &Path) -> io::Result<Self> {
        let before = match fs::metadata(path) {
            Ok(before) if before.is_file() => Some(before),
            // Pipes, devices, links to nowhere; folders give an error.
            Ok(_) => return Self::in_place(path),
            Err(_) if fs::symlink_metadata(path).is_ok() => return Self::in_place(path),
            Err(_) => None,
        };
        let place = match &before {
            // A file that must not be written must not be replaced either.
            Some(_) => OpenOptions::new().write(true).open(path).and_then(|_| fs::canonicalize(path))?,
            None => path.to_owned(),
        };
        static COUNT: AtomicU32 = AtomicU32::new(0);
        let name = format!(".openrt-{}-{}.part", std::process::id(), COUNT.fetch_add(1, Ordering::Relaxed));
        let part = place.with_file_name(name);
        let file = match File::create(&part) {
            Ok(file) => file,
            Err(error) if before.is_some() && error.kind() != ErrorKind::StorageFull => return Self::in_place(path),
            Err(error) => return Err(error),
        };
        let new = Self { file: BufWriter::new(file), beside: Some((part, place)) };
        if let Some(before) = before {
            // Not every file system has permissions.
            let _ = new.file.get_ref().set_permissions(before.permissions());
        }
        Ok(new)
    }

    fn in_place(path: &Path) -> io::Result<Self> {
        Ok(Self { file: BufWriter::new(File::create(path)?), beside: None })
    }

    /// Puts the file in its place.
    ///
    /// # Errors
    /// The file system refuses; the file before is still there.
    pub fn complete(mut self) -> io::Result<()> {
        self.file.flush()?;
        if let Some((part, place)) = &self.beside {
            fs::rename(part, place)?;
            self.beside = None;
        }
        Ok(())
    }
}

impl Write for NewFile {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.file.write(bytes)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.file.flush()
    }
}

impl Drop for NewFile {
    fn drop(&mut self) {
        if let Some((part, _)) = &self.beside {
            // Nobody is left to be told.
            let _ = fs::remove_file(part);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn folder(name: &str) -> PathBuf {
        let folder = std::env::temp_dir().join(format!("openrt_new_file_{name}_{}", std::process::id()));
        let _ = fs::remove_dir_all(&folder);
        fs::create_dir_all(&folder).unwrap();
        folder
    }

    #[test]
    fn the_old_file_stays_until_the_new_one_is_complete() {
        let folder = folder("stays");
        let path = folder.join("a");
        fs::write(&path, "old").unwrap();
        let mut new = NewFile::create(&path).unwrap();
        new.write_all(&[b'x'; 100_000]).unwrap();
        assert_eq!(fs::read(&path).unwrap(), b"old");
        drop(new);
        assert_eq!(fs::read(&path).unwrap(), b"old");
        assert_eq!(fs::read_dir(&folder).unwrap().count(), 1, "what was given up is gone");
        let mut new = NewFile::create(&path).unwrap();
        new.write_all(b"new").unwrap();
        new.complete().unwrap();
        assert_eq!(fs::read(&path).unwrap(), b"new");
        assert_eq!(fs::read_dir(&folder).unwrap().count(), 1);
        let fresh = folder.join("fresh");
        NewFile::create(&fresh).unwrap().complete().unwrap();
        assert!(fresh.is_file());
        assert!(NewFile::create(&folder).is_err(), "a folder");
        assert!(NewFile::create(&folder.join("no/such")).is_err());
        fs::remove_dir_all(&folder).unwrap();
    }

    #[cfg(unix)]
    #[test]
    fn links_and_permissions_stay_and_devices_are_written_in_place() {
        use std::os::unix::fs::{PermissionsExt, symlink};
        let folder = folder("links");
        let (path, link) = (folder.join("a"), folder.join("link"));
        fs::write(&path, "old").unwrap();
        fs::set_permissions(&path, fs::Permissions::from_mode(0o640)).unwrap();
        symlink("a", &link).unwrap();
        let mut new = NewFile::create(&link).unwrap();
        new.write_all(b"new").unwrap();
        new.complete().unwrap();
        assert_eq!(fs::read_link(&link).unwrap(), Path::new("a"));
        assert_eq!(fs::read(&path).unwrap(), b"new");
        assert_eq!(fs::metadata(&path).unwrap().permissions().mode() & 0o777, 0o640);
        let mut full = NewFile::create(Path::new("/dev/full")).unwrap();
        full.write_all(b"x").unwrap();
        assert_eq!(full.complete().unwrap_err().kind(), ErrorKind::StorageFull);
        fs::remove_dir_all(&folder).unwrap();
    }
}
