//! Flow force on the spool of a flow control valve.

use super::{At, Effect, Form, FreeParameter, InitialGuess};
use crate::physics::component::flow_control_valve;

pub const EFFECT: Effect = Effect {
    name: "spool-flow-force",
    meaning: "Force of the flow that closes the reducing valve.",
    law: "F = 2 f Cd1 W1 x dp_r,  f = Cv cos(theta)",
    source: "paper, equation (8); Merritt (1967), eq. 5-30",
    validity: "Steady flow force; f is about 0.36 for a sharp edge.",
    empirical: false,
    everywhere: false,
    at: At::Component { card: &flow_control_valve::CARD, named: false },
    form: Form::ParameterChange,
    parameters: &[FreeParameter {
        name: "flow_force",
        neutral: Some(0.0),
        first: InitialGuess::Value(0.2),
        plausible: (0.0, 1.0),
    }],
};
