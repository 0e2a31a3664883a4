//! Pattern search: for the few things of which no sensitivity tells what they do, such as what drives the circuit.
//!
//! Source: Hooke and Jeeves, Journal of the ACM 8 (1961), 212.

use rayon::prelude::*;

/// How long a pattern is walked.
#[derive(Debug, Clone, Copy)]
pub struct Patience {
    /// Most moves, halvings among them.
    pub moves: usize,
    pub halvings: usize,
}

/// The point of least cost, from one with its cost: over the best of those `around` it, as far from it as a share of the first step says,
/// and half as far where none of them is better. A point without a cost is passed over.
pub fn pattern_search<P: Send + Sync>(
    start: (P, f64),
    patience: Patience,
    around: impl Fn(&P, f64) -> Vec<P>,
    cost: impl Fn(&P) -> Option<f64> + Sync,
) -> (P, f64) {
    let (mut best, mut share, mut halved) = (start, 1.0, 0);
    for _ in 0..patience.moves {
        match least(around(&best.0, share), &cost).filter(|next| next.1 < best.1) {
            Some(next) => best = next,
            None if halved == patience.halvings => break,
            None => {
                share *= 0.5;
                halved += 1;
            }
        }
    }
    best
}

/// The first point of least cost; `None` where none has one.
pub fn least<P: Send>(points: Vec<P>, cost: &(impl Fn(&P) -> Option<f64> + Sync)) -> Option<(P, f64)> {
    let costs = points.into_par_iter().filter_map(|point| cost(&point).map(|cost| (point, cost)));
    let costs: Vec<(P, f64)> = costs.collect();
    costs.into_iter().reduce(|best, next| if next.1 < best.1 { next } else { best })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_valley_is_walked_to_its_end_within_the_last_step() {
        let around = |&(x, y): &(f64, f64), share: f64| {
            let step = 0.4 * share;
            vec![(x - step, y), (x + step, y), (x, y - step), (x, y + step)]
        };
        // Nothing is known beyond x = 2: what lies there is passed over.
        let cost = |&(x, y): &(f64, f64)| (x < 2.0).then(|| (x - 1.0).powi(2) + 3.0 * (y + 0.5).powi(2));
        let walked = |moves| {
            let start = (3.0, 0.0);
            pattern_search((start, f64::INFINITY), Patience { moves, halvings: 5 }, around, cost)
        };
        // From 3 no neighbour has a cost until none is looked for any more.
        assert_eq!(walked(40), ((3.0, 0.0), f64::INFINITY));
        let near = pattern_search(((1.9, 0.0), 1.56), Patience { moves: 40, halvings: 5 }, around, cost);
        let step = 0.4 / 32.0;
        assert!((near.0.0 - 1.0).abs() < step && (near.0.1 + 0.5).abs() < step, "{near:?}");
        let once = pattern_search(((1.9, 0.0), 1.56), Patience { moves: 1, halvings: 5 }, around, cost);
        // The best of the four, not the first that is better.
        assert_eq!(once.0, (1.9, -0.4));
    }
}
