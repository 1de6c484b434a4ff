//! In place of `loaded_scenes` in a library without the readers of scene files: there are no loaded scenes, and asking
//! for one says why.

use super::load::{Doubles, Integers, Parts, Text};
use super::types::RTuint;
use crate::api::{Context, Error, Result};
use std::ffi::CStr;

/// The library reads scene files.
pub(super) const READERS: bool = false;

#[derive(Default)]
pub(super) struct LoadedScenes {}

/// There is none.
pub(super) enum Entry {}

impl LoadedScenes {
    pub fn load(&mut self, _: &mut Context, _: &str, _: Parts) -> Result<RTuint> {
        let text = "rtLoadScene: this library was built without the readers of scene files (cargo feature `load`)";
        Err(Error::invalid_operation(text))
    }

    pub fn get(&mut self, name: RTuint) -> Result<&mut Entry> {
        Err(Error::invalid_value(format!("there is no loaded scene {name}")))
    }

    pub fn delete(&mut self, _: &mut Context, name: RTuint) -> Result<()> {
        if name == 0 { Ok(()) } else { self.get(name).map(|_| ()) }
    }
}

impl Entry {
    pub fn instantiate(&mut self, _: &mut Context, _: f64, _: Parts) -> Result<()> {
        match *self {}
    }

    pub fn integer(&self, _: Integers) -> usize {
        match *self {}
    }

    pub fn doubles(&self, _: Doubles) -> Vec<f64> {
        match *self {}
    }

    pub fn text(&self, _: Text, _: RTuint) -> Option<&CStr> {
        match *self {}
    }
}
