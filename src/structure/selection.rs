//! A small set of tests that tells apart whatever can be told apart.

/// How many partial choices the exact search looks at before it keeps the best so far.
const EFFORT: usize = 20_000;

/// Few of the tests, by their index, that detect and isolate as much as all of them together. `signatures` are tests by
/// faults.
///
/// Choosing tests is a minimum set cover, of the faults to detect and the pairs to tell apart. A greedy choice (the
/// test that settles most) bounds a branch and bound, which either proves the smallest number or gives up after a fixed
/// effort; the result is sorted and the same for the same input.
pub fn select(signatures: &[Vec<bool>]) -> Vec<usize> {
    let faults = signatures.first().map_or(0, Vec::len);
    // Tests with equal faults settle the same; the first stands for all.
    let mut distinct: Vec<usize> = Vec::new();
    for (test, faults) in signatures.iter().enumerate() {
        if !distinct.iter().any(|&other| signatures[other] == *faults) {
            distinct.push(test);
        }
    }
    let mut wanted: Vec<Vec<usize>> = Vec::new();
    for i in 0..faults {
        for j in 0..faults {
            // The pair of a fault with itself stands for its detection.
            let settles = |&test: &usize| signatures[test][i] && (i == j || !signatures[test][j]);
            let by: Vec<usize> = distinct.iter().copied().filter(settles).collect();
            if !by.is_empty() {
                wanted.push(by);
            }
        }
    }
    minimum_hitting_set(&wanted, signatures.len())
}

/// A smallest set of numbers below `members` that meets each of `sets`, or a small one where the proof takes too long.
pub fn minimum_hitting_set(sets: &[Vec<usize>], members: usize) -> Vec<usize> {
    // A set that contains another is met with it.
    let mut sorted: Vec<Vec<usize>> = sets.to_vec();
    sorted.iter_mut().for_each(|set| set.sort_unstable());
    sorted.sort_by_key(Vec::len);
    let mut needed: Vec<Vec<usize>> = Vec::new();
    for set in sorted {
        if !needed.iter().any(|small| small.iter().all(|member| set.binary_search(member).is_ok())) {
            needed.push(set);
        }
    }
    let mut search = Cover {
        hit_by: vec![Vec::new(); members],
        hits: vec![0; needed.len()],
        best: greedy(&needed, members),
        effort: 0,
        sets: needed,
    };
    for (index, set) in search.sets.iter().enumerate() {
        set.iter().for_each(|&member| search.hit_by[member].push(index));
    }
    search.descend(&mut Vec::new());
    search.best.sort_unstable();
    search.best
}

fn greedy(sets: &[Vec<usize>], members: usize) -> Vec<usize> {
    let mut left: Vec<&Vec<usize>> = sets.iter().filter(|set| !set.is_empty()).collect();
    let mut chosen = Vec::new();
    while !left.is_empty() {
        let mut count = vec![0usize; members];
        left.iter().for_each(|set| set.iter().for_each(|&member| count[member] += 1));
        let most = count.iter().copied().max().unwrap_or(0);
        let Some(best) = count.iter().position(|&count| count == most) else { break };
        left.retain(|set| !set.contains(&best));
        chosen.push(best);
    }
    chosen
}

struct Cover {
    sets: Vec<Vec<usize>>,
    hit_by: Vec<Vec<usize>>,
    /// How often each set is met by the choice so far.
    hits: Vec<usize>,
    best: Vec<usize>,
    effort: usize,
}

impl Cover {
    fn descend(&mut self, chosen: &mut Vec<usize>) {
        self.effort += 1;
        let unmet: Vec<usize> =
            (0..self.sets.len()).filter(|&set| self.hits[set] == 0 && !self.sets[set].is_empty()).collect();
        let Some(&hardest) = unmet.iter().min_by_key(|&&set| self.sets[set].len()) else {
            if chosen.len() < self.best.len() {
                self.best.clone_from(chosen);
            }
            return;
        };
        // Sets without a common member need one choice each.
        let mut taken = vec![false; self.hit_by.len()];
        let mut least = 0;
        for &set in &unmet {
            if self.sets[set].iter().all(|&member| !taken[member]) {
                self.sets[set].iter().for_each(|&member| taken[member] = true);
                least += 1;
            }
        }
        if chosen.len() + least >= self.best.len() || self.effort > EFFORT {
            return;
        }
        let mut members = self.sets[hardest].clone();
        let gain = |member: &usize| self.hit_by[*member].iter().filter(|&&set| self.hits[set] == 0).count();
        members.sort_by_cached_key(|member| std::cmp::Reverse(gain(member)));
        for member in members {
            for index in 0..self.hit_by[member].len() {
                self.hits[self.hit_by[member][index]] += 1;
            }
            chosen.push(member);
            self.descend(chosen);
            chosen.pop();
            for index in 0..self.hit_by[member].len() {
                self.hits[self.hit_by[member][index]] -= 1;
            }
        }
    }
}
