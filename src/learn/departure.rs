//! How far an effect is from doing nothing.

use crate::physics::effect::{Form, FreeParameter};
use crate::rig::{EffectInstance, Rig};

/// The value, SI, at which a parameter of an effect does nothing: its neutral one, or what the rig file states of a parameter that the
/// circuit has anyway.
pub(super) fn nothing(rig: &Rig, placed: &EffectInstance, free: &FreeParameter) -> Option<f64> {
    let stated = || Some(rig.parameters[rig.bent(placed, free.name)?].value);
    let Some(neutral) = free.neutral else { return stated() };
    let neutral = Some(rig.effect_unit(placed, free.name).difference_to_si(neutral));
    let in_circuit = matches!(placed.effect.form, Form::ParameterChange);
    let installed = || rig.effects.iter().any(|present| present.id == rig.effect_id(placed));
    if in_circuit && !installed() { stated().or(neutral) } else { neutral }
}

/// How far the typical size of an effect is from doing nothing, SI; `None` of a level. What the circuit has anyway, other than nothing, may
/// have as much more.
pub(super) fn typical(rig: &Rig, placed: &EffectInstance, free: &FreeParameter) -> Option<f64> {
    let first = rig.first_size(placed, free)?;
    let neutral = free.neutral.map(|neutral| rig.effect_unit(placed, free.name).difference_to_si(neutral));
    Some(first - neutral.or_else(|| nothing(rig, placed, free)).unwrap_or(0.0))
}

/// How large such an effect typically is, SI, 0 where it has no size: of a parameter that only shapes it, the value that is tried first.
pub(super) fn size(rig: &Rig, placed: &EffectInstance, free: &FreeParameter) -> f64 {
    let size = if free.neutral.is_some() { typical(rig, placed, free) } else { rig.first_size(placed, free) };
    size.map_or(0.0, f64::abs)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_the_circuit_has_of_it_may_be_as_much_more() {
        let text = std::fs::read_to_string("fixtures/telescopic/rig.toml").unwrap();
        let has = "\n[components.directional_valve]\n";
        let with = text.replacen(has, &format!("{has}dead_band = 0.1\n"), 1);
        for (text, from) in [(text, 0.0), (with, 0.1)] {
            let rig = Rig::parse("rig.toml", text).unwrap();
            let placed = rig.placed("spool-dead-band").unwrap();
            let free = &placed.effect.parameters[0];
            assert_eq!(nothing(&rig, &placed, free), Some(from));
            assert_eq!(typical(&rig, &placed, free), Some(0.05));
        }
    }
}
