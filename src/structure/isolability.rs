//! Which faults can be seen, and which can be told apart.

use super::Structure;
use super::matching::decompose;

/// What can be said of single faults.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Isolation {
    /// Per fault: whether some test answers to it.
    pub detectable: Vec<bool>,
    /// Faults by faults: `explained_by[i][j]` where fault `j` explains everything that fault `i` does, so that `i`
    /// cannot be isolated from `j`. The diagonal is true. A fault that cannot be detected is explained by every other.
    pub explained_by: Vec<Vec<bool>>,
}

impl Isolation {
    /// Groups of detectable faults that explain each other, in the order of the faults; a fault that stands alone is a
    /// group of one.
    pub fn groups(&self) -> Vec<Vec<usize>> {
        let mut groups: Vec<Vec<usize>> = Vec::new();
        for fault in (0..self.detectable.len()).filter(|&fault| self.detectable[fault]) {
            let same = |group: &&mut Vec<usize>| {
                group.iter().all(|&other| self.explained_by[fault][other] && self.explained_by[other][fault])
            };
            match groups.iter_mut().find(same) {
                Some(group) => group.push(fault),
                None => groups.push(vec![fault]),
            }
        }
        groups
    }
}

/// The best that any tests can do: fault `i` is detectable if its equation is in the overdetermined part, and isolable
/// from `j` if it is still there without the equation of `j`.
///
/// Source: M. Krysander, E. Frisk, "Sensor placement for fault diagnosis", IEEE Trans. SMC A 38(6), 2008, theorems 1
/// and 2.
pub fn isolation(structure: &Structure) -> Isolation {
    let structure = &structure.one_equation_per_fault();
    let rows = structure.rows();
    let equation = structure.equation_of_fault();
    let over_without = |left_out: Option<usize>| {
        let keep: Vec<usize> = (0..rows.len()).filter(|&row| Some(row) != left_out).collect();
        let over = decompose(&rows, &keep, structure.unknowns.len()).over.equations;
        equation.iter().map(|e| e.is_some_and(|e| over.binary_search(&e).is_ok())).collect::<Vec<bool>>()
    };
    let detectable = over_without(None);
    let mut explained_by = vec![vec![true; equation.len()]; equation.len()];
    for (j, left_out) in equation.iter().enumerate() {
        let seen = if left_out.is_some() { over_without(*left_out) } else { detectable.clone() };
        for (i, seen) in seen.into_iter().enumerate() {
            explained_by[i][j] = i == j || !seen;
        }
    }
    Isolation { detectable, explained_by }
}

/// Tests by faults: whether each set of equations holds each fault. A test answers to the faults of its equations.
pub fn signatures(structure: &Structure, sets: &[Vec<usize>]) -> Vec<Vec<bool>> {
    sets.iter()
        .map(|set| {
            let mut holds = vec![false; structure.faults.len()];
            for &equation in set {
                structure.equations[equation].faults.iter().for_each(|&fault| holds[fault] = true);
            }
            holds
        })
        .collect()
}

/// What given tests can do: fault `i` is isolable from `j` if some test answers to `i` and not to `j`. `signatures` are
/// tests by faults, of which there are `faults`.
#[cfg(feature = "internals")]
pub fn isolation_by_tests(signatures: &[Vec<bool>], faults: usize) -> Isolation {
    let tells = |i: usize, j: usize| signatures.iter().any(|test| test[i] && !test[j]);
    Isolation {
        detectable: (0..faults).map(|fault| signatures.iter().any(|test| test[fault])).collect(),
        explained_by: (0..faults).map(|i| (0..faults).map(|j| i == j || !tells(i, j)).collect()).collect(),
    }
}
