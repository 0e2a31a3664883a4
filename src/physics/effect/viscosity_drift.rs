//! Oil that gets thinner while the record runs, its temperature not measured.

use super::{At, Effect, Form, FreeParameter, InitialGuess};

pub const EFFECT: Effect = Effect {
    name: "viscosity-drift",
    meaning: "Oil that gets thinner while the record runs, so that gaps leak more; its temperature is not recorded.",
    law: "mu = mu_ref exp(-r t)",
    source: "exponential law of Reynolds (Merritt, 1967, section 1-3) with a temperature that rises straight over time",
    validity: "t from the first row of each record, where the viscosity is that of the rig file; acts where a law has the viscosity.",
    empirical: false,
    everywhere: false,
    at: At::Fluid("viscosity"),
    form: Form::ParameterChange,
    parameters: &[FreeParameter {
        name: "viscosity_drift",
        neutral: Some(0.0),
        first: InitialGuess::Value(0.01),
        plausible: (-0.1, 0.1),
    }],
};
