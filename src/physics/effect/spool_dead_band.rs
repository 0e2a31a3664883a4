//! Dead band of a directional control valve.

use super::{At, Effect, Form, FreeParameter, InitialGuess};
use crate::physics::component::directional_valve;

pub const EFFECT: Effect = Effect {
    name: "spool-dead-band",
    meaning: "Overlap of the spool: it has to move before an edge opens.",
    law: "s_eff = sign(s) max(|s| - d, 0)/(1 - d)",
    source: "Merritt (1967), section 5-1",
    validity: "The same for all edges.",
    empirical: false,
    everywhere: false,
    at: At::Component { card: &directional_valve::CARD, named: false },
    form: Form::ParameterChange,
    parameters: &[FreeParameter {
        name: "dead_band",
        neutral: Some(0.0),
        first: InitialGuess::Value(0.05),
        plausible: (0.0, 0.5),
    }],
};
