//! Speed of a pump that droops under load.

use super::{At, Effect, Form, FreeParameter, InitialGuess};
use crate::physics::component::pump;

pub const EFFECT: Effect = Effect {
    name: "pump-droop",
    meaning: "The drive gives way under torque: less speed, less flow.",
    law: "q = D n (1 - loss) (1 - k (p_P - p_T))",
    source: "torque characteristic of an asynchronous motor, linear near its rated point",
    validity: "Linear; for a pump of constant displacement it looks like slip.",
    empirical: false,
    everywhere: false,
    at: At::Component { card: &pump::CARD, named: false },
    form: Form::ParameterChange,
    parameters: &[FreeParameter {
        name: "droop",
        neutral: Some(0.0),
        first: InitialGuess::Value(0.0003),
        plausible: (0.0, 0.005),
    }],
};
