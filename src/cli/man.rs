//! `man`: the pages of the manual, one for the program and one for each verb.

use std::io::Write;
use std::path::PathBuf;

use clap::{Args, Command, CommandFactory};

use super::{CommandLine, Failure, Overwriting, Status};
use crate::complaint::{Complaint, Kind};
use crate::files::write_atomically;

/// Write the manual pages into a folder
#[derive(Debug, Args)]
#[command(after_help = "Example:\n  borescope man ~/.local/share/man/man1")]
pub struct Arguments {
    /// The folder; it is made where it is missing
    folder: PathBuf,
    #[command(flatten)]
    overwriting: Overwriting,
}

/// Runs the verb; what was written is told on `out`.
pub fn run(arguments: &Arguments, out: &mut dyn Write) -> Result<Status, Failure> {
    std::fs::create_dir_all(&arguments.folder).map_err(|error| {
        Complaint::new(Kind::Unwritable, format!("cannot be created: {error}"))
            .in_file(&arguments.folder)
            .help("name another")
    })?;
    let mut program = CommandLine::command().disable_help_subcommand(true);
    program.build();
    let pages: Vec<Command> = std::iter::once(program.clone()).chain(program.get_subcommands().cloned()).collect();
    let path =
        |page: &Command| arguments.folder.join(format!("{}.1", page.get_display_name().unwrap_or(page.get_name())));
    arguments.overwriting.outputs().writing_all(&pages.iter().map(path).collect::<Vec<_>>())?;
    for page in pages {
        let path = path(&page);
        let man = clap_mangen::Man::new(page);
        write_atomically(&path, |file| man.render(file))?;
        writeln!(out, "{}", path.display())?;
    }
    Ok(Status::Done)
}
