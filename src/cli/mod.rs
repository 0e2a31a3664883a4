//! The command line: one file per verb.
//!
//! Results go to standard output, messages to standard error. Exit status: 0 done, 1 something was found (on request),
//! 2 could not run, 130 interrupted by Ctrl-C or SIGTERM.

mod add;
mod calibrate;
mod campaign;
mod check;
mod compare;
mod completions;
mod components;
mod desk;
mod diagnose;
mod diagnose_arguments;
mod effects;
mod example;
mod export;
mod fleet;
mod history;
mod improve;
mod init;
mod interrupt;
mod isolability;
mod keep;
mod man;
mod manifest;
mod progress;
mod read;
#[cfg(feature = "internals")]
pub mod schemas;
mod simulate;
mod suggest;
mod terminal;
mod windows;

use std::ffi::OsString;
use std::io::{self, Write};
use std::path::Path;

use clap::{Args, CommandFactory, FromArgMatches, Parser, Subcommand, ValueEnum};

use crate::complaint::{Complaint, Kind};
use crate::context::{Context, Interrupted};
use crate::files::{Outputs, is_closed_pipe, write_atomically};
use crate::report::brief::wrapped;
use crate::visible::Visible;
use terminal::FirstLook;

/// Diagnose hydraulic circuits from records: which faults, how large, how probable.
#[derive(Debug, Parser)]
#[command(name = "borescope", version, max_term_width = 80)]
struct CommandLine {
    /// Nothing on standard error but errors: no notes, no warnings, no progress
    #[arg(short, long, global = true)]
    quiet: bool,
    /// Open the page that `--report` writes
    #[arg(long, global = true)]
    open: bool,
    /// Threads; without it as many as the machine has. Results do not depend on it
    #[arg(long, value_name = "T", global = true)]
    threads: Option<usize>,
    #[command(subcommand)]
    verb: Verb,
}

/// A new verb is a line here, a line in [`Verb::run`] and a file.
#[derive(Debug, Subcommand)]
enum Verb {
    Add(add::Arguments),
    Calibrate(calibrate::Arguments),
    Campaign(campaign::Arguments),
    Check(check::Arguments),
    Compare(compare::Arguments),
    Completions(completions::Arguments),
    Components(components::Arguments),
    Desk(desk::Arguments),
    Diagnose(diagnose_arguments::Arguments),
    Effects(effects::Arguments),
    Example(example::Arguments),
    Export(export::Arguments),
    Fleet(fleet::Arguments),
    History(history::Arguments),
    Improve(improve::Arguments),
    Init(init::Arguments),
    Isolability(isolability::Arguments),
    Man(man::Arguments),
    Simulate(simulate::Arguments),
    Suggest(suggest::Arguments),
}

impl Verb {
    fn run(&self, context: &Context, out: &mut dyn Write) -> Result<Status, Failure> {
        match self {
            Self::Add(arguments) => add::run(arguments, context, out),
            Self::Calibrate(arguments) => calibrate::run(arguments, context, out),
            Self::Campaign(arguments) => campaign::run(arguments, context, out),
            Self::Check(arguments) => check::run(arguments, context, out),
            Self::Compare(arguments) => compare::run(arguments, context, out),
            Self::Completions(arguments) => completions::run(arguments, out),
            Self::Components(arguments) => components::run(arguments, out),
            Self::Desk(arguments) => desk::run(arguments, context, out),
            Self::Diagnose(arguments) => diagnose::run(arguments, context, out),
            Self::Effects(arguments) => effects::run(arguments, out),
            Self::Example(arguments) => example::run(arguments, context, out),
            Self::Export(arguments) => export::run(arguments, out),
            Self::Fleet(arguments) => fleet::run(arguments, out),
            Self::History(arguments) => history::run(arguments, context, out),
            Self::Improve(arguments) => improve::run(arguments, context, out),
            Self::Init(arguments) => init::run(arguments, context, out),
            Self::Isolability(arguments) => isolability::run(arguments, context, out),
            Self::Man(arguments) => man::run(arguments, out),
            Self::Simulate(arguments) => simulate::run(arguments, context, out),
            Self::Suggest(arguments) => suggest::run(arguments, context, out),
        }
    }
}

/// What every verb that writes files takes.
#[derive(Debug, Clone, Copy, Args)]
struct Overwriting {
    /// Overwrite existing output files
    #[arg(long)]
    force: bool,
}

impl Overwriting {
    /// The outputs of a run, none yet.
    fn outputs(self) -> Outputs {
        Outputs::new(self.force)
    }
}

/// How a verb writes its result.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Format {
    /// For people.
    Text,
    /// For programs.
    Json,
}

