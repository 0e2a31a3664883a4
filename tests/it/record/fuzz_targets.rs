//! The fuzz targets under a mutator of our own: a short run always, a million with `FUZZ=1000000 cargo test --release --test
//! fuzz_targets -- --ignored`. `cargo fuzz` runs the same targets guided by coverage.

#[path = "../../../fuzz/targets.rs"]
mod targets;

use std::fs;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::time::{Duration, Instant};

use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};
use targets::{TARGETS, Target};

/// One input may not take longer.
const SLOWEST: Duration = Duration::from_secs(20);
/// Longer inputs are cut to so many bytes, at any place.
const LONGEST: usize = 6_000;
/// What breaks readers.
const TOKENS: &[&[u8]] = &[
    b"\0\0\0\0\0\0\0\0",
    b"\xFF\xFF\xFF\xFF\xFF\xFF\xFF\xFF",
    b"\x01\0\0\0",
    b"\0\0\0\x80",
    b"\xFF\xFF\xFF\x7F",
    b"NaN",
    b"-inf",
    b"1e999",
    b"\"",
    b",",
    b";",
    b"\n",
    b"\r",
    b"[",
    b"]",
    b"{",
    b"}",
    b"(",
    b")",
    b" = ",
    b"+-",
    b"^",
    b"##DG",
    b"##DL",
    b"##DZ",
    b"TDSm",
    b"\x69\x12\0\0",
    b"\x0E\0\0\0",
    b"\x0F\0\0\0",
    b"time [s]",
    b"-1",
    b"0",
];

struct Mutator {
    random: ChaCha8Rng,
}

impl Mutator {
    fn below(&mut self, end: usize) -> usize {
        (self.random.next_u64() % end.max(1) as u64) as usize
    }

    /// A part of a text, or of a packed file as a whole.
    fn start(&mut self, corpus: &[Vec<u8>]) -> Vec<u8> {
        let index = self.below(corpus.len());
        let mut bytes = corpus[index].clone();
        if self.below(4) == 0 {
            bytes.truncate(self.below(LONGEST));
        }
        bytes
    }

    fn mutate(&mut self, corpus: &[Vec<u8>]) -> Vec<u8> {
        let mut bytes = self.start(corpus);
        for _ in 0..=self.below(6) {
            let at = self.below(bytes.len());
            let length = self.below(16).min(bytes.len() - at.min(bytes.len()));
            match self.below(7) {
                0 if !bytes.is_empty() => bytes[at] ^= 1 << self.below(8),
                1 if !bytes.is_empty() => bytes[at] = self.random.next_u32() as u8,
                2 => drop(bytes.drain(at..at + length)),
                3 => {
                    let again = bytes[at..at + length].to_vec();
                    bytes.splice(at..at, again);
                }
                4 => {
                    let token = TOKENS[self.below(TOKENS.len())];
                    bytes.splice(at..at, token.iter().copied());
                }
                5 => {
                    let token = TOKENS[self.below(TOKENS.len())];
                    let end = (at + token.len()).min(bytes.len());
                    bytes.splice(at..end, token.iter().copied());
                }
                _ => {
                    let index = self.below(corpus.len());
                    let other = &corpus[index];
                    let from = self.below(other.len());
                    let to = (from + self.below(64)).min(other.len());
                    bytes.splice(at..at, other[from..to].iter().copied());
                }
            }
        }
        bytes
    }
}

/// Runs a target on so many mutated inputs; gives how many of them, unlike those that it cannot read, were not empty.
fn fuzz(target: &Target, executions: u64) {
    let corpus: Vec<Vec<u8>> = target.corpus.iter().map(|name| fs::read(format!("fixtures/{name}")).unwrap()).collect();
    for bytes in &corpus {
        (target.run)(bytes);
    }
    let mut mutator = Mutator { random: ChaCha8Rng::seed_from_u64(7) };
    for number in 0..executions {
        let bytes = mutator.mutate(&corpus);
        let begun = Instant::now();
        if catch_unwind(AssertUnwindSafe(|| (target.run)(&bytes))).is_err() {
            panic!("{} fails in execution {number} on {} bytes:\n{}", target.name, bytes.len(), bytes.escape_ascii());
        }
        let taken = begun.elapsed();
        assert!(taken < SLOWEST, "{} takes {taken:?} in execution {number}", target.name);
    }
    println!("{}: {executions} executions without a finding", target.name);
}

#[test]
fn no_reader_fails_on_damaged_input() {
    for target in TARGETS {
        fuzz(target, 300);
    }
}

/// What takes minutes to hours.
mod studies {
    use super::*;

    /// `FUZZ` is the number of executions, `TARGET` picks one.
    #[test]
    #[ignore = "takes minutes to hours"]
    fn no_reader_fails_in_a_million_executions() {
        let executions = crate::support::study::number("FUZZ", 1_000_000);
        let picked = std::env::var("TARGET").ok();
        for target in TARGETS.iter().filter(|target| picked.as_deref().is_none_or(|name| name == target.name)) {
            fuzz(target, executions);
        }
    }
}
