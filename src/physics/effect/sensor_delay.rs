//! Time shift of a sensor.

use super::{At, Effect, Form, FreeParameter, InitialGuess, Reading};
use crate::numeric::Real;
use crate::physics::card::{Card, Parameter};

pub const EFFECT: Effect = Effect {
    name: "sensor-delay",
    meaning: CARD.meaning,
    law: CARD.law,
    source: CARD.source,
    validity: CARD.validity,
    empirical: false,
    everywhere: false,
    at: At::Sensor,
    form: Form::Reading { card: &CARD },
    parameters: &[FreeParameter {
        name: "delay",
        neutral: Some(0.0),
        first: InitialGuess::Value(4.0),
        plausible: (-10000.0, 10000.0),
    }],
};

pub const CARD: Card = Card {
    kind: "sensor-delay",
    meaning: "A sensor whose time stamps are late.",
    law: "y(t) = raw(t - T)",
    source: "clock of the logger; transmission",
    validity: "Straight between samples; the first reading holds before the record.",
    parameters: &[Parameter::required("delay", "T", "ms", "time by which the reading is late")
        .or(0.0)
        .within(-1e6, 1e6)],
    ..Card::EMPTY
};

pub struct SensorDelay;

impl Reading for SensorDelay {
    fn apply<T: Real>(parameters: &[T], times: &[f64], readings: &mut [T]) {
        let delay = parameters[0];
        if delay.is_zero() {
            return;
        }
        let raw = readings.to_vec();
        for (row, reading) in readings.iter_mut().enumerate() {
            let t = T::constant(times[row]) - delay;
            let next = times.partition_point(|&time| time < t.re()).clamp(1, raw.len().max(2) - 1);
            let (Some(&early), Some(&late)) = (raw.get(next - 1), raw.get(next)) else { continue };
            let share = (t - times[next - 1]) / (times[next] - times[next - 1]);
            let inside = share.re().clamp(0.0, 1.0);
            *reading =
                if inside == share.re() { early + (late - early) * share } else { early + (late - early) * inside };
        }
    }
}
