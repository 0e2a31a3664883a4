//! Offset of a sensor.

use super::{At, Effect, Form, FreeParameter, InitialGuess};

pub const EFFECT: Effect = Effect {
    name: "sensor-offset",
    meaning: "What the sensor shows at zero.",
    law: "y = raw + offset",
    source: "any transducer",
    validity: "Constant over the record.",
    empirical: false,
    everywhere: false,
    at: At::Sensor,
    form: Form::ParameterChange,
    parameters: &[FreeParameter {
        name: "offset",
        neutral: Some(0.0),
        first: InitialGuess::Noise(1.0),
        plausible: (-1e30, 1e30),
    }],
};
