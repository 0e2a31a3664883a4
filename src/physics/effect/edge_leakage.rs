//! Leakage past one land of a directional control valve, at its pressure port: past those of the tank port it is an external leakage.

use super::{At, Effect, Form, FreeParameter, InitialGuess};
use crate::physics::component::directional_valve;

/// What the land leaks per pressure, as the valve has it under this name.
pub(super) const fn conductance(name: &'static str) -> FreeParameter {
    FreeParameter { name, neutral: Some(0.0), first: InitialGuess::Value(0.002), plausible: (0.0, 0.5) }
}

/// The effect of one land.
pub(super) const fn past_land(
    name: &'static str,
    meaning: &'static str,
    law: &'static str,
    parameters: &'static [FreeParameter],
) -> Effect {
    Effect {
        name,
        meaning,
        law,
        source: "paper, equations (11) and (12): internal leakage of the reversing valve",
        validity: "Laminar, whatever the spool's position; another land has its own. Of lands worn alike see `spool-leakage`.",
        empirical: false,
        everywhere: false,
        at: At::Component { card: &directional_valve::CARD, named: false },
        form: Form::ParameterChange,
        parameters,
    }
}
