//! Viscous friction beyond the data sheet.

use super::{At, Effect, Form, FreeParameter, InitialGuess};
use crate::physics::component::cylinder;

pub const EFFECT: Effect = Effect {
    name: "viscous-friction",
    meaning: "Friction force per speed of the cylinder.",
    law: "F = -b v",
    source: "Newtonian film",
    validity: "Linear.",
    empirical: false,
    everywhere: false,
    at: At::Component { card: &cylinder::CARD, named: true },
    form: Form::ParameterChange,
    parameters: &[FreeParameter {
        name: "viscous_friction",
        neutral: None,
        first: InitialGuess::Value(1600.0),
        plausible: (0.0, 1e6),
    }],
};
