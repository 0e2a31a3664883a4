//! Random numbers by name: what a number is for decides its stream, so that nothing depends on order or threads.

use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};
use rand_distr::{Distribution, StandardNormal};

/// Draws that one rig or case may take before the next one's streams begin.
const DRAWS: u64 = 1 << 16;
const RIGS: u64 = 1 << 60;
const CASES: u64 = 1 << 61;

/// What a stream of random numbers is for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Purpose {
    /// Which case has how many faults.
    Plan,
    /// A disturbed rig and its healthy records: its number, and which draw of it.
    Rig(usize, usize),
    /// A case: its number, and which draw of it.
    Case(usize, usize),
}

/// A stream of random numbers.
pub struct Stream(ChaCha8Rng);

impl Stream {
    /// The stream of a campaign's seed for one purpose, independent of all others.
    pub fn of(seed: u64, purpose: Purpose) -> Self {
        let stream = match purpose {
            Purpose::Plan => 0,
            Purpose::Rig(rig, draw) => RIGS + rig as u64 * DRAWS + draw as u64,
            Purpose::Case(case, draw) => CASES + case as u64 * DRAWS + draw as u64,
        };
        Self::numbered(seed, stream)
    }

    /// A stream of a seed by its number.
    pub fn numbered(seed: u64, stream: u64) -> Self {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        random.set_stream(stream);
        Self(random)
    }

    /// A seed for further streams.
    pub fn seed(&mut self) -> u64 {
        self.0.next_u64()
    }

    /// Uniform from `low` to `high`, the latter excluded.
    pub fn uniform(&mut self, low: f64, high: f64) -> f64 {
        // 53 bits fill the fraction of a double.
        let share = (self.0.next_u64() >> 11) as f64 / (1u64 << 53) as f64;
        low + share * (high - low)
    }

    /// Standard normal.
    pub fn normal(&mut self) -> f64 {
        StandardNormal.sample(&mut self.0)
    }

    /// One of `0..count`, each as likely as the others to 2^-53; `count` above 0.
    pub fn index(&mut self, count: usize) -> usize {
        (self.uniform(0.0, count as f64) as usize).min(count.saturating_sub(1))
    }

    /// A random order (Fisher and Yates).
    pub fn shuffle<T>(&mut self, items: &mut [T]) {
        for last in (1..items.len()).rev() {
            items.swap(last, self.index(last + 1));
        }
    }
}
