//! Threads that share a list of work.

use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::mpsc;

use super::Context;
use crate::complaint::Complaint;

/// Does a list of work on so many threads, begun in its order; `done` gets each row as it comes, and may end the work by an error.
/// A piece of work without a row, `None`, only prepares others.
///
/// # Errors
/// What `done` gave, or a context that was cancelled; rows that came before are whole.
pub(crate) fn work_off<W: Sync, R: Send>(
    work: &[W],
    threads: usize,
    context: &Context,
    each: impl Fn(&W) -> Option<R> + Sync,
    mut done: impl FnMut(R) -> Result<(), Complaint>,
) -> Result<(), Complaint> {
    let (next, stop) = (AtomicUsize::new(0), AtomicBool::new(false));
    let (give, take) = mpsc::channel();
    std::thread::scope(|scope| {
        for _ in 0..threads.clamp(1, work.len().max(1)) {
            let (give, next, stop, each) = (give.clone(), &next, &stop, &each);
            scope.spawn(move || {
                while !stop.load(Ordering::Relaxed) && !context.is_cancelled() {
                    let Some(one) = work.get(next.fetch_add(1, Ordering::Relaxed)) else { return };
                    let Some(row) = each(one) else { continue };
                    // What was cut short is not what failed.
                    if context.is_cancelled() || give.send(row).is_err() {
                        return;
                    }
                }
            });
        }
        drop(give);
        for row in take {
            if let Err(complaint) = done(row) {
                stop.store(true, Ordering::Relaxed);
                return Err(complaint);
            }
        }
        context.check().map_err(Complaint::from)
    })
}
