//! Files as the readers see them: bounded, from the scene's own folders, as lines or as words with line numbers.

pub mod files;
pub mod lexer;
pub mod lines;
