//! All residuals that test a rig, over the channels that they share.

use super::find::generators;
use super::generator::{Generator, Variant};
use super::reading::Source;
use crate::rig::Rig;

/// The corrected residuals of a rig.
#[derive(Debug, Clone, Default)]
pub(super) struct Ensemble {
    /// Every channel that one of them reads, each once.
    pub sources: Vec<Source>,
    /// Each residual, with the index among `sources` of each of its readings.
    pub members: Vec<(Generator, Vec<usize>)>,
}

impl Ensemble {
    pub fn of(rig: &Rig) -> Self {
        let mut all = Self::default();
        for generator in generators(rig).into_iter().filter(|generator| generator.variant == Variant::Corrected) {
            let own = generator.sources().into_iter().map(|source| all.index(source)).collect();
            all.members.push((generator, own));
        }
        all
    }

    fn index(&mut self, source: Source) -> usize {
        self.sources.iter().position(|known| *known == source).unwrap_or_else(|| {
            self.sources.push(source);
            self.sources.len() - 1
        })
    }
}
