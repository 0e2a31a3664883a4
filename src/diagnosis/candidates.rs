//! Which sets of faults are weighed.

use crate::rig::FaultSet;
use crate::settings::DiagnosisSettings;

/// Sets to be weighed: those of up to three faults, and those within two exchanges of the best one. Of a rig with many faults
/// sets of three are grown from the pairs that `score` puts first.
pub(super) fn candidates(
    settings: &DiagnosisSettings,
    faults: usize,
    centre: FaultSet,
    score: impl Fn(FaultSet) -> Option<f64>,
) -> Vec<FaultSet> {
    let mut sets = vec![FaultSet::EMPTY, centre];
    let mut pairs = Vec::new();
    for a in 0..faults {
        for b in 0..=a {
            pairs.push(FaultSet::of(a).with(b));
            let exchanged = centre.toggled(a);
            sets.extend([exchanged, if a == b { centre } else { exchanged.toggled(b) }]);
        }
    }
    sets.extend(&pairs);
    if faults > settings.triples_faults {
        let mut scored: Vec<(f64, FaultSet)> = pairs.iter().filter_map(|&pair| Some((score(pair)?, pair))).collect();
        scored.sort_by(|a, b| b.0.total_cmp(&a.0));
        pairs = scored.into_iter().take(settings.triples_pairs).map(|(_, pair)| pair).collect();
    }
    sets.extend(pairs.iter().flat_map(|pair| (0..faults).map(|fault| pair.with(fault))));
    sets.retain(|set| set.len() <= settings.combination_faults);
    sets.sort_unstable();
    sets.dedup();
    sets
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn all_sets_of_up_to_three_faults_are_weighed_where_they_are_few() {
        let sets = candidates(&DiagnosisSettings::default(), 5, FaultSet::EMPTY, |_| None);
        assert_eq!(sets.len(), 1 + 5 + 10 + 10);
        let near = candidates(&DiagnosisSettings::default(), 5, (0..5).collect(), |_| None);
        // Beside them: all five, each four of them; no set within two exchanges is smaller than three.
        assert_eq!(near.len(), 1 + 5 + 10 + 10 + 5 + 1);
    }

    #[test]
    fn sets_of_three_are_grown_from_promising_pairs_where_faults_are_many() {
        let truth: FaultSet = [3, 90, 210].into_iter().collect();
        let score = |pair: FaultSet| Some(-(truth.symmetric_difference(pair).len() as f64));
        let sets = candidates(&DiagnosisSettings::default(), 250, FaultSet::EMPTY, score);
        assert!(sets.binary_search(&truth).is_ok());
        assert!(sets.len() < 60_000, "{}", sets.len());
        assert!((0..250).all(|fault| sets.binary_search(&FaultSet::of(fault)).is_ok()));
    }
}
