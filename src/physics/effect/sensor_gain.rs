//! Gain of a sensor.

use super::{At, Effect, Form, FreeParameter, InitialGuess};

pub const EFFECT: Effect = Effect {
    name: "sensor-gain",
    meaning: "What the sensor shows per true value.",
    law: "y = gain raw",
    source: "any transducer",
    validity: "Constant over the record.",
    empirical: false,
    everywhere: false,
    at: At::Sensor,
    form: Form::ParameterChange,
    parameters: &[FreeParameter {
        name: "gain",
        neutral: Some(1.0),
        first: InitialGuess::Value(1.02),
        plausible: (0.5, 2.0),
    }],
};
