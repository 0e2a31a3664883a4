//! A directional control valve that is slower or faster than its data sheet.

use super::{At, Effect, Form, FreeParameter, InitialGuess};
use crate::physics::component::directional_valve;

pub const EFFECT: Effect = Effect {
    name: "spool-lag",
    meaning: "Time constant of the spool.",
    law: "tau s' = u - s",
    source: "first-order dynamics of the spool",
    validity: "First order.",
    empirical: false,
    everywhere: false,
    at: At::Component { card: &directional_valve::CARD, named: false },
    form: Form::ParameterChange,
    parameters: &[FreeParameter {
        name: "lag",
        neutral: None,
        first: InitialGuess::Value(16.0),
        plausible: (0.2, 2000.0),
    }],
};
