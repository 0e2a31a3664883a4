//! Minimal structurally overdetermined sets: the smallest groups of equations that can be tested.
//!
//! Source: M. Krysander, J. Åslund, M. Nyberg, "An efficient algorithm for finding minimal overconstrained subsystems
//! for model-based diagnosis", IEEE Trans. SMC A 38(1), 2008, algorithm 3.

use super::bits::Bits;
use super::lumped::{Lumped, sized, whole};
use super::matching::Decomposition;
use super::{Search, Structure};

/// Rows that may be walked over for each set that is asked for. No search of the rigs in `fixtures` ends there but that of twelve
/// cylinders, whose sets take 4,400 each: longer than anybody waits.
const ROWS_PER_SET: u64 = 500;

/// Every minimal structurally overdetermined set, or the first `limit` within the [`effort`] that they are worth. Each is one equation
/// more than it has unknowns and no part of it is.
pub fn mso_sets(structure: &Structure, limit: usize) -> Search {
    let rows = structure.rows();
    let parts = whole(&rows, structure.unknowns.len());
    sized!(parts.over.equations.len(), collect(&rows, &parts, limit), Search { sets: Vec::new(), complete: false })
}

/// How many such sets there are, counted up to `limit`, and whether the count came to its end.
pub fn count_mso(structure: &Structure, limit: usize) -> (usize, bool) {
    let rows = structure.rows();
    let parts = whole(&rows, structure.unknowns.len());
    sized!(parts.over.equations.len(), count(&rows, &parts, limit), (0, false))
}

fn collect<const W: usize>(rows: &[&[usize]], parts: &Decomposition, limit: usize) -> Search {
    let mut sets = Vec::new();
    let complete = start::<W>(rows, parts, effort(limit), &mut |set| {
        if sets.len() == limit {
            return false;
        }
        let mut equations = Vec::with_capacity(set.len());
        equations.extend(set.iter().map(|row| parts.over.equations[row]));
        sets.push(equations);
        true
    });
    Search { sets, complete }
}

fn count<const W: usize>(rows: &[&[usize]], parts: &Decomposition, limit: usize) -> (usize, bool) {
    let mut found = 0;
    let complete = start::<W>(rows, parts, effort(limit), &mut |_| {
        let more = found < limit;
        found += usize::from(more);
        more
    });
    (found, complete)
}

/// Rows that a search for so many sets may walk over.
pub(super) fn effort(limit: usize) -> u64 {
    ROWS_PER_SET.saturating_mul(limit as u64)
}

/// Walks through all sets; `visit` says whether to go on. `false` where it said no, or the effort is spent.
fn start<const W: usize>(
    rows: &[&[usize]],
    parts: &Decomposition,
    mut effort: u64,
    visit: &mut impl FnMut(Bits<W>) -> bool,
) -> bool {
    let set = Lumped::<W>::new(rows, parts);
    let all = set.rows();
    all.is_empty() || search(set, all, &mut effort, visit)
}

fn search<const W: usize>(
    mut set: Lumped<W>,
    allowed: Bits<W>,
    effort: &mut u64,
    visit: &mut impl FnMut(Bits<W>) -> bool,
) -> bool {
    let last = set.redundancy() == 2;
    let whole = set.equations(set.rows());
    if set.redundancy() == 1 {
        return visit(whole);
    }
    let (mut rest, mut later) = (allowed, Bits::EMPTY);
    while let Some(row) = rest.first() {
        // At redundancy 2 each class leaves a minimal set behind: nothing further will be taken from it, so none is
        // lumped.
        if !set.is_worth(effort) {
            return false;
        }
        let class = if last { set.class(row).0 } else { set.lump(row) };
        rest = rest.minus(&class);
        if class.is_subset(&allowed) {
            if !last {
                later.insert(row);
            } else if !visit(whole.minus(&set.equations(class))) {
                return false;
            }
        }
    }
    // A row passed over stays in every later set: so each set is met once.
    while let Some(row) = later.first() {
        later.remove(row);
        let mut smaller = set.clone();
        smaller.remove(row);
        if !search(smaller, later, effort, visit) {
            return false;
        }
    }
    true
}
