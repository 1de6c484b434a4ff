//! The loaded scenes of a context by name, with the texts that C programs are handed. A library without the readers
//! has `no_scenes` in place of this file.

use super::guard::c_text;
use super::load::{Doubles, Integers, Parts, Text};
use super::types::RTuint;
use crate::api::{Context, Error, ErrorCode, Result};
use crate::load::{self, LoadedScene};
use crate::memory;
use std::collections::BTreeMap;
use std::ffi::{CStr, CString};

/// The library reads scene files.
pub(super) const READERS: bool = true;

/// The reserve of a reader: for each byte of the file, and anyway. It is not touched while the system has memory.
const READER_SHARE: usize = 16;
const READER_BYTES: usize = 4 << 20;

#[derive(Default)]
pub(super) struct LoadedScenes {
    last: RTuint,
    scenes: BTreeMap<RTuint, Entry>,
}

pub(super) struct Entry {
    scene: LoadedScene,
    format: CString,
    warnings: Vec<CString>,
    object_names: Vec<CString>,
}

fn of_library(Parts { instances, lights, camera, background }: Parts) -> load::Parts {
    load::Parts { instances, lights, camera, background }
}

impl LoadedScenes {
    pub fn load(&mut self, context: &mut Context, file: &str, parts: Parts) -> Result<RTuint> {
        let name = self.last.checked_add(1).ok_or_else(Error::out_of_memory)?;
        // The readers do not ask for memory.
        let size = std::fs::metadata(file).map_or(0, |about| usize::try_from(about.len()).unwrap_or(usize::MAX));
        let reserve = size.saturating_mul(READER_SHARE).saturating_add(READER_BYTES);
        let read = memory::behind(reserve, || load::read(file))?;
        let read = read.map_err(|e| Error::new(ErrorCode::Io, e.to_string()))?;
        let start = read.animation.map_or(0.0, |a| a.start);
        let mut scene = LoadedScene::define(context, read)?;
        let parts = of_library(parts);
        if parts != load::Parts::NONE
            && let Err(error) = scene.instantiate(context, start, parts)
        {
            // The first error counts.
            let _ = scene.delete(context);
            return Err(error);
        }
        let file = scene.file();
        let entry = Entry {
            format: c_text(file.format),
            warnings: file.warnings.iter().map(|w| c_text(w)).collect(),
            object_names: file.objects.iter().map(|o| c_text(&o.name)).collect(),
            scene,
        };
        self.scenes.insert(name, entry);
        self.last = name;
        Ok(name)
    }

    pub fn get(&mut self, name: RTuint) -> Result<&mut Entry> {
        self.scenes.get_mut(&name).ok_or_else(|| Error::invalid_value(format!("there is no loaded scene {name}")))
    }

    pub fn delete(&mut self, context: &mut Context, name: RTuint) -> Result<()> {
        if name == 0 {
            return Ok(());
        }
        self.get(name)?.scene.delete(context)?;
        self.scenes.remove(&name);
        Ok(())
    }
}

impl Entry {
    pub fn instantiate(&mut self, context: &mut Context, time: f64, parts: Parts) -> Result<()> {
        self.scene.instantiate(context, time, of_library(parts))
    }

    pub fn integer(&self, question: Integers) -> usize {
        let file = self.scene.file();
        match question {
            Integers::FirstObject => self.scene.objects().next().map_or(0, |name| name as usize),
            Integers::Objects => file.objects.len(),
            Integers::Triangles => file.objects.iter().map(|o| o.mesh.triangles.len()).sum(),
            Integers::Lights => file.lights.len(),
            Integers::Cameras => file.cameras.len(),
            Integers::Frames => file.animation.map_or(0, |a| a.frames as usize),
            Integers::Warnings => self.warnings.len(),
            Integers::Srgb => usize::from(file.srgb),
        }
    }

    pub fn doubles(&self, question: Doubles) -> Vec<f64> {
        let file = self.scene.file();
        let times = file.animation.map_or([0.0; 2], |a| [a.start, a.end]);
        match question {
            Doubles::Times => times.to_vec(),
            Doubles::Bounds => match file.bounds(times[0]) {
                Some((low, high)) => low.to_array().into_iter().chain(high.to_array()).map(f64::from).collect(),
                None => vec![0.0; 6],
            },
        }
    }

    pub fn text(&self, question: Text, index: RTuint) -> Option<&CStr> {
        let index = index as usize;
        match question {
            Text::Warning => self.warnings.get(index).map(CString::as_c_str),
            Text::ObjectName => self.object_names.get(index).map(CString::as_c_str),
            Text::Format => (index == 0).then_some(&*self.format),
        }
    }
}
