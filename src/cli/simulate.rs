//! `simulate`: what the sensors of a rig would read.

use std::io::Write;
use std::path::PathBuf;

use clap::{Args, ValueEnum};

use super::{Failure, Format, Overwriting, Status, read, terminal, write_json};
use crate::complaint::{Complaint, Kind};
use crate::context::Context;
use crate::files::is_kept;
use crate::finding::argument;
use crate::model::Model;
use crate::report::brief::next_line;
use crate::rig::Rig;
use crate::simulation::{self, SetParameter, SimulationOptions, SimulationReport, simulate};

/// Simulate a rig, and write the record that its sensors would give
#[derive(Debug, Args)]
#[command(
    after_help = "Example:\n  borescope simulate rig.toml --set cylinder.clearance=0.2mm --seed 1 \\\n    -o record.csv"
)]
pub struct Arguments {
    /// The rig file
    rig: PathBuf,
    /// Take commands and loads from this record; without it from the `[cycle]` of the rig file
    #[arg(long, value_name = "RECORD")]
    input: Option<PathBuf>,
    /// Give a parameter another value, such as `cylinder.clearance=0.2mm`; may be repeated
    #[arg(long, value_name = "PARAMETER=VALUE")]
    set: Vec<String>,
    /// Add noise to sensors and inputs and round to the sensors' resolution; the same number gives the same record
    #[arg(long, value_name = "N")]
    seed: Option<u64>,
    /// How the equations are solved
    #[arg(long, value_enum, default_value_t = Method::Implicit)]
    method: Method,
    /// Where the record is written
    #[arg(short, long, value_name = "RECORD.csv")]
    output: PathBuf,
    /// How the summary is written
    #[arg(long, value_enum, default_value_t = Format::Text)]
    format: Format,
    #[command(flatten)]
    overwriting: Overwriting,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Method {
    /// Rodas5P, for every circuit
    Implicit,
    /// Dormand-Prince 5(4), for circuits that are not stiff, such as open reservoirs: an independent check
    Explicit,
}

impl From<Method> for simulation::Method {
    fn from(method: Method) -> Self {
        match method {
            Method::Implicit => Self::Implicit,
            Method::Explicit => Self::Explicit,
        }
    }
}

/// Runs the verb; the summary goes to `out`, unless the record itself goes to a device.
pub fn run(arguments: &Arguments, context: &Context, out: &mut dyn Write) -> Result<Status, Failure> {
    let outputs = arguments.overwriting.outputs().reading(arguments.input.iter().chain([&arguments.rig]));
    outputs.writing(&arguments.output)?;
    let mut rig = Rig::read(&arguments.rig)?.with_context(context);
    read::doubts_of(&rig);
    let set = arguments
        .set
        .iter()
        .map(|text| assigned("--set", text, |id, value| Ok(SetParameter::new(id, &rig.set(id, value)?))));
    let set = set.collect::<Result<Vec<_>, _>>()?;
    rig.check_capacities().map_err(|complaint| {
        let what = format!("with `--set {}` {}", arguments.set.join(" --set "), complaint.what);
        Complaint { what, ..complaint }
    })?;
    let source = arguments.input.as_deref().map(|path| read::record(&rig, path)).transpose()?;
    let options =
        SimulationOptions { name: arguments.output.clone(), method: arguments.method.into(), seed: arguments.seed };
    let simulated = simulate(&Model::new(rig), source.as_ref(), &options)?;
    context.stage("writing the record");
    simulated.record.write(&arguments.output)?;
    terminal::written(&arguments.output);
    if let Some(below) = &simulated.below_vacuum {
        terminal::note(format_args!("warning: {}", below));
    }
    // With `-o /dev/stdout` the summary would stand in the record.
    if is_kept(&arguments.output) {
        let report = SimulationReport::new(&simulated, &arguments.output, set, &options);
        match arguments.format {
            Format::Json => write_json(out, &report)?,
            Format::Text => {
                write!(out, "{report}")?;
                let [rig, record] = [&arguments.rig, &arguments.output].map(argument);
                writeln!(out, "{}", next_line(&format!("borescope diagnose {rig} {record}")))?;
            }
        }
    }
    Ok(Status::Done)
}

/// Hands both sides of `PARAMETER=VALUE` on; what `set` complains of is said of the whole.
pub(super) fn assigned<T>(
    option: &str,
    text: &str,
    set: impl FnOnce(&str, &str) -> Result<T, Complaint>,
) -> Result<T, Complaint> {
    let Some((id, value)) = text.split_once('=') else {
        return Err(Complaint::new(Kind::Syntax, format!("`{option} {text}`: there is no `=`"))
            .help(format!("write PARAMETER=VALUE, such as `{option} cylinder.clearance=0.2mm`")));
    };
    set(id, value).map_err(|complaint| {
        let what = format!("`{option} {text}`: {}", complaint.what);
        Complaint { what, ..complaint }
    })
}
