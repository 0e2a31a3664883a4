//! What only a terminal gets: colour, width, progress. Files, pipes and `--quiet` get none of it.

use std::cell::RefCell;
use std::io::{self, IsTerminal, StdoutLock, Write};
use std::path::Path;
use std::process::{Command, Stdio};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

use crate::context::{Context, Progress};
use crate::files::is_kept;
use crate::report::style::Style;
use crate::report::style::Tone;
use crate::visible::visible_lines;

static QUIET: AtomicBool = AtomicBool::new(false);

thread_local! {
    /// Notes of the call that this thread carries out for another program; `None` in the command, whose notes go to standard error.
    static NOTES: RefCell<Option<Vec<String>>> = const { RefCell::new(None) };
}

/// Width where a terminal does not tell its own.
const WIDTH: usize = 80;
/// A line of progress is written no more often.
const PAUSE: Duration = Duration::from_millis(100);
/// Work that took longer says at its end what took how long.
const LONG: Duration = Duration::from_secs(2);
/// Share of the time from which on a stage is named.
const WORTH: f64 = 0.02;

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

/// Carries out `work`, and gives the notes that it makes on this thread.
pub fn gathering_notes<T>(work: impl FnOnce() -> T) -> (T, Vec<String>) {
    let before = NOTES.replace(Some(Vec::new()));
    let done = work();
    (done, NOTES.replace(before).unwrap_or_default())
}

/// Whether pages are opened once they are written.
static OPENING: AtomicBool = AtomicBool::new(false);

pub fn set_opening(opening: bool) {
    OPENING.store(opening, Ordering::Relaxed);
}

/// Opens a page that was written, where the user asked for that.
pub fn open_page(path: &Path) {
    if !OPENING.load(Ordering::Relaxed) {
        return;
    }
    let address = path.canonicalize().unwrap_or_else(|_| path.to_path_buf());
    if !opened(&address.to_string_lossy()) {
        note(format_args!("note: no browser could be opened; open {} in one", path.display()));
    }
}

/// Whether the system's own program for addresses could be started.
pub fn opened(address: &str) -> bool {
    let (program, before): (&str, &[&str]) = if cfg!(target_os = "macos") {
        ("open", &[])
    } else if cfg!(windows) {
        ("rundll32", &["url.dll,FileProtocolHandler"])
    } else {
        ("xdg-open", &[])
    };
    let mut command = Command::new(program);
    command.args(before).arg(address).stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::null());
    command.spawn().is_ok()
}

/// A line on standard error, unless the user asked for quiet; within [`gathering_notes`] one of its notes.
pub fn note(line: std::fmt::Arguments<'_>) {
    let gathered = NOTES.with_borrow_mut(|notes| {
        notes.as_mut().map(|notes| notes.push(visible_lines(&line.to_string()).into_owned())).is_some()
    });
    if gathered {
        return;
    }
    if !QUIET.load(Ordering::Relaxed) {
        clear();
        // `eprintln!` would panic where standard error is closed.
        let _ = writeln!(io::stderr(), "{}", visible_lines(&line.to_string()));
    }
}

/// Says on standard error that a file, or a folder of files, was written. A program that calls within its own knows where it asked for the file, and what
/// went to a device is not there to be opened.
pub fn written(path: &Path) {
    if (is_kept(path) || path.is_dir()) && NOTES.with_borrow(Option::is_none) {
        note(format_args!("written to {}", path.display()));
    }
}

/// Whether progress is shown: on a terminal, unless the user asked for quiet.
pub fn shows_progress() -> bool {
    io::stderr().is_terminal() && !QUIET.load(Ordering::Relaxed)
}

/// The standard output, for results: the line of progress goes before anything is written.
pub struct Output(StdoutLock<'static>);

impl Output {
    pub fn new() -> Self {
        Self(io::stdout().lock())
    }
}

impl Write for Output {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        clear();
        self.0.write(bytes)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.0.flush()
    }
}

/// A line that is written over again.
struct Line {
    /// Before every stage, such as which record it is.
    prefix: String,
    stage: String,
    begun: Option<Instant>,
    shown: Option<Instant>,
    /// Stages so far in their order, with the time spent in each.
    stages: Vec<(String, Duration)>,
}

static LINE: Mutex<Line> = Mutex::new(Line::NEW);

impl Line {
    const NEW: Self =
        Self { prefix: String::new(), stage: String::new(), begun: None, shown: None, stages: Vec::new() };

    /// Ends the stage that is shown.
    fn end_stage(&mut self, now: Instant) {
        let Some(begun) = self.begun.take() else { return };
        match self.stages.iter_mut().find(|(stage, _)| *stage == self.stage) {
            Some((_, spent)) => *spent += now - begun,
            None => self.stages.push((self.stage.clone(), now - begun)),
        }
    }
}

