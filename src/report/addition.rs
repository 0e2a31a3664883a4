//! An addition to a rig file as text.

use std::fmt;

use super::brief::wrapped;
use super::caveats::followed_otherwise;
use super::digits::plus_minus;
use crate::learn::addition::{AddedParameter, AdditionReport};
use crate::number::{before_unit, rounded, text};

/// From this fall of BIC on evidence is called very strong (Kass and Raftery, Journal of the American Statistical Association 90 (1995)).
pub(super) const VERY_STRONG: f64 = 10.0;

impl fmt::Display for AdditionReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for effect in &self.effects {
            writeln!(f, "{}: {} added", self.rig, effect.id)?;
            for AddedParameter { id, value, sigma, unit } in &effect.parameters {
                let value_and_sigma = before_unit(plus_minus(*value, *sigma), unit);
                let open = if self.delta_bic.is_some() && value.abs() < *sigma {
                    "; the record does not determine it"
                } else {
                    ""
                };
                let line =
                    format!("  {id} = {} (one standard deviation){open}", value_and_sigma.replace(' ', "\u{a0}"));
                wrapped(&line, "    ").iter().try_for_each(|line| writeln!(f, "{line}"))?;
            }
        }
        for line in followed_otherwise(&self.dynamics).iter().flat_map(|words| wrapped(&format!("  {words}"), "  ")) {
            writeln!(f, "{line}")?;
        }
        for warning in &self.warnings {
            writeln!(f, "  {warning}")?;
        }
        let strong =
            |fall: f64| format!("(BIC falls by {}; {VERY_STRONG:.0} is very strong evidence)", text(rounded(fall, 3)));
        match self.delta_bic {
            Some(fall) if fall >= VERY_STRONG => writeln!(f, "  the record asks for it {}", strong(fall)),
            Some(fall) if fall >= 0.0 => writeln!(f, "  the record does not ask for it {}", strong(fall)),
            Some(fall) => {
                writeln!(f, "  the record does not ask for it (with it BIC rises by {})", text(rounded(-fall, 3)))
            }
            None => {
                let still = "  At this value it changes nothing: `add --fit RECORD` gives it one, and so does every fit, within what is open of it.";
                wrapped(still, "  ").iter().try_for_each(|line| writeln!(f, "{line}"))
            }
        }
    }
}
