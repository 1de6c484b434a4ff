//! Files as the readers see them: bounded, from the scene's own folders, as words with line numbers.

pub mod files;
pub mod lexer;
