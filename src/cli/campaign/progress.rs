//! How far a campaign is.

use std::io::{self, Write};
use std::time::Instant;

use crate::campaign::{Outcome, Row};
use crate::cli::terminal;

/// One line on a terminal, written over again.
pub struct Progress {
    shown: bool,
    begin: Instant,
    done: usize,
    before: usize,
    all: usize,
    healthy: usize,
    false_alarms: usize,
}

impl Progress {
    pub fn new(before: &[Row], todo: usize) -> Self {
        let mut progress = Self {
            shown: terminal::shows_progress(),
            begin: Instant::now(),
            done: 0,
            before: before.len(),
            all: before.len() + todo,
            healthy: 0,
            false_alarms: 0,
        };
        before.iter().for_each(|row| progress.count(row));
        progress
    }

    fn count(&mut self, row: &Row) {
        if !row.is_faulty() {
            self.healthy += 1;
            self.false_alarms += usize::from(row.outcome != Outcome::Healthy);
        }
    }

    pub fn show(&mut self, row: &Row) {
        self.done += 1;
        self.count(row);
        if !self.shown {
            return;
        }
        let finished = self.before + self.done;
        let left = self.begin.elapsed().as_secs_f64() / self.done as f64 * (self.all - finished) as f64;
        let Self { all, healthy, false_alarms, .. } = self;
        // Nobody misses a line that could not be shown.
        let _ = write!(
            io::stderr(),
            "\r{finished} of {all} cases, {false_alarms} false alarms in {healthy} healthy ones, {left:.0} s left \x1b[K"
        );
    }

    pub fn end(&self) {
        if self.shown && self.done > 0 {
            let _ = writeln!(io::stderr());
        }
    }
}
