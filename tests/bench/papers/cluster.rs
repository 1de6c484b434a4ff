//! A cluster simulated from tile times that were measured on one processor.
//!
//! *Processors* pull tiles in turn, each the next when it has done its last. A frame is ready when the last tile is, after every client has brought its
//! structures up to date, which no number of clients makes shorter (Larsson03, equation 1).
//!
//! *The network* is that of Wald03, in proportion: its table 4 tells what its server sustained. Where the museum's changes fill the network, frames per
//! second times clients times bytes per client is [`OUT`] (16 clients, 2.5 frames of 409 kB); where pixels do, [`IN`] (26 frames of 640×480×3 bytes). Both
//! are multiplied by how much faster our processors are than theirs. By *unicast* each client is sent all that changed; by *broadcast* it leaves the server
//! once. Work and network overlap, as frames follow one another.

/// Bytes per second that the paper's server sent to all clients, and that it received.
const OUT: f64 = 16.4e6;
const IN: f64 = 24e6;
/// Processors of a client.
pub const DUAL: usize = 2;
/// Bytes of a picture, whose size is the paper's whatever was measured: a quarter of the pixels takes a quarter of both times.
const PICTURE: f64 = 640.0 * 480.0 * 3.0;

/// What one frame costs.
#[derive(Clone, Debug)]
pub struct Work {
    /// Seconds to bring the structures up to date, on one client.
    pub update: f64,
    /// Seconds of each tile on one processor.
    pub tiles: Vec<f64>,
    /// Bytes that a client has to be sent.
    pub bytes: f64,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Sending {
    Unicast,
    Broadcast,
}

impl Work {
    /// Seconds until the last tile is done.
    pub fn seconds(&self, processors: usize) -> f64 {
        let mut free_at = vec![0.0f64; processors];
        for tile in &self.tiles {
            let next = free_at.iter_mut().min_by(|a, b| a.total_cmp(b)).expect("there is a processor");
            *next += tile;
        }
        self.update + free_at.into_iter().fold(0.0, f64::max)
    }

    /// Frames per second of so many clients whose processors and network are `faster` than the paper's.
    pub fn rate(&self, clients: usize, sending: Sending, faster: f64) -> f64 {
        let computing = self.seconds(clients * DUAL);
        let times = match sending {
            Sending::Unicast => clients as f64,
            Sending::Broadcast => 1.0,
        };
        let out = self.bytes * times / (OUT * faster);
        (1.0 / computing.max(out)).min(pictures(faster))
    }
}

/// Pictures per second that the server can take in.
pub fn pictures(faster: f64) -> f64 {
    IN * faster / PICTURE
}
