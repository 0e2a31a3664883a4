//! Effects of a rig file that a record is to say the size of, whatever the file says.

use super::refit::range_deviation;
use super::trial_steps::nothing;
use crate::physics::effect::FreeParameter;
use crate::rig::{EffectInstance, Rig};

/// A rig whose effects are open: what it states of their size with an uncertainty is where a fit starts, and no knowledge. It may come
/// from the same record, and from a model that lacked what is added now.
pub(super) fn opened(rig: &Rig) -> Rig {
    let mut open = rig.clone();
    for effect in &rig.effects {
        for (free, &index) in effect.placed.effect.parameters.iter().zip(&effect.parameters) {
            if rig.parameters[index].sigma > 0.0 {
                open.parameters[index].sigma = wide(rig, &effect.placed, free, rig.parameters[index].value);
            }
        }
    }
    open
}

/// Standard uncertainty of a parameter of an effect of which next to nothing is known, SI.
fn wide(rig: &Rig, placed: &EffectInstance, free: &FreeParameter, value: f64) -> f64 {
    let neutral = neutral(rig, placed, free).unwrap_or(0.0);
    let size = rig.first_size(placed, free).map_or(0.0, |first| (first - neutral).abs()).max((value - neutral).abs());
    if size > 0.0 {
        rig.settings().learn.revised_sigma * size
    } else {
        range_deviation(&rig.effect_unit(placed, free.name), free)
    }
}

/// The value, SI, at which a parameter of an effect that the rig has does nothing; `None` where only others of it say so.
pub fn neutral(rig: &Rig, placed: &EffectInstance, free: &FreeParameter) -> Option<f64> {
    nothing(rig, placed, free).filter(|_| free.neutral.is_some())
}
