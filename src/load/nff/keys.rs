//! Key frames of AFF: the statement `k`.

use super::Aff;
use crate::load::LoadError;
use crate::load::input::lexer::{Lexer, show};
use crate::load::model::{
    KeyedTransform, PositionKey, PositionSpline, RotationKey, RotationSpline, Tcb, VisibilityKey,
};
use glam::DVec3;

impl Aff {
    /// `k name { transl N … rot N … scale N … visibility N … }`, after the `k`.
    pub fn key_frames(&mut self, lexer: &mut Lexer) -> Result<(), LoadError> {
        let name = lexer.name("the name of a transform")?.to_string();
        let first_line = lexer.line();
        lexer.expect("{")?;
        let mut keyed = KeyedTransform::default();
        loop {
            match lexer.word() {
                Some(b"}") => break,
                Some(b"transl") => {
                    let keys = self.position_keys(lexer, &name)?;
                    self.scene.counts.translation_keys += keys.len() as u64;
                    keyed.translation = Some(PositionSpline::new(&keys));
                }
                Some(b"scale") => {
                    let keys = self.position_keys(lexer, &name)?;
                    self.scene.counts.scale_keys += keys.len() as u64;
                    keyed.scale = Some(PositionSpline::new(&keys));
                }
                Some(b"rot") => {
                    let keys = self.rotation_keys(lexer, &name)?;
                    self.scene.counts.rotation_keys += keys.len() as u64;
                    keyed.rotation = Some(RotationSpline::new(&keys));
                }
                Some(b"visibility") => {
                    keyed.visibility = visibility_keys(lexer)?;
                    self.scene.counts.visibility_keys += keyed.visibility.len() as u64;
                }
                Some(word) => {
                    let found = show(word);
                    return Err(lexer
                        .error(format!("`transl`, `rot`, `scale`, `visibility` or `}}` expected, found `{found}`")));
                }
                None => {
                    let text =
                        format!("the file ends inside the key frames of `{name}` that begin on line {first_line}");
                    return Err(lexer.error(text));
                }
            }
        }
        // A part that is included more than once brings its key frames along each time.
        self.keys.insert(name, keyed);
        Ok(())
    }

    fn key_count(&self, lexer: &mut Lexer, name: &str) -> Result<usize, LoadError> {
        let count = lexer.count("the number of keys", u32::MAX)?;
        if count < 4 {
            return Err(lexer.error(format!("`{name}` has {count} keys, a spline needs at least 4")));
        }
        Ok(count as usize)
    }

    fn position_keys(&mut self, lexer: &mut Lexer, name: &str) -> Result<Vec<PositionKey>, LoadError> {
        let count = self.key_count(lexer, name)?;
        let mut keys: Vec<PositionKey> = Vec::with_capacity(count.min(lexer.words_left()));
        for _ in 0..count {
            let [time, x, y, z] = lexer.numbers("a key (time x y z tension continuity bias)")?;
            let tcb = tcb(lexer)?;
            self.note_time_order(lexer, name, keys.last().map(|k| k.time), time);
            keys.push(PositionKey { time, value: DVec3::new(x, y, z), tcb });
        }
        Ok(keys)
    }

    fn rotation_keys(&mut self, lexer: &mut Lexer, name: &str) -> Result<Vec<RotationKey>, LoadError> {
        let count = self.key_count(lexer, name)?;
        let mut keys: Vec<RotationKey> = Vec::with_capacity(count.min(lexer.words_left()));
        for _ in 0..count {
            let [time, x, y, z, degrees] = lexer.numbers("a key (time axis degrees tension continuity bias)")?;
            let tcb = tcb(lexer)?;
            let axis = DVec3::new(x, y, z);
            if axis.try_normalize().is_none() && degrees != 0.0 {
                return Err(lexer.error(format!("a rotation key of `{name}` has an axis without length")));
            }
            self.note_time_order(lexer, name, keys.last().map(|k| k.time), time);
            keys.push(RotationKey { time, axis, degrees, tcb });
        }
        Ok(keys)
    }

    fn note_time_order(&mut self, lexer: &Lexer, name: &str, before: Option<f64>, time: f64) {
        if before.is_some_and(|t| t > time) {
            let text = format!("a key of `{name}` goes back in time to {time}; keys are ignored until time goes on");
            self.scene.notes.push(lexer.error(text).to_string());
        }
    }
}

fn tcb(lexer: &mut Lexer) -> Result<Tcb, LoadError> {
    let [tension, continuity, bias] = lexer.numbers("tension, continuity and bias of a key")?;
    Ok(Tcb { tension, continuity, bias })
}

fn visibility_keys(lexer: &mut Lexer) -> Result<Vec<VisibilityKey>, LoadError> {
    let count = lexer.count("the number of keys", u32::MAX)? as usize;
    let mut keys: Vec<VisibilityKey> = Vec::with_capacity(count.min(lexer.words_left()));
    for _ in 0..count {
        let [time, on] = lexer.numbers("a key (time on)")?;
        if keys.last().is_some_and(|k| k.time > time) {
            return Err(lexer.error("visibility keys must not go back in time"));
        }
        keys.push(VisibilityKey { time, visible: on != 0.0 });
    }
    Ok(keys)
}
