//! What the threads of a pool work in, kept from one piece of work to the next: a desk for each.
//!
//! A thread takes a desk from its place and puts it back when it is done. So nobody waits for another, also if a thread were to begin
//! something in the middle of what it does (as one that waits inside rayon may): that would take another's desk.

use crate::memory::{OutOfMemory, Room, boxed};
use std::sync::{Mutex, PoisonError};

/// See the module head.
#[derive(Debug)]
pub struct Desks<T> {
    places: Vec<Mutex<Option<Box<T>>>>,
}

impl<T> Default for Desks<T> {
    fn default() -> Self {
        Self { places: Vec::new() }
    }
}

impl<T: Default> Desks<T> {
    /// Makes as many desks as threads of the pool that calls can use at a time, which is no more than `most`, and has `ready` prepare each.
    ///
    /// # Errors
    /// No memory.
    pub fn prepare(
        &mut self,
        most: usize,
        mut ready: impl FnMut(&mut T) -> Result<(), OutOfMemory>,
    ) -> Result<(), OutOfMemory> {
        let wanted = rayon::current_num_threads().min(most);
        self.places.truncate(wanted);
        self.places.room(wanted - self.places.len())?;
        self.places.resize_with(wanted, Mutex::default);
        for place in &mut self.places {
            let desk = match place.get_mut().unwrap_or_else(PoisonError::into_inner) {
                Some(desk) => desk,
                none => none.insert(boxed(T::default())?),
            };
            ready(desk)?;
        }
        Ok(())
    }

    /// Does something at a desk. One that is missing is made: no more than were prepared are needed at a time.
    pub fn at_one<R>(&self, work: impl FnOnce(&mut T) -> R) -> R {
        let count = self.places.len();
        let own = rayon::current_thread_index().unwrap_or(0) % count.max(1);
        let lock = |at: usize| self.places[at].lock().unwrap_or_else(PoisonError::into_inner);
        let taken = (own..count).chain(0..own).find_map(|at| lock(at).take().map(|desk| (at, desk)));
        let (at, mut desk) = match taken {
            Some((at, desk)) => (Some(at), desk),
            None => (None, Box::default()),
        };
        let result = work(&mut desk);
        if let Some(at) = at {
            *lock(at) = Some(desk);
        }
        result
    }

    /// Sum over the desks, none of which is in use.
    pub fn sum(&self, of: impl Fn(&T) -> usize) -> usize {
        let one =
            |place: &Mutex<Option<Box<T>>>| place.lock().unwrap_or_else(PoisonError::into_inner).as_deref().map(&of);
        self.places.iter().filter_map(one).sum()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn who_begins_something_else_in_the_middle_has_another_desk() {
        let mut desks = Desks::<[u8; 8]>::default();
        let place = |desk: &mut [u8; 8]| (&raw mut *desk).addr();
        assert_ne!(desks.at_one(place), 0, "without any");
        desks.prepare(1, |_| Ok(())).expect("memory");
        let (first, second) = desks.at_one(|outer| (place(outer), desks.at_one(place)));
        assert_ne!(first, second);
        assert_eq!(desks.at_one(place), first, "and then the same again");
        assert_eq!(desks.sum(|desk| desk.len()), 8);
    }
}
