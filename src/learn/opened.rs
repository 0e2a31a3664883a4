//! Effects of a rig file that a record is to say the size of, whatever the file says.

use super::departure::nothing;
use super::refit::range_deviation;
use crate::physics::effect::FreeParameter;
use crate::rig::{EffectInstance, Rig};

/// A rig whose effects are open: what it states of their size with an uncertainty is where a fit starts, and no knowledge. It may come
/// from the same record, and from a model that lacked what is added now. What a calibration has found is known.
pub(super) fn opened(rig: &Rig) -> Rig {
    let mut open = rig.clone();
    let calibrated = rig.calibration.as_ref().map_or(&[][..], |known| &known.parameters);
    for effect in &rig.effects {
        for (free, &index) in effect.placed.effect.parameters.iter().zip(&effect.parameters) {
            if rig.parameters[index].sigma > 0.0 && !calibrated.contains(&index) {
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

#[cfg(test)]
mod tests {
    use nalgebra::DMatrix;

    use super::*;
    use crate::rig::Calibration;

    #[test]
    fn what_a_file_states_is_open_and_what_a_calibration_has_found_is_known() {
        let text = std::fs::read_to_string("fixtures/telescopic/rig.toml").unwrap();
        let effect = "\n[effects]\n\"seal-friction@cylinder\" = { coulomb = \"100 N +- 2 N\" }\n";
        let mut rig = Rig::parse(std::path::Path::new("rig.toml"), text + effect).unwrap();
        let coulomb = rig.parameter("seal-friction@cylinder.coulomb").unwrap();
        assert!(opened(&rig).parameters[coulomb].sigma > 100.0);
        rig.calibration = Some(Calibration {
            records: Vec::new(),
            margins: Vec::new(),
            dynamics: Vec::new(),
            parameters: vec![coulomb],
            correlation: DMatrix::identity(1, 1),
        });
        assert_eq!(opened(&rig).parameters[coulomb].sigma, 2.0);
    }
}
