//! A simulation as text.

use std::fmt;

use crate::number;
use crate::simulation::{BelowVacuum, SetParameter, SimulationReport};

impl fmt::Display for SimulationReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { record, rows, from_s, to_s, columns, steps, .. } = self;
        let (columns, from, to) = (columns.len(), number::text(*from_s), number::text(*to_s));
        writeln!(f, "{record}: {rows} rows of {columns} columns from {from} s to {to} s, solved in {steps} steps")?;
        for SetParameter { id, value, unit } in &self.set {
            writeln!(f, "  {id} = {}", number::with_unit(*value, unit))?;
        }
        Ok(())
    }
}

/// That a pressure has left what the model is valid for, in one line.
pub fn below_vacuum(below: &BelowVacuum) -> String {
    let [pressure, at] = [below.pressure_bar, below.at_s].map(|value| number::text(number::rounded(value, 4)));
    let others = match below.nodes {
        1 => String::new(),
        nodes => format!(" ({nodes} nodes fall below it)"),
    };
    format!(
        "the pressure of node `{}` falls to {pressure} bar at {at} s, below vacuum (-1.013 bar over the atmosphere){others}: oil would cavitate, \
         which the model does not know, so it is not valid there",
        below.node
    )
}
