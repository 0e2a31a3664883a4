//! How far work of many pieces is.

use std::fmt;
use std::io::{self, Write};
use std::time::Instant;

use super::terminal;

/// One line on a terminal, written over again.
pub struct Progress {
    shown: bool,
    begin: Instant,
    done: usize,
    before: usize,
    all: usize,
    /// What the pieces are, such as `cases`.
    pieces: &'static str,
}

impl Progress {
    /// Of work of which `before` pieces are done and `todo` are not.
    pub fn new(pieces: &'static str, before: usize, todo: usize) -> Self {
        Self { shown: terminal::shows_progress(), begin: Instant::now(), done: 0, before, all: before + todo, pieces }
    }

    /// Counts a piece that is done now, and says so with what is found.
    pub fn show(&mut self, found: fmt::Arguments<'_>) {
        self.done += 1;
        if !self.shown {
            return;
        }
        let finished = self.before + self.done;
        let left = self.begin.elapsed().as_secs_f64() / self.done as f64 * (self.all - finished) as f64;
        let Self { all, pieces, .. } = self;
        // Nobody misses a line that could not be shown.
        let _ = write!(io::stderr(), "\r{finished} of {all} {pieces}, {found}, {left:.0} s left \x1b[K");
    }

    /// Leaves the line.
    pub fn end(&self) {
        if self.shown && self.done > 0 {
            let _ = writeln!(io::stderr());
        }
    }
}
