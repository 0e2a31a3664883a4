//! A candidate: an effect that might be missing, with what the score test says of it.

use super::departure::{nothing, typical};
use crate::physics::effect::{FreeParameter, InitialGuess};
use crate::rig::{EffectInstance, ParameterSetting, Rig};

/// A candidate with what the score test says of it.
#[derive(Debug, Clone)]
pub struct Candidate {
    /// `kind@place`.
    pub id: String,
    pub placed: EffectInstance,
    /// Its parameters as they were tried, SI, in the order of the effect.
    pub tried: Vec<ParameterSetting>,
    /// Expected fall of chi-square.
    pub score: f64,
    /// Where it was scored, as an index into the base points; `None` where it was not.
    pub base_point: Option<usize>,
    /// Factor on the tried size at which chi-square would be least.
    pub factor: f64,
    /// Smallest factor on the tried size that the record could show: that from which on it would be looked at.
    pub smallest: f64,
    /// Share of its influence that nothing fitted can take over; 0 is absorbed.
    pub own: f64,
    /// The fitted parameter that takes over most of it, where little is left.
    pub absorbed_by: Option<String>,
    /// Whether the record responds to it at all.
    pub excited: bool,
    /// The same from other pressures or levels on, where it begins at one.
    pub others: Vec<Self>,
}

impl Candidate {
    /// In its typical size, to be fitted from anywhere. A curve without a formula has none but the height that it is tried at.
    pub(super) fn as_typical(&self, rig: &Rig) -> Self {
        let typical = |(free, tried): (&FreeParameter, &ParameterSetting)| match free.first {
            _ if self.placed.effect.empirical => tried.clone(),
            // Where it begins was found.
            InitialGuess::Onset(_) => tried.clone(),
            _ => {
                let typical = typical(rig, &self.placed, free);
                let value = nothing(rig, &self.placed, free).zip(typical).map(|(from, typical)| from + typical);
                let value = value.or_else(|| rig.first_size(&self.placed, free)).unwrap_or(tried.value);
                ParameterSetting { value, ..tried.clone() }
            }
        };
        let tried = self.placed.effect.parameters.iter().zip(&self.tried).map(typical).collect();
        Self { tried, factor: 1.0, base_point: None, ..self.clone() }
    }
}

/// Curves without a formula at every place, as if tried at their typical size.
pub fn empirical(rig: &Rig) -> Vec<Candidate> {
    let places = rig.distinct(rig.effect_places()).into_iter().filter(|placed| placed.effect.empirical);
    places
        .map(|placed| {
            let one = |free: &FreeParameter| {
                let value = rig.first_size(&placed, free).unwrap_or(0.0);
                ParameterSetting { name: free.name.to_owned(), value, sigma: 0.0 }
            };
            Candidate {
                id: rig.effect_id(&placed),
                placed,
                tried: placed.effect.parameters.iter().map(one).collect(),
                score: 0.0,
                base_point: None,
                factor: 0.0,
                smallest: f64::INFINITY,
                own: 1.0,
                absorbed_by: None,
                excited: true,
                others: Vec::new(),
            }
        })
        .collect()
}
