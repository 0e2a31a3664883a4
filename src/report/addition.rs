//! An addition to a rig file as text.

use std::fmt;

use super::digits::plus_minus;
use crate::learn::addition::{AddedParameter, AdditionReport};
use crate::learn::evaluated::RIVAL;
use crate::number::before_unit;

impl fmt::Display for AdditionReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for effect in &self.effects {
            writeln!(f, "{}: {} added", self.rig, effect.id)?;
            for AddedParameter { id, value, sigma, unit } in &effect.parameters {
                writeln!(f, "  {id} = {} (one standard deviation)", before_unit(plus_minus(*value, *sigma), unit))?;
            }
        }
        for warning in &self.warnings {
            writeln!(f, "  {warning}")?;
        }
        match self.delta_bic {
            Some(fall) if fall < 0.0 => writeln!(
                f,
                "  the record does not ask for it: the information criterion rises by {:.1}, and has to fall by {RIVAL:.0}",
                -fall
            )?,
            Some(fall) if fall < RIVAL => writeln!(
                f,
                "  the record does not ask for it: the information criterion falls by {fall:.1}, and has to by {RIVAL:.0}"
            )?,
            Some(fall) => writeln!(f, "  the record asks for it: the information criterion falls by {fall:.1}")?,
            None => {}
        }
        Ok(())
    }
}