/// How a verb ended that could run.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Status {
    Done,
    /// Something was found, and the user asked to be told by the exit status.
    Found,
}

/// Why a verb could not run to its end.
#[derive(Debug)]
enum Failure {
    Complaint(Box<Complaint>),
    /// Some of several records; the others are done.
    Complaints(Vec<Complaint>),
    /// The result could not be written to standard output.
    Output(io::Error),
}

impl From<Complaint> for Failure {
    fn from(complaint: Complaint) -> Self {
        Self::Complaint(Box::new(complaint))
    }
}

impl From<Interrupted> for Failure {
    fn from(interrupted: Interrupted) -> Self {
        Complaint::from(interrupted).into()
    }
}

impl From<io::Error> for Failure {
    fn from(error: io::Error) -> Self {
        Self::Output(error)
    }
}

/// The verbs as a user meets them; [which when](../../docs/which-verb.md) has the same order.
const GROUPS: [(&str, &[&str]); 6] = [
    ("Begin", &["example", "init", "check", "simulate"]),
    ("Diagnose", &["compare", "calibrate", "diagnose"]),
    ("Find what the model lacks", &["suggest", "add", "improve", "desk"]),
    ("Plan and trust", &["isolability", "campaign"]),
    ("Keep and survey", &["history", "export", "fleet"]),
    ("Look up", &["components", "effects", "completions", "man"]),
];

/// Columns of a name of a verb with what stands around it.
const NAME: usize = 15;

/// The command line whose help has the verbs in groups.
fn command() -> clap::Command {
    let program = CommandLine::command();
    let line = |name: &&str| {
        let about = program.find_subcommand(name).and_then(|verb| verb.get_about()).map(ToString::to_string);
        let mut lines = wrapped(&format!("{}{}", "_".repeat(NAME), about.unwrap_or_default()), &" ".repeat(NAME));
        lines[0].replace_range(..NAME, &format!("  {name:<13}"));
        lines.join("\n") + "\n"
    };
    let group =
        |(title, verbs): &(&str, &[&str])| format!("{title}:\n{}\n", verbs.iter().map(line).collect::<String>());
    let groups: String = GROUPS.iter().map(group).collect();
    let template = format!(
        "{{about}}\n\n{{usage-heading}} {{usage}}\n\n{groups}Options:\n{{options}}\n\n\
         Start here: borescope example DIR   (a rig file, records, what to type)\n\
         One verb:   borescope VERB --help\n\
         The book:   docs/SUMMARY.md; docs/which-verb.md says which verb when\n"
    );
    program.help_template(template)
}

/// Runs one command line, the name of the program first, and returns the exit status.
pub fn run(arguments: impl IntoIterator<Item = OsString>) -> u8 {
    let arguments: Vec<OsString> = arguments.into_iter().collect();
    let pipes: Vec<String> = arguments.iter().skip(1).filter_map(named_pipe).collect();
    let parsed = command().try_get_matches_from(arguments);
    let command_line = match parsed.and_then(|matches| CommandLine::from_arg_matches(&matches)) {
        Ok(command_line) => command_line,
        Err(error) => {
            // Help that nobody reads to its end is no failure.
            let _ = error.print();
            return u8::try_from(error.exit_code()).unwrap_or(2);
        }
    };
    terminal::set_quiet(command_line.quiet);
    terminal::set_opening(command_line.open);
    outlive_size_limit();
    for pipe in pipes {
        terminal::note(format_args!("note: {pipe}: this is a pipe; waiting for the program at its other end"));
    }
    let first_look = FirstLook::default();
    let context = terminal::context(&first_look);
    let ending = interrupt::watch(&context, first_look);
    let mut out = Visible::new(io::BufWriter::new(terminal::Output::new()), terminal::style().colour);
    let result = on_threads(&context, command_line.threads).map_err(Failure::from).and_then(|context| {
        let status = command_line.verb.run(&context, &mut out)?;
        out.flush()?;
        Ok(status)
    });
    terminal::clear();
    let message = match result {
        Err(_) if context.is_cancelled() => return ending.interrupted(),
        Ok(status) => {
            terminal::say_what_took_long();
            return match status {
                Status::Done => 0,
                Status::Found => 1,
            };
        }
        // Whoever closed the pipe has seen enough.
        Err(Failure::Output(error)) if is_closed_pipe(&error) => return 0,
        Err(Failure::Output(error)) => format!("error: standard output cannot be written: {error}"),
        Err(Failure::Complaint(complaint)) => complaint.with_lines(),
        Err(Failure::Complaints(complaints)) => {
            // What the other records gave has been written before.
            let _ = out.flush();
            complaints.iter().map(Complaint::with_lines).collect::<Vec<_>>().join("\n")
        }
    };
    // `eprintln!` would panic where standard error is closed.
    let _ = writeln!(io::stderr(), "{message}");
    2
}

