//! Which sets of faults are weighed.

use crate::rig::FaultSet;

/// Most faults of a set: what more of them explain is as well explained by a wrong model.
const MOST_OF_ALL: usize = 5;
/// Faults of which all sets of three are weighed: so many have 9,880 of them, which takes as long as one simulation.
const ALL_TRIPLES: usize = 40;
/// Pairs of which sets of three are grown where there are more faults: as many sets again, of 250 faults.
const GROWN: usize = 40;

/// Sets to be weighed: those of up to three faults, and those within two exchanges of the best one. Of a rig with many faults
/// sets of three are grown from the pairs that `score` puts first.
pub(super) fn candidates(faults: usize, centre: FaultSet, score: impl Fn(FaultSet) -> Option<f64>) -> Vec<FaultSet> {
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
    if faults > ALL_TRIPLES {
        let mut scored: Vec<(f64, FaultSet)> = pairs.iter().filter_map(|&pair| Some((score(pair)?, pair))).collect();
        scored.sort_by(|a, b| b.0.total_cmp(&a.0));
        pairs = scored.into_iter().take(GROWN).map(|(_, pair)| pair).collect();
    }
    sets.extend(pairs.iter().flat_map(|pair| (0..faults).map(|fault| pair.with(fault))));
    sets.retain(|set| set.len() <= MOST_OF_ALL);
    sets.sort_unstable();
    sets.dedup();
    sets
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn all_sets_of_up_to_three_faults_are_weighed_where_they_are_few() {
        let sets = candidates(5, FaultSet::EMPTY, |_| None);
        assert_eq!(sets.len(), 1 + 5 + 10 + 10);
        let near = candidates(5, (0..5).collect(), |_| None);
        // Beside them: all five, each four of them; no set within two exchanges is smaller than three.
        assert_eq!(near.len(), 1 + 5 + 10 + 10 + 5 + 1);
    }

    #[test]
    fn sets_of_three_are_grown_from_promising_pairs_where_faults_are_many() {
        let truth: FaultSet = [3, 90, 210].into_iter().collect();
        let score = |pair: FaultSet| Some(-(truth.symmetric_difference(pair).len() as f64));
        let sets = candidates(250, FaultSet::EMPTY, score);
        assert!(sets.binary_search(&truth).is_ok());
        assert!(sets.len() < 60_000, "{}", sets.len());
        assert!((0..250).all(|fault| sets.binary_search(&FaultSet::of(fault)).is_ok()));
    }
}
