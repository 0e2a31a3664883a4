//! Lag of a sensor.

use super::{At, Effect, Form, FreeParameter, InitialGuess, Reading};
use crate::numeric::Real;
use crate::physics::card::{Card, Parameter, Role};

pub const EFFECT: Effect = Effect {
    name: "sensor-lag",
    meaning: CARD.meaning,
    law: CARD.law,
    source: CARD.source,
    validity: CARD.validity,
    empirical: false,
    everywhere: false,
    at: At::Sensor,
    form: Form::Reading { card: &CARD },
    parameters: &[FreeParameter {
        name: "lag",
        neutral: Some(0.0),
        first: InitialGuess::Value(4.0),
        plausible: (0.0, 10000.0),
    }],
};

pub const CARD: Card = Card {
    kind: "sensor-lag",
    meaning: "A sensor that follows with a time constant.",
    law: "tau y' = raw - y",
    source: "first-order transducer or filter",
    validity: "Exact for readings that run straight from sample to sample.",
    parameters: &[Parameter::required("lag", "tau", "ms", "time constant").is(Role::Lag).or(0.0)],
    ..Card::EMPTY
};

pub struct SensorLag;

impl Reading for SensorLag {
    fn apply<T: Real>(parameters: &[T], times: &[f64], readings: &mut [T]) {
        let lag = parameters[0];
        if lag.re() <= 0.0 {
            return;
        }
        let Some(mut before) = readings.first().copied() else { return };
        let mut follows = before;
        for row in 1..readings.len() {
            let step = T::constant(times[row] - times[row - 1]);
            let now = readings[row];
            let share = step / lag;
            // The answer to a ramp from `before` to `now`: no gradient is lost where the lag is short.
            let decay = (-share).exp();
            let slope = (now - before) / share;
            follows = now - slope + (follows - before + slope) * decay;
            readings[row] = follows;
            before = now;
        }
    }
}
