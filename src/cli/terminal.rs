//! What only a terminal gets: colour, width, progress. Files, pipes and `--quiet` get none of it.

use std::io::{self, IsTerminal, Write};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

use crate::progress;
use crate::report::html::Tone;
use crate::report::style::Style;

static QUIET: AtomicBool = AtomicBool::new(false);

/// Width where a terminal does not tell its own.
const WIDTH: usize = 80;
/// A line of progress is written no more often.
const PAUSE: Duration = Duration::from_millis(100);

/// Sets whether notes, warnings and progress are left out.
pub fn set_quiet(quiet: bool) {
    QUIET.store(quiet, Ordering::Relaxed);
}

/// How results are written to standard output.
pub fn style() -> Style {
    if !io::stdout().is_terminal() {
        return Style::PLAIN;
    }
    let set = |name: &str| std::env::var_os(name).is_some_and(|value| !value.is_empty());
    let dumb = std::env::var_os("TERM").is_some_and(|term| term == "dumb");
    let width = terminal_size::terminal_size().map_or(WIDTH, |(width, _)| usize::from(width.0));
    Style { colour: !set("NO_COLOR") && !dumb, width: Some(width) }
}

/// The first line of a page of text, its verdict, in the colour of its tone.
pub fn verdict(page: &str, tone: Tone) -> String {
    let (first, rest) = page.split_once('\n').unwrap_or((page, ""));
    format!("{}\n{rest}", style().painted(first, tone))
}

/// A line on standard error, unless the user asked for quiet.
pub fn note(line: std::fmt::Arguments<'_>) {
    if !QUIET.load(Ordering::Relaxed) {
        clear();
        // `eprintln!` would panic where standard error is closed.
        let _ = writeln!(io::stderr(), "{line}");
    }
}

/// Whether progress is shown: on a terminal, unless the user asked for quiet.
pub fn shows_progress() -> bool {
    io::stderr().is_terminal() && !QUIET.load(Ordering::Relaxed)
}

/// A line that is written over again.
struct Line {
    /// Before every stage, such as which record it is.
    prefix: String,
    stage: String,
    begun: Option<Instant>,
    shown: Option<Instant>,
}

static LINE: Mutex<Line> = Mutex::new(Line { prefix: String::new(), stage: String::new(), begun: None, shown: None });

/// Shows the progress of long work from here to the end of the program.
pub fn show_progress() {
    if shows_progress() {
        progress::listen(told);
    }
}

/// What stands before every stage from here on.
pub fn prefix(prefix: String) {
    LINE.lock().unwrap_or_else(PoisonError::into_inner).prefix = prefix;
}

fn told(stage: &str, done: usize, of: usize) {
    let mut line = LINE.lock().unwrap_or_else(PoisonError::into_inner);
    let now = Instant::now();
    if line.stage != stage || done == 0 {
        line.stage = stage.to_owned();
        line.begun = Some(now);
        line.shown = None;
    }
    if line.shown.is_some_and(|shown| now - shown < PAUSE) && done < of {
        return;
    }
    line.shown = Some(now);
    let spent = line.begun.map_or(0.0, |begun| (now - begun).as_secs_f64());
    // Nobody misses a line that could not be shown.
    let _ = write!(io::stderr(), "\r{}{}\x1b[K", line.prefix, progress_line(stage, done, of, spent));
}

/// Takes the line of progress away.
pub fn clear() {
    let mut line = LINE.lock().unwrap_or_else(PoisonError::into_inner);
    if line.shown.take().is_some() {
        let _ = write!(io::stderr(), "\r\x1b[K");
    }
}

/// A stage with its count and the time that is left of it, from what its pieces took so far.
fn progress_line(stage: &str, done: usize, of: usize, spent: f64) -> String {
    match (done, of) {
        (_, 0) => format!("{stage} ..."),
        (0, of) => format!("{stage}: 0 of {of}"),
        (done, of) => {
            let left = spent / done as f64 * of.saturating_sub(done) as f64;
            format!("{stage}: {done} of {of}, {left:.0} s left")
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_time_left_is_that_of_the_pieces_left() {
        assert_eq!(progress_line("intervals", 3, 12, 6.0), "intervals: 3 of 12, 18 s left");
        assert_eq!(progress_line("intervals", 0, 12, 0.0), "intervals: 0 of 12");
        assert_eq!(progress_line("fit", 0, 0, 3.0), "fit ...");
    }
}
