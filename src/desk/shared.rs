//! The desk as its threads share it.

use std::sync::atomic::AtomicUsize;
use std::sync::{Condvar, Mutex, MutexGuard, PoisonError, TryLockError};
use std::time::{Duration, Instant};

use super::state::Desk;

/// The desk as the threads of its server see it.
#[derive(Debug)]
pub struct Shared {
    desk: Mutex<Desk>,
    changed: Condvar,
    /// When a tab was last heard of; `None` before the first.
    heard: Mutex<Option<Instant>>,
    /// Requests that are being answered.
    pub(super) busy: AtomicUsize,
}

impl Shared {
    /// A desk that no tab has asked for yet.
    pub fn new(desk: Desk) -> Self {
        let (changed, heard, busy) = (Condvar::new(), Mutex::new(None), AtomicUsize::new(0));
        Self { desk: Mutex::new(desk), changed, heard, busy }
    }

    pub fn desk(&self) -> MutexGuard<'_, Desk> {
        self.desk.lock().unwrap_or_else(PoisonError::into_inner)
    }

    pub fn try_desk(&self) -> Option<MutexGuard<'_, Desk>> {
        match self.desk.try_lock() {
            Ok(desk) => Some(desk),
            Err(TryLockError::Poisoned(poisoned)) => Some(poisoned.into_inner()),
            Err(TryLockError::WouldBlock) => None,
        }
    }

    /// Tells the tabs that something has changed.
    pub fn tell(&self) {
        self.changed.notify_all();
    }

    /// The desk as soon as it is at another revision than this one, or after so long.
    pub fn desk_after(&self, revision: Option<u64>, most: Duration) -> MutexGuard<'_, Desk> {
        let old = |desk: &mut Desk| revision == Some(desk.revision);
        let waited = self.changed.wait_timeout_while(self.desk(), most, old);
        waited.map_or_else(|poisoned| poisoned.into_inner().0, |(desk, _)| desk)
    }

    /// Notes that a tab was heard of.
    pub fn hear(&self) {
        *self.heard.lock().unwrap_or_else(PoisonError::into_inner) = Some(Instant::now());
    }

    /// Whether a tab was heard of, but none for so long.
    pub fn is_left_for(&self, time: Duration) -> bool {
        let heard = *self.heard.lock().unwrap_or_else(PoisonError::into_inner);
        heard.is_some_and(|heard| heard.elapsed() > time)
    }
}
