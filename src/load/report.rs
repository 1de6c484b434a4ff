//! What is told about a file that was read: things left out and lines that were not understood.

use super::LoadError;
use std::collections::HashMap;
use std::path::{Path, PathBuf};

/// Kinds of things that are told about one file; a file of random words has as many kinds as lines.
const MOST_KINDS: usize = 100;

/// Lines of one file that are shown one by one before the rest is counted.
const SHOWN_LINES: u32 = 20;

/// Warnings about one file. Each kind is told once, with the line where it was met first; so a file of a million odd lines
/// does not flood the screen.
#[derive(Debug)]
pub struct Report {
    path: PathBuf,
    entries: Vec<Entry>,
    /// Place in `entries` by kind.
    kinds: HashMap<String, usize>,
    broken: u32,
    further_kinds: u32,
}

#[derive(Debug)]
struct Entry {
    line: Option<u32>,
    text: String,
    further: u32,
}

impl Report {
    pub fn new(path: &Path) -> Self {
        Self { path: path.to_path_buf(), entries: Vec::new(), kinds: HashMap::new(), broken: 0, further_kinds: 0 }
    }

    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Something of a kind that is told once. `kind` is also the text.
    pub fn once(&mut self, line: Option<u32>, kind: &str) {
        match self.kinds.get(kind) {
            Some(&known) => self.entries[known].further += 1,
            None if self.kinds.len() >= MOST_KINDS => self.further_kinds += 1,
            None => {
                self.kinds.insert(kind.to_owned(), self.entries.len());
                self.entries.push(Entry { line, text: kind.to_owned(), further: 0 });
            }
        }
    }

    /// A line that is not understood and left out.
    pub fn broken(&mut self, line: u32, text: impl Into<String>) {
        self.broken += 1;
        if self.broken <= SHOWN_LINES {
            self.entries.push(Entry { line: Some(line), text: text.into(), further: 0 });
        }
    }

    /// The warnings, as `path:line: text`.
    pub fn into_warnings(self) -> Vec<String> {
        let Self { path, entries, broken, further_kinds, .. } = self;
        let told = |line, text: String| LoadError::new(&path, line, text).to_string();
        let mut warnings: Vec<String> = entries
            .into_iter()
            .map(|e| match e.further {
                0 => told(e.line, e.text),
                1 => told(e.line, format!("{} (and once more)", e.text)),
                n => told(e.line, format!("{} (and {n} times more)", e.text)),
            })
            .collect();
        if broken > SHOWN_LINES {
            warnings.push(told(None, format!("{} further lines are not understood", broken - SHOWN_LINES)));
        }
        if further_kinds > 0 {
            warnings.push(told(None, format!("{further_kinds} further things are left out")));
        }
        warnings
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn kinds_are_told_once_and_lines_are_bounded() {
        let mut report = Report::new(Path::new("a.obj"));
        for line in 1..=3 {
            report.once(Some(line), "`p` is left out");
        }
        for line in 0..5000 {
            report.broken(line, "odd");
        }
        let warnings = report.into_warnings();
        assert_eq!(warnings[0], "a.obj:1: `p` is left out (and 2 times more)");
        assert_eq!(warnings.len(), 2 + SHOWN_LINES as usize);
        assert_eq!(warnings.last().unwrap(), "a.obj: 4980 further lines are not understood");
        let mut report = Report::new(Path::new("a.obj"));
        (0..5000).for_each(|i| report.once(None, &format!("`{i}` is left out")));
        assert_eq!(report.into_warnings().len(), MOST_KINDS + 1);
    }
}
