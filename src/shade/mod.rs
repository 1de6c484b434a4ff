//! shade
