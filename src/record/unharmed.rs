//! What libraries read that may panic at damaged files.

use std::panic::{self, AssertUnwindSafe};
use std::sync::{Mutex, PoisonError};

/// What is read; none where the library panics, with words of its own that are kept silent.
pub(crate) fn unharmed<T>(read: impl FnOnce() -> T) -> Option<T> {
    // The hook is that of the whole program, so one reader at a time changes it.
    static ONE: Mutex<()> = Mutex::new(());
    let _one = ONE.lock().unwrap_or_else(PoisonError::into_inner);
    let hook = panic::take_hook();
    panic::set_hook(Box::new(|_| {}));
    let read = panic::catch_unwind(AssertUnwindSafe(read));
    panic::set_hook(hook);
    read.ok()
}
