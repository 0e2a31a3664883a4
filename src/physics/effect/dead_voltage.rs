//! Dead voltage of a pump drive.

use super::{At, Effect, Form, FreeParameter, InitialGuess};
use crate::physics::component::flow_source;

pub const EFFECT: Effect = Effect {
    name: "dead-voltage",
    meaning: "Voltage below which the pump does not deliver.",
    law: "q = k max(u - u_0, 0)",
    source: "linear characteristic with a threshold",
    validity: "The same slope above it.",
    empirical: false,
    everywhere: false,
    at: At::Component { card: &flow_source::CARD, named: false },
    form: Form::ParameterChange,
    parameters: &[FreeParameter {
        name: "dead_voltage",
        neutral: Some(0.0),
        first: InitialGuess::Value(0.5),
        plausible: (0.0, 5.0),
    }],
};
