//! Leakage across a motor through a hole.

use super::{At, Effect, Form, FreeParameter, InitialGuess, Joint, orifice_leakage};
use crate::physics::component::facts::Symbol;

pub const EFFECT: Effect = Effect {
    name: "motor-orifice-leakage",
    meaning: "Leakage across a motor that follows the law of a hole, not that of its gaps: a scored plate, an open bypass, a check valve that does not seat.",
    law: orifice_leakage::CARD.law,
    source: orifice_leakage::CARD.source,
    validity: orifice_leakage::CARD.validity,
    empirical: false,
    everywhere: false,
    at: At::Like { symbol: Symbol::Motor, named: true },
    form: Form::Shunt {
        card: &orifice_leakage::CARD,
        joints: &[Joint::Hydraulic(0), Joint::Hydraulic(1)],
        shared: &[],
    },
    parameters: &[FreeParameter {
        name: "area",
        neutral: Some(0.0),
        first: InitialGuess::Value(0.5),
        plausible: (0.0, 50.0),
    }],
};
