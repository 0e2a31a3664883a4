//! Oil that gets thinner as it gets warmer, its temperature measured.

use super::{At, Effect, Form, FreeParameter, InitialGuess};

pub const EFFECT: Effect = Effect {
    name: "viscosity-temperature",
    meaning: "Oil that gets thinner as it gets warmer, so that gaps leak more; its temperature is recorded.",
    law: "mu = mu_ref exp(-k (T - T_ref))",
    source: "Merritt (1967), section 1-3; exponential law of Reynolds",
    validity: "One temperature for the whole rig, within 20 K of the reference; acts where a law has the viscosity, as the gap of a cylinder does.",
    empirical: false,
    everywhere: false,
    at: At::Warmth("viscosity"),
    form: Form::ParameterChange,
    parameters: &[FreeParameter {
        name: "temperature_coefficient",
        neutral: Some(0.0),
        first: InitialGuess::Value(0.03),
        plausible: (0.0, 0.08),
    }],
};
