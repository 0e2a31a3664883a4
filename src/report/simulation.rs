//! A simulation as text.

use std::fmt;

use crate::number;
use crate::simulation::{SetParameter, SimulationReport};

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