/// The context on so many threads, without a number on as many as the machine has.
fn on_threads(context: &Context, asked: Option<usize>) -> Result<Context, Complaint> {
    match asked {
        Some(0) => Err(Complaint::new(Kind::Bounds, "no threads to work with")
            .help("give `--threads` a number above 0, or leave it away")),
        Some(threads) => context.clone().with_threads(threads),
        None => Ok(context.clone()),
    }
}

/// What is wrong with a command line, without the advice to read `--help`, which another program cannot follow.
fn wrong_words(text: &str) -> Complaint {
    let joined = |paragraph: &str| paragraph.split_whitespace().collect::<Vec<_>>().join(" ");
    let mut paragraphs = text.trim_start_matches("error: ").split("\n\n");
    let complaint = Complaint::new(Kind::Syntax, joined(paragraphs.next().unwrap_or_default()));
    match paragraphs.find_map(|paragraph| paragraph.trim_start().strip_prefix("tip: ")) {
        Some(tip) => complaint.help(joined(tip)),
        None => complaint,
    }
}

/// Runs one command line, the name of the program first, within another program: what the command would write to standard output
/// goes to `out`, its notes to `notes`, and `context` stands in for its signals and its progress. Gives whether something was found, where `--exit-code` asks.
///
/// # Errors
/// What the command would say on standard error before it ends with 2; of several records one each.
pub fn call(
    arguments: impl IntoIterator<Item = OsString>,
    context: &Context,
    out: &mut dyn Write,
    notes: &mut Vec<String>,
) -> Result<bool, Vec<Complaint>> {
    let command_line = CommandLine::try_parse_from(arguments).map_err(|error| vec![wrong_words(&error.to_string())])?;
    let context = on_threads(context, command_line.threads).map_err(|complaint| vec![complaint])?;
    let (result, made) = terminal::gathering_notes(|| command_line.verb.run(&context, out));
    notes.extend(made);
    let result = result.and_then(|status| {
        out.flush()?;
        Ok(status)
    });
    match result {
        Ok(status) => Ok(status == Status::Found),
        Err(Failure::Complaint(complaint)) => Err(vec![*complaint]),
        Err(Failure::Complaints(complaints)) => Err(complaints),
        Err(Failure::Output(error)) => {
            Err(vec![Complaint::new(Kind::Unwritable, format!("the result cannot be written: {error}"))])
        }
    }
}

/// Lets a limit on the size of files be an error of writing, with its message, instead of the end of the program.
#[cfg(unix)]
fn outlive_size_limit() {
    // The signal does what it did before where it cannot be caught.
    let _ = signal_hook::flag::register(
        signal_hook::consts::SIGXFSZ,
        std::sync::Arc::new(std::sync::atomic::AtomicBool::new(false)),
    );
}

#[cfg(not(unix))]
fn outlive_size_limit() {}

/// The argument, where it names a pipe in a folder: opening one waits for another program, for ever if there is none.
#[cfg(unix)]
fn named_pipe(argument: &OsString) -> Option<String> {
    use std::os::unix::fs::FileTypeExt;
    // Pipes that a shell makes have their other end already.
    let is_of_shell = Path::new(argument).starts_with("/dev") || Path::new(argument).starts_with("/proc");
    let is_pipe = || std::fs::metadata(argument).is_ok_and(|there| there.file_type().is_fifo());
    (!is_of_shell && is_pipe()).then(|| argument.to_string_lossy().into_owned())
}

#[cfg(not(unix))]
fn named_pipe(_: &OsString) -> Option<String> {
    None
}

/// Says on standard error that a journal is held by another program.
fn waiting(journal: &Path) {
    terminal::note(format_args!("note: {}: another program writes the journal; waiting for it", journal.display()));
}

/// Writes a result as indented JSON with a final line break.
fn write_json(out: &mut dyn Write, result: &impl serde::Serialize) -> io::Result<()> {
    serde_json::to_writer_pretty(&mut *out, result)?;
    writeln!(out)
}

/// Writes the page of `--report`, whole or not at all.
fn write_page(path: &Path, page: &str) -> Result<(), Complaint> {
    write_file(path, |file| file.write_all(page.as_bytes()))?;
    terminal::open_page(path);
    Ok(())
}

/// Writes a file that the user named, whole or not at all, and says that it is there.
fn write_file(path: &Path, write: impl FnOnce(&mut dyn Write) -> io::Result<()>) -> Result<(), Complaint> {
    write_atomically(path, write)?;
    terminal::written(path);
    Ok(())
}
