//! Hysteresis of a directional control valve.

use super::{At, Effect, Form, FreeParameter, InitialGuess};
use crate::physics::component::directional_valve;

pub const EFFECT: Effect = Effect {
    name: "spool-hysteresis",
    meaning: "The spool follows its command only once that is more than half a width away: friction and remanence of a proportional valve.",
    law: "tau s' = e - min(max(e, -h/2), h/2),  e = u - s",
    source: "play operator behind a lag of first order; data sheets state h as the difference of the commands, rising and falling, at one flow",
    validity: "The same width at every position. Commands that never turn back show it as less opening.",
    empirical: false,
    everywhere: false,
    at: At::Component { card: &directional_valve::CARD, named: false },
    form: Form::ParameterChange,
    parameters: &[FreeParameter {
        name: "hysteresis",
        neutral: Some(0.0),
        first: InitialGuess::Value(0.03),
        plausible: (0.0, 0.3),
    }],
};
