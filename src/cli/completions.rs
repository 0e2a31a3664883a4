//! `completions`: what a shell has to know to complete the verbs and options.

use std::io::Write;

use clap::{Args, CommandFactory};
use clap_complete::Shell;

use super::{CommandLine, Failure, Status};

/// Write shell completions to standard output
#[derive(Debug, Args)]
#[command(
    after_help = "Examples:\n  borescope completions bash \\\n    > ~/.local/share/bash-completion/completions/borescope\n  \
                  borescope completions zsh > ~/.zfunc/_borescope\n  \
                  borescope completions fish > ~/.config/fish/completions/borescope.fish"
)]
pub struct Arguments {
    /// The shell
    #[arg(value_enum)]
    shell: Shell,
}

/// Runs the verb.
pub fn run(arguments: &Arguments, out: &mut dyn Write) -> Result<Status, Failure> {
    // A closed pipe must not panic, so the text is made first.
    let mut text = Vec::new();
    clap_complete::generate(arguments.shell, &mut CommandLine::command(), "borescope", &mut text);
    out.write_all(&text)?;
    Ok(Status::Done)
}
