//! A rig file to begin with, from the columns of a record: the circuit that such columns are mostly from, with each column at the
//! sensor or input that it may be, and a mark at every value that only the data sheet knows.

mod roles;
mod text;

use crate::complaint::{Complaint, Kind, help_with_names};
use crate::record::{Channel, Record};
use crate::units::{Dimension, Quantity};

use roles::Roles;

/// The circuit of a drafted rig file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Circuit {
    /// Pump, relief valve, directional valve and cylinder.
    Cylinder,
    /// A pump that fills open reservoirs, each of which drains into the next.
    Reservoirs,
}

/// What is known beside the record.
#[derive(Debug, Clone, Default)]
pub struct DraftOptions {
    /// Without it reservoirs where the record has levels and no pressure, and else a cylinder.
    pub circuit: Option<Circuit>,
    /// The column of the command; without it two columns that switch a solenoid each, or the first pure number or voltage.
    pub command: Option<String>,
    /// The column of the load; without it the first force.
    pub load: Option<String>,
    /// Bore, rod diameter and stroke of the cylinder.
    pub bore: Option<Quantity>,
    /// Rod diameter of the cylinder.
    pub rod: Option<Quantity>,
    /// Stroke of the cylinder.
    pub stroke: Option<Quantity>,
}

/// A drafted rig file.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Draft {
    /// Its text.
    pub text: String,
    /// Columns with what became of them, in the order of the record; `None` of those that it leaves to the user.
    pub columns: Vec<(String, Option<String>)>,
    /// Values that only the data sheet knows.
    pub open_values: usize,
    /// Columns that the rig file asks for and the record does not have.
    pub missing: Vec<String>,
}

/// Drafts a rig file.
///
/// # Errors
/// A column that the record does not have.
pub fn draft(record: &Record, options: &DraftOptions) -> Result<Draft, Complaint> {
    let command = options.command.as_ref().map(|name| column(record, name)).transpose()?;
    let load =
        options.load.as_ref().map(|name| record.of_dimension(name, Dimension::FORCE, record.header())).transpose()?;
    let roles = Roles::of(record, options.circuit, command, load);
    let commands: &[Dimension] = match roles.circuit {
        Circuit::Cylinder => &[Dimension::NONE, Dimension::VOLTAGE],
        Circuit::Reservoirs => &[Dimension::VOLTAGE],
    };
    if let Some(command) = roles.command.filter(|command| !commands.contains(&command.unit.dimension)) {
        let what = format!("the column `{}` is a {}, and no command", command.name, command.unit.dimension);
        return Err(Complaint::new(Kind::Dimension, what)
            .at(record.header())
            .help("name a voltage; for a directional valve also a pure number, 1 where it is fully open"));
    }
    let (text, missing) = match roles.circuit {
        Circuit::Cylinder => text::cylinder(record, &roles, options),
        Circuit::Reservoirs => text::reservoirs(record, &roles),
    };
    let columns = record.channels.iter().map(|channel| (channel.name.clone(), roles.of_column(&channel.name)));
    Ok(Draft { columns: columns.collect(), open_values: text.matches(text::OPEN).count(), missing, text })
}

fn column<'a>(record: &'a Record, name: &str) -> Result<&'a Channel, Complaint> {
    record.channel(name).ok_or_else(|| {
        let names = record.channels.iter().map(|channel| channel.name.as_str());
        Complaint::new(Kind::UnknownName, format!("the record has no column `{name}`"))
            .at(record.header())
            .help(help_with_names(name, "columns", names))
    })
}
