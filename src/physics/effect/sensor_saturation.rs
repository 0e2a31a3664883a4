//! Saturation of a sensor.

use super::{At, Effect, Form, FreeParameter, InitialGuess, Reading};
use crate::numeric::Real;
use crate::physics::card::{Card, Parameter};

pub const EFFECT: Effect = Effect {
    name: "sensor-saturation",
    meaning: CARD.meaning,
    law: CARD.law,
    source: CARD.source,
    validity: CARD.validity,
    empirical: false,
    everywhere: false,
    at: At::Sensor,
    form: Form::Reading { card: &CARD },
    parameters: &[FreeParameter {
        name: "limit",
        neutral: None,
        first: InitialGuess::Range(0.95),
        plausible: (-1e30, 1e30),
    }],
};

pub const CARD: Card = Card {
    kind: "sensor-saturation",
    meaning: "A sensor that shows no more than a limit.",
    law: "y = min(raw, limit)",
    source: "end of the measuring range",
    validity: "Upper end only.",
    parameters: &[Parameter::required("limit", "y_max", "-", "largest reading")],
    ..Card::EMPTY
};

pub struct SensorSaturation;

impl Reading for SensorSaturation {
    fn apply<T: Real>(parameters: &[T], _times: &[f64], readings: &mut [T]) {
        for reading in readings {
            *reading = reading.min(parameters[0]);
        }
    }
}
