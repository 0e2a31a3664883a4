//! `init`: a rig file to begin with, from the columns of a record.

use std::io::Write;
use std::path::PathBuf;

use clap::{Args, ValueEnum};

use super::{Failure, Overwriting, Status, write_file};
use crate::complaint::{Complaint, Kind};
use crate::context::Context;
use crate::draft::{Circuit, DraftOptions, draft};
use crate::files::is_kept;
use crate::record::Record;
use crate::report::brief::next_line;
use crate::rig::Rig;
use crate::units::{Dimension, Quantity};

/// Draft a commented rig file from the columns of a record
///
/// Values that only the data sheet knows are marked in it; `check` passes it as it is.
#[derive(Debug, Args)]
#[command(after_help = "Example:\n  borescope init record.csv --bore 63mm --rod 36mm -o rig.toml")]
pub struct Arguments {
    /// A record of the machine
    record: PathBuf,
    /// The circuit; without it reservoirs where the record has levels and no pressure, and else a cylinder
    #[arg(long, value_enum)]
    circuit: Option<Kinds>,
    /// The column of the command; without it two columns that switch a solenoid each, or the first pure number or voltage
    #[arg(long, value_name = "COLUMN")]
    command: Option<String>,
    /// The column of the load; without it the first force
    #[arg(long, value_name = "COLUMN")]
    load: Option<String>,
    /// Bore of the cylinder, such as `63mm`
    #[arg(long, value_name = "LENGTH")]
    bore: Option<String>,
    /// Rod diameter of the cylinder
    #[arg(long, value_name = "LENGTH")]
    rod: Option<String>,
    /// Stroke of the cylinder
    #[arg(long, value_name = "LENGTH")]
    stroke: Option<String>,
    /// Where the rig file is written
    #[arg(short, long, value_name = "RIG.toml")]
    output: PathBuf,
    #[command(flatten)]
    overwriting: Overwriting,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Kinds {
    /// Pump, relief valve, directional valve and cylinder
    Cylinder,
    /// A pump that fills open tanks, each of which drains into the next
    Reservoirs,
}

impl From<Kinds> for Circuit {
    fn from(kind: Kinds) -> Self {
        match kind {
            Kinds::Cylinder => Self::Cylinder,
            Kinds::Reservoirs => Self::Reservoirs,
        }
    }
}

/// Runs the verb; what became of the columns is told on `out`.
pub fn run(arguments: &Arguments, context: &Context, out: &mut dyn Write) -> Result<Status, Failure> {
    arguments.overwriting.outputs().reading([&arguments.record]).writing(&arguments.output)?;
    let options = DraftOptions {
        circuit: arguments.circuit.map(Circuit::from),
        command: arguments.command.clone(),
        load: arguments.load.clone(),
        bore: length("--bore", arguments.bore.as_deref())?,
        rod: length("--rod", arguments.rod.as_deref())?,
        stroke: length("--stroke", arguments.stroke.as_deref())?,
    };
    context.stage("reading the record");
    let record = Record::read(&arguments.record)?;
    context.check()?;
    let draft = draft(&record, &options)?;
    // Whatever the flags say, what is written passes `check`.
    Rig::parse(&arguments.output, draft.text.clone())?;
    write_file(&arguments.output, |file| file.write_all(draft.text.as_bytes()))?;
    if !is_kept(&arguments.output) {
        return Ok(Status::Done);
    }
    let (rig, record) = (arguments.output.display(), arguments.record.display());
    let width = draft.columns.iter().map(|(name, _)| name.chars().count()).max().unwrap_or(0);
    writeln!(out, "{rig}: drafted from the columns of {record}\n")?;
    for (name, role) in &draft.columns {
        writeln!(out, "  {name:width$}  {}", role.as_deref().unwrap_or("not used"))?;
    }
    writeln!(out, "\n{} values are marked DATA SHEET: put in those of your machine.", draft.open_values)?;
    for missing in &draft.missing {
        writeln!(out, "No column of the record is the input `{missing}`: name one with `--{missing}`.")?;
    }
    writeln!(out, "\n{}", next_line(&format!("borescope check {rig} {record}")))?;
    Ok(Status::Done)
}

fn length(option: &str, text: Option<&str>) -> Result<Option<Quantity>, Complaint> {
    let parse = |text: &str| {
        Quantity::parse_as(text, Dimension::LENGTH)
            .map_err(|error| Complaint::new(Kind::Unit, format!("`{option} {text}`: {error}")).help(error.help()))
    };
    text.map(parse).transpose()
}
