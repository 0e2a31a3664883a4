//! How far long work has come. Like a log it has one listener for the whole program, as the work runs on many threads; without a
//! listener telling costs nothing and changes nothing.

use std::sync::OnceLock;
use std::sync::atomic::{AtomicUsize, Ordering};

/// What is told: the name of the stage, how much of it is done, and of how much; of 0 where nobody knows.
pub type Listener = fn(stage: &str, done: usize, of: usize);

static LISTENER: OnceLock<Listener> = OnceLock::new();

/// Sets the listener; a second one is not heard.
pub fn listen(listener: Listener) {
    // The first stays: a program has one terminal.
    let _ = LISTENER.set(listener);
}

/// Tells that a stage has begun whose length nobody knows.
pub fn stage(name: &str) {
    tell(name, 0, 0);
}

fn tell(name: &str, done: usize, of: usize) {
    if let Some(listener) = LISTENER.get() {
        listener(name, done, of);
    }
}

/// A stage of so many equal pieces, done in any order by any thread.
#[derive(Debug)]
pub struct Count {
    stage: &'static str,
    done: AtomicUsize,
    of: usize,
}

impl Count {
    /// Begins the stage.
    pub fn new(stage: &'static str, of: usize) -> Self {
        tell(stage, 0, of);
        Self { stage, done: AtomicUsize::new(0), of }
    }

    /// One piece is done.
    pub fn one(&self) {
        tell(self.stage, self.done.fetch_add(1, Ordering::Relaxed) + 1, self.of);
    }
}
