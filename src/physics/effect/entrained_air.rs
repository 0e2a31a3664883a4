//! Free air in the oil.

use super::{At, Effect, Form, FreeParameter, InitialGuess};

pub const EFFECT: Effect = Effect {
    name: "entrained-air",
    meaning: "Air bubbles in the oil, which make it soft at low pressure.",
    law: "1/beta_eff = 1/beta + alpha/n (p_0/p)^(1/n) / p",
    source: "Merritt (1967), section 1-4",
    validity: "No solution of air; alpha is the volume of air per volume of oil at atmospheric pressure. Isothermal (n = 1) unless the rig file states `air_exponent`: air that keeps its heat shows up as up to 1.4 times the volume.",
    empirical: false,
    everywhere: false,
    at: At::Fluid("compressibility"),
    form: Form::ParameterChange,
    parameters: &[FreeParameter {
        name: "air_fraction",
        neutral: Some(0.0),
        first: InitialGuess::Value(0.5),
        plausible: (0.0, 20.0),
    }],
};