/// What the commands run in: a terminal gets their progress and what a first look shows; `first_look` keeps that for an interruption.
pub fn context(first_look: &FirstLook) -> Context {
    let (kept, begun) = (first_look.clone(), Instant::now());
    let hearing = Context::new().with_first_look(move |shows| {
        kept.keep(shows);
        if shows_progress() {
            note(format_args!("first look, after {:.1} s: {shows}", begun.elapsed().as_secs_f64()));
        }
    });
    if shows_progress() { hearing.with_progress(show) } else { hearing }
}

/// What a first look has shown last.
#[derive(Debug, Clone, Default)]
pub struct FirstLook(Arc<Mutex<Option<String>>>);

impl FirstLook {
    fn keep(&self, shows: &str) {
        *self.0.lock().unwrap_or_else(PoisonError::into_inner) = Some(shows.to_owned());
    }

    /// `None` where nothing has been seen yet.
    pub fn shown(&self) -> Option<String> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).clone()
    }
}

/// What stands before every stage from here on.
pub fn prefix(prefix: String) {
    LINE.lock().unwrap_or_else(PoisonError::into_inner).prefix = prefix;
}

fn show(progress: Progress<'_>) {
    let Progress { stage, done, of } = progress;
    let mut line = LINE.lock().unwrap_or_else(PoisonError::into_inner);
    let now = Instant::now();
    if line.stage != stage || done == 0 {
        line.end_stage(now);
        line.stage = stage.to_owned();
        line.begun = Some(now);
        line.shown = None;
    }
    if line.shown.is_some_and(|shown| now - shown < PAUSE) && of.is_some_and(|of| done < of) {
        return;
    }
    line.shown = Some(now);
    let spent = line.begun.map_or(0.0, |begun| (now - begun).as_secs_f64());
    // Nobody misses a line that could not be shown.
    let _ = write!(io::stderr(), "\r{}{}\x1b[K", line.prefix, progress_line(progress, spent));
}

/// Takes the line of progress away.
pub fn clear() {
    let mut line = LINE.lock().unwrap_or_else(PoisonError::into_inner);
    if line.shown.take().is_some() {
        let _ = write!(io::stderr(), "\r\x1b[K");
    }
}

/// Says what the stages of long work took, where its progress was shown.
pub fn say_what_took_long() {
    let mut line = LINE.lock().unwrap_or_else(PoisonError::into_inner);
    line.end_stage(Instant::now());
    let stages = std::mem::take(&mut line.stages);
    drop(line);
    if let Some(summary) = summary(&stages) {
        note(format_args!("{summary}"));
    }
}

/// What stages took that are worth a word; `None` where all together were short.
fn summary(stages: &[(String, Duration)]) -> Option<String> {
    let all: Duration = stages.iter().map(|(_, spent)| *spent).sum();
    if all < LONG {
        return None;
    }
    let worth = stages.iter().filter(|(_, spent)| spent.as_secs_f64() >= WORTH * all.as_secs_f64());
    let each: Vec<String> = worth.map(|(stage, spent)| format!("{stage} {:.1} s", spent.as_secs_f64())).collect();
    Some(format!("done in {:.1} s: {}", all.as_secs_f64(), each.join(", ")))
}

/// A stage with its count and the time that is left of it, from what its pieces took so far.
fn progress_line(progress: Progress<'_>, spent: f64) -> String {
    match progress.of {
        None => format!("{progress} ..."),
        Some(of) if progress.done > 0 => {
            let left = spent / progress.done as f64 * of.saturating_sub(progress.done) as f64;
            format!("{progress}, {left:.0} s left")
        }
        Some(_) => progress.to_string(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn long_work_says_which_stages_took_how_long() {
        let stage = |name: &str, ms| (name.to_owned(), Duration::from_millis(ms));
        assert_eq!(summary(&[stage("reading", 1900)]), None);
        let long = [stage("reading", 40), stage("fit", 3000), stage("intervals", 2000)];
        assert_eq!(summary(&long).unwrap(), "done in 5.0 s: fit 3.0 s, intervals 2.0 s");
    }

    #[test]
    fn the_time_left_is_that_of_the_pieces_left() {
        let of_12 = |done| Progress { stage: "intervals", done, of: Some(12) };
        assert_eq!(progress_line(of_12(3), 6.0), "intervals: 3 of 12, 18 s left");
        assert_eq!(progress_line(of_12(0), 0.0), "intervals: 0 of 12");
        assert_eq!(progress_line(Progress { stage: "fit", done: 0, of: None }, 3.0), "fit ...");
    }
}
