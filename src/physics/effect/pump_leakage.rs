//! Slip of a pump that turns both ways.

use super::{At, Effect, Form, FreeParameter, InitialGuess};
use crate::physics::component::reversible_pump;

pub const EFFECT: Effect = Effect {
    name: "pump-leakage",
    meaning: "Flow through the gaps of a reversible pump, from the side of higher pressure to the other.",
    law: reversible_pump::CARD.law,
    source: reversible_pump::CARD.source,
    validity: reversible_pump::CARD.validity,
    empirical: false,
    everywhere: false,
    at: At::Component { card: &reversible_pump::CARD, named: false },
    form: Form::ParameterChange,
    parameters: &[FreeParameter {
        name: "leakage",
        neutral: Some(0.0),
        first: InitialGuess::Value(0.001),
        plausible: (0.0, 0.05),
    }],
};
