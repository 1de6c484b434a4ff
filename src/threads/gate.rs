//! Where new workers wait until all are there.
//!
//! What they do first takes memory that the system wants to have or else ends the process: it notes what is to be done at the end of a thread. So memory is kept
//! back while they are started, which is when it runs out, and given back before the gate opens. If there is none by then, none of them goes through.

use crate::memory::{self, OutOfMemory, vec_of};
use std::sync::{Arc, Condvar, Mutex, PoisonError};

/// Kept back for a worker, and anyway. It is not touched.
const WORKER_BYTES: usize = 16 << 10;
const ANYWAY: usize = 256 << 10;

/// For who starts the workers.
pub(super) struct Gate {
    way: Arc<Way>,
    kept: Vec<u8>,
}

/// For a worker.
#[derive(Default)]
pub(super) struct Way {
    /// Whether those who wait go on; nobody knows at first.
    opened: Mutex<Option<bool>>,
    changed: Condvar,
}

impl Gate {
    /// For so many workers.
    ///
    /// # Errors
    /// No memory to keep back.
    pub fn new(workers: usize) -> Result<Self, OutOfMemory> {
        Ok(Self { way: Arc::default(), kept: vec_of(ANYWAY + workers * WORKER_BYTES)? })
    }

    pub fn way(&self) -> Arc<Way> {
        self.way.clone()
    }

    /// Lets the workers through.
    ///
    /// # Errors
    /// No memory: they have turned back.
    pub fn open(self) -> Result<(), OutOfMemory> {
        let bytes = self.kept.capacity();
        drop(self.kept);
        let is_there = memory::is_there(bytes);
        self.way.decide(is_there);
        if is_there { Ok(()) } else { Err(OutOfMemory { bytes }) }
    }

    /// Has them turn back.
    pub fn close(self) {
        self.way.decide(false);
    }
}

impl Way {
    fn decide(&self, open: bool) {
        *self.opened.lock().unwrap_or_else(PoisonError::into_inner) = Some(open);
        self.changed.notify_all();
    }

    /// Waits for the gate; whether it has opened.
    pub fn is_free(&self) -> bool {
        let opened = self.opened.lock().unwrap_or_else(PoisonError::into_inner);
        let opened = self.changed.wait_while(opened, |opened| opened.is_none());
        opened.unwrap_or_else(PoisonError::into_inner).unwrap_or(false)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn workers_wait_and_then_all_go_on_or_turn_back() {
        for open in [true, false] {
            let gate = Gate::new(3).expect("memory");
            let workers = [(); 3].map(|()| {
                let way = gate.way();
                std::thread::spawn(move || way.is_free())
            });
            if open {
                gate.open().expect("memory");
            } else {
                gate.close();
            }
            assert!(workers.into_iter().all(|worker| worker.join().is_ok_and(|free| free == open)));
        }
        assert!(Gate::new(1 << 48).is_err());
    }
}
