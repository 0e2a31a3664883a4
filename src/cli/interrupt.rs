//! Ctrl-C and SIGTERM: the verb is cancelled and the program ends with 130, as a shell expects, and leaves nothing half-written.

use std::io::{self, Write};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use super::terminal::{self, FirstLook};
use crate::context::Context;
use crate::visible::visible_lines;

/// 128 and the number of SIGINT.
const STATUS: u8 = 130;

/// Who ends the program: the verb that was cancelled, or whoever waited for it in vain. The first one to ask does.
#[derive(Debug, Clone, Default)]
pub struct Ending {
    asked: Arc<AtomicBool>,
    first_look: FirstLook,
}

impl Ending {
    /// Whether nobody else ends the program already.
    fn is_mine(&self) -> bool {
        !self.asked.swap(true, Ordering::SeqCst)
    }

    /// Ends a verb that was cancelled.
    pub fn interrupted(&self) -> u8 {
        if !self.is_mine() {
            // The other thread is about to end the program.
            loop {
                std::thread::park();
            }
        }
        self.say();
        STATUS
    }

    /// Says so, with what was seen before.
    fn say(&self) {
        terminal::clear();
        // `eprintln!` would panic where standard error is closed.
        let say = |line: &str| drop(writeln!(io::stderr(), "{line}"));
        if let Some(shown) = self.first_look.shown() {
            say(&visible_lines(&format!("first look: {shown}")));
        }
        say("interrupted");
    }
}

/// Cancels `context` at the first signal. A verb that does not end by itself soon, such as one that waits for a pipe, is ended;
/// a second signal ends it at once.
#[cfg(unix)]
pub fn watch(context: &Context, first_look: FirstLook) -> Ending {
    use std::time::Duration;

    use signal_hook::consts::{SIGINT, SIGTERM};
    use signal_hook::iterator::Signals;

    use crate::files::remove_unfinished;

    /// What a verb may take to end by itself: with what ending the program takes, all is over within 0.2 s.
    const GRACE: Duration = Duration::from_millis(120);

    let ending = Ending { first_look, ..Ending::default() };
    // Where signals cannot be had, the system ends the program.
    let Ok(mut signals) = Signals::new([SIGINT, SIGTERM]) else { return ending };
    let (context, theirs) = (context.clone(), ending.clone());
    std::thread::spawn(move || {
        let mut signals = signals.forever();
        signals.next();
        context.cancel();
        let ending = theirs.clone();
        std::thread::spawn(move || {
            std::thread::sleep(GRACE);
            if ending.is_mine() {
                remove_unfinished();
                ending.say();
                std::process::exit(STATUS.into());
            }
        });
        signals.next();
        remove_unfinished();
        std::process::exit(STATUS.into());
    });
    ending
}

/// The system ends the program.
#[cfg(not(unix))]
pub fn watch(_context: &Context, first_look: FirstLook) -> Ending {
    Ending { first_look, ..Ending::default() }
}
