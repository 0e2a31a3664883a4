//! `desk`: a page on this machine on which a model meets its records.

use std::io::Write;
use std::path::PathBuf;

use clap::Args;

use super::{Failure, Status, read, terminal};
use crate::context::Context;
use crate::desk::{Desk, Server};
use crate::files::read_text;
use crate::rig::Rig;

/// Open a page in the browser on which to compare, find what is missing, add it, fit, judge and save
#[derive(Debug, Args)]
#[command(
    after_help = "The page is served on this machine only, at an address that nobody else knows; nothing is loaded from a network.\n\
                  It ends a minute after its last tab was closed, or with Ctrl-C.\n\n\
                  Example:\n  borescope desk rig.toml --fit record.csv --check another.csv"
)]
pub struct Arguments {
    /// The rig file; it is never written to
    rig: PathBuf,
    /// A record that the model is fitted to
    #[arg(long, value_name = "A.csv")]
    fit: PathBuf,
    /// Another record, to which nothing is fitted
    #[arg(long, value_name = "B.csv")]
    check: Option<PathBuf>,
    /// The port of this machine; any that is free without it
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..))]
    port: Option<u16>,
    /// Do not open the browser, only print the address
    #[arg(long)]
    no_open: bool,
}

pub fn run(arguments: &Arguments, context: &Context, out: &mut dyn Write) -> Result<Status, Failure> {
    let text = read_text(&arguments.rig)?;
    let rig = Rig::parse(&arguments.rig, text.clone())?.with_context(context);
    let fit = read::record(&rig, &arguments.fit)?;
    let check = arguments.check.as_ref().map(|path| read::record(&rig, path)).transpose()?;
    if let Some(check) = &arguments.check {
        read::not_itself(&arguments.fit, check);
    }
    let desk = Desk::new(rig, text, fit, check)?;
    let server = Server::new(desk, arguments.port)?;
    terminal::clear();
    writeln!(out, "{}", server.address())?;
    out.flush()?;
    if !arguments.no_open && !terminal::opened(&server.address()) {
        terminal::note(format_args!("note: no browser could be opened; open the address above in one"));
    }
    terminal::note(format_args!("the desk is open; Ctrl-C ends it"));
    server.serve(context)?;
    terminal::note(format_args!("the last tab was closed; the desk ends"));
    Ok(Status::Done)
}
