//! A flow control valve that is slower or faster than its data sheet.

use super::{At, Effect, Form, FreeParameter, InitialGuess};
use crate::physics::component::flow_control_valve;

pub const EFFECT: Effect = Effect {
    name: "compensator-lag",
    meaning: "Time constant of the reducing valve.",
    law: "tau x' = x* - x",
    source: "first-order dynamics of the spool",
    validity: "First order.",
    empirical: false,
    everywhere: false,
    at: At::Component { card: &flow_control_valve::CARD, named: false },
    form: Form::ParameterChange,
    parameters: &[FreeParameter {
        name: "lag",
        neutral: None,
        first: InitialGuess::Value(10.0),
        plausible: (0.2, 1000.0),
    }],
};
