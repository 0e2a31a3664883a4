//! Minimal test equation supports: the smallest groups of faults that some test answers to, and all equations it can
//! use.
//!
//! Source: M. Krysander, J. Åslund, E. Frisk, "A structural algorithm for finding testable sub-models and multiple
//! fault isolability analysis", 21st Workshop on Principles of Diagnosis (DX), 2010.

use super::bits::Bits;
use super::isolability::{Isolation, signatures};
use super::lumped::{Lumped, sized, whole};
use super::matching::{Decomposition, decompose};
use super::mso::{effort, mso_sets};
use super::{Search, Structure};

/// Every minimal test equation support, or the first `limit` within the [`effort`] that they are worth: overdetermined sets that no
/// further equation can join without bringing a further fault, and that hold no smaller such set with a fault. With the faults of all
/// of them, whatever can be isolated at all can be isolated.
pub fn mtes_sets(structure: &Structure, limit: usize) -> Search {
    let rows = structure.rows();
    let parts = whole(&rows, structure.unknowns.len());
    let faulty: Vec<bool> = structure.equations.iter().map(|equation| !equation.faults.is_empty()).collect();
    sized!(
        parts.over.equations.len(),
        collect(&rows, &faulty, &parts, limit),
        Search { sets: Vec::new(), complete: false }
    )
}

/// Supports that a search which ended early lacks: for each fault and each other that it can be isolated from, one that holds the first
/// and not the second, of as few faults as taking them out one after the other leaves.
pub fn lacking(structure: &Structure, sets: &[Vec<usize>], known: &Isolation) -> Vec<Vec<usize>> {
    let rows = structure.rows();
    let equation = structure.equation_of_fault();
    let over = |keep: &[usize]| decompose(&rows, keep, structure.unknowns.len()).over.equations;
    let without = |set: &[usize], left_out: usize| -> Vec<usize> {
        over(&set.iter().copied().filter(|&row| row != left_out).collect::<Vec<_>>())
    };
    let all: Vec<usize> = (0..rows.len()).collect();
    let (mut found, mut tests) = (Vec::new(), signatures(structure, sets));
    for (fault, own) in equation.iter().enumerate().filter(|&(fault, _)| known.detectable[fault]) {
        let Some(own) = *own else { continue };
        for (other, its) in equation.iter().enumerate() {
            let is_isolated = tests.iter().any(|test| test[fault] && (other == fault || !test[other]));
            if is_isolated || other != fault && known.explained_by[fault][other] {
                continue;
            }
            let mut set = match its {
                Some(its) if other != fault => without(&all, *its),
                _ => over(&all),
            };
            for &row in equation.iter().flatten().filter(|&&row| row != own) {
                let smaller = without(&set, row);
                if smaller.binary_search(&own).is_ok() {
                    set = smaller;
                }
            }
            tests.extend(signatures(structure, std::slice::from_ref(&set)));
            found.push(set);
        }
    }
    found
}

/// The smallest test within a test equation support: of the minimal overdetermined sets that hold a fault, one with the
/// fewest equations, sought among the first `limit`. It answers to the faults of `set` and uses the least of the model.
pub fn smallest_test(structure: &Structure, set: &[usize], limit: usize) -> Option<Vec<usize>> {
    let holds_fault =
        |test: &Vec<usize>| test.iter().any(|&equation| !structure.equations[set[equation]].faults.is_empty());
    let tests = mso_sets(&structure.only(set), limit).sets;
    let smallest = tests.into_iter().filter(holds_fault).min_by_key(Vec::len)?;
    Some(smallest.into_iter().map(|equation| set[equation]).collect())
}

fn collect<const W: usize>(rows: &[&[usize]], faulty: &[bool], parts: &Decomposition, limit: usize) -> Search {
    let set = Lumped::<W>::new(rows, parts);
    let mut faults = Bits::EMPTY;
    parts
        .over
        .equations
        .iter()
        .enumerate()
        .filter(|(_, equation)| faulty[**equation])
        .for_each(|(row, _)| faults.insert(row));
    let mut sets = Vec::new();
    let mut effort = effort(limit);
    let complete = faults.is_empty()
        || search(set, faults, faults, &mut effort, &mut |set| {
            if sets.len() == limit {
                return false;
            }
            sets.push(set.iter().map(|row| parts.over.equations[row]).collect());
            true
        });
    Search { sets, complete }
}

/// `faults` are the rows with faults, `allowed` those of them that may be taken out.
fn search<const W: usize>(
    mut set: Lumped<W>,
    faults: Bits<W>,
    allowed: Bits<W>,
    effort: &mut u64,
    visit: &mut impl FnMut(Bits<W>) -> bool,
) -> bool {
    let (mut rest, mut lumped, mut later) = (faults, Bits::EMPTY, Bits::EMPTY);
    while let Some(row) = rest.first() {
        if !set.is_worth(effort) {
            return false;
        }
        let class = set.lump(row);
        rest = rest.minus(&class);
        lumped.insert(row);
        if class.intersection(&faults).is_subset(&allowed) {
            later.insert(row);
        }
    }
    if lumped.len() == 1 {
        return visit(set.equations(set.rows()));
    }
    while let Some(row) = later.first() {
        later.remove(row);
        let mut smaller = set.clone();
        smaller.remove(row);
        let mut left = lumped;
        left.remove(row);
        if !search(smaller, left, later, effort, visit) {
            return false;
        }
    }
    true
}
