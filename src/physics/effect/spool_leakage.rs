//! Leakage past the lands of a directional control valve.

use super::{At, Effect, Form, FreeParameter, InitialGuess};
use crate::physics::component::directional_valve;

pub const EFFECT: Effect = Effect {
    name: "spool-leakage",
    meaning: "Leakage past the lands of the spool, most of it around the middle: their radial clearance and worn edges.",
    law: "q = G_0 dp r/(r + s_c (1 - r)) of every edge;  s_c how far the spool has closed it",
    source: "Merritt (1967), chapter 5: laminar flow through a gap as long as the lands overlap",
    validity: "The same for all edges; laminar. An edge that opens goes on leaking as in the middle, which is little beside its flow.",
    empirical: false,
    everywhere: false,
    at: At::Component { card: &directional_valve::CARD, named: false },
    form: Form::ParameterChange,
    parameters: &[
        FreeParameter {
            name: "null_leakage",
            neutral: Some(0.0),
            first: InitialGuess::Value(0.002),
            plausible: (0.0, 0.5),
        },
        FreeParameter { name: "closed_share", neutral: None, first: InitialGuess::Value(0.3), plausible: (0.001, 1.0) },
    ],
};
