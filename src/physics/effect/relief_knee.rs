//! Soft knee of a relief valve.

use super::{At, Effect, Form, FreeParameter, InitialGuess};
use crate::physics::component::relief_valve;

pub const EFFECT: Effect = Effect {
    name: "relief-knee",
    meaning: "A relief valve that opens gradually around its cracking pressure.",
    law: "e = (dp + sqrt(dp^2 + w^2))/2 with dp = p_P - p_T - p_c",
    source: "smooth maximum; Merritt (1967), section 5-6",
    validity: "Symmetric knee of width w.",
    empirical: false,
    everywhere: false,
    at: At::Component { card: &relief_valve::CARD, named: false },
    form: Form::ParameterChange,
    parameters: &[FreeParameter {
        name: "knee",
        neutral: Some(0.0),
        first: InitialGuess::Value(1.0),
        plausible: (0.0, 30.0),
    }],
};
