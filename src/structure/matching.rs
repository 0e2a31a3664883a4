//! Which equation is solved for which unknown, and what that leaves over.

use std::collections::VecDeque;

/// A largest set of pairs of equations and unknowns in which none appears twice.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Matching {
    /// Unknown that each equation is solved for.
    pub unknown_of: Vec<Option<usize>>,
    /// Equation that gives each unknown.
    pub equation_of: Vec<Option<usize>>,
}

/// Equations and the unknowns that belong to them.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Part {
    /// Sorted.
    pub equations: Vec<usize>,
    /// Sorted.
    pub unknowns: Vec<usize>,
}

/// The Dulmage-Mendelsohn decomposition of a structure.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Decomposition {
    /// More unknowns than equations.
    pub under: Part,
    /// As many equations as unknowns, in blocks that have to be solved together, in an order in which they can be
    /// solved.
    pub just: Vec<Part>,
    /// More equations than unknowns: the part that can be tested.
    pub over: Part,
    /// Which unknown each equation gives.
    pub matching: Matching,
}

const FAR: usize = usize::MAX;

/// A maximum matching of the equations in `keep` by Hopcroft and Karp. `rows` are the unknowns of each equation,
/// `unknowns` how many there are; equations outside `keep` stay unmatched. Time `O(E sqrt(V))`.
///
/// Source: J. E. Hopcroft, R. M. Karp, SIAM J. Comput. 2(4), 1973.
pub fn maximum<R: AsRef<[usize]>>(rows: &[R], keep: &[usize], unknowns: usize) -> Matching {
    let mut matching = Matching { unknown_of: vec![None; rows.len()], equation_of: vec![None; unknowns] };
    let mut depth = vec![FAR; rows.len()];
    let mut next = vec![0; rows.len()];
    let mut queue = VecDeque::new();
    loop {
        for &row in keep {
            next[row] = 0;
            depth[row] = FAR;
            if matching.unknown_of[row].is_none() {
                depth[row] = 0;
                queue.push_back(row);
            }
        }
        let mut found = false;
        while let Some(row) = queue.pop_front() {
            for &unknown in rows[row].as_ref() {
                match matching.equation_of[unknown] {
                    None => found = true,
                    // Only the shortest paths count in one phase.
                    Some(other) if !found && depth[other] == FAR => {
                        depth[other] = depth[row] + 1;
                        queue.push_back(other);
                    }
                    Some(_) => {}
                }
            }
        }
        if !found {
            return matching;
        }
        for &row in keep {
            if matching.unknown_of[row].is_none() {
                augment(rows, row, &depth, &mut next, &mut matching);
            }
        }
    }
}

/// Follows the layers from `root` to a free unknown and flips the path.
fn augment<R: AsRef<[usize]>>(
    rows: &[R],
    root: usize,
    depth: &[usize],
    next: &mut [usize],
    matching: &mut Matching,
) -> bool {
    let mut path = vec![root];
    while let Some(&row) = path.last() {
        let Some(&unknown) = rows[row].as_ref().get(next[row]) else {
            path.pop();
            if let Some(&above) = path.last() {
                next[above] += 1;
            }
            continue;
        };
        match matching.equation_of[unknown] {
            None => {
                for &row in &path {
                    let unknown = rows[row].as_ref()[next[row]];
                    matching.unknown_of[row] = Some(unknown);
                    matching.equation_of[unknown] = Some(row);
                }
                // What lies on a used path must not be used again in this phase.
                path.iter().for_each(|&row| next[row] = rows[row].as_ref().len());
                return true;
            }
            Some(other) if depth[other] == depth[row] + 1 && next[other] < rows[other].as_ref().len() => {
                path.push(other)
            }
            Some(_) => next[row] += 1,
        }
    }
    false
}

/// The Dulmage-Mendelsohn decomposition of the equations in `keep`, the just-determined part split into its strongly
/// connected blocks. Arguments as in [`maximum`].
///
/// Source: A. L. Dulmage, N. S. Mendelsohn, Canad. J. Math. 10, 1958; A. Pothen, C.-J. Fan, ACM TOMS 16(4), 1990.
pub fn decompose<R: AsRef<[usize]>>(rows: &[R], keep: &[usize], unknowns: usize) -> Decomposition {
    let matching = maximum(rows, keep, unknowns);
    let mut over_row = vec![false; rows.len()];
    let mut over_unknown = vec![false; unknowns];
    let mut queue: Vec<usize> = keep.iter().copied().filter(|&row| matching.unknown_of[row].is_none()).collect();
    queue.iter().for_each(|&row| over_row[row] = true);
    while let Some(row) = queue.pop() {
        for &unknown in rows[row].as_ref() {
            if !std::mem::replace(&mut over_unknown[unknown], true)
                && let Some(other) = matching.equation_of[unknown]
                && !std::mem::replace(&mut over_row[other], true)
            {
                queue.push(other);
            }
        }
    }
    let mut holders = vec![Vec::new(); unknowns];
    for &row in keep {
        rows[row].as_ref().iter().for_each(|&unknown| holders[unknown].push(row));
    }
    let mut under_row = vec![false; rows.len()];
    let mut under_unknown = vec![false; unknowns];
    let mut queue: Vec<usize> = (0..unknowns).filter(|&unknown| matching.equation_of[unknown].is_none()).collect();
    queue.iter().for_each(|&unknown| under_unknown[unknown] = true);
    while let Some(unknown) = queue.pop() {
        for &row in &holders[unknown] {
            if !std::mem::replace(&mut under_row[row], true)
                && let Some(other) = matching.unknown_of[row]
                && !std::mem::replace(&mut under_unknown[other], true)
            {
                queue.push(other);
            }
        }
    }
    let mut sorted = keep.to_vec();
    sorted.sort_unstable();
    let part = |row_in: &[bool], unknown_in: &[bool]| Part {
        equations: sorted.iter().copied().filter(|&row| row_in[row]).collect(),
        unknowns: (0..unknowns).filter(|&unknown| unknown_in[unknown]).collect(),
    };
    let rest: Vec<usize> = sorted.iter().copied().filter(|&row| !over_row[row] && !under_row[row]).collect();
    Decomposition {
        under: part(&under_row, &under_unknown),
        just: blocks(rows, &rest, &matching),
        over: part(&over_row, &over_unknown),
        matching,
    }
}

/// Strongly connected blocks of perfectly matched `rows_in`, each after those that it needs (Tarjan 1972, without
/// recursion).
fn blocks<R: AsRef<[usize]>>(rows: &[R], rows_in: &[usize], matching: &Matching) -> Vec<Part> {
    let mut order = vec![FAR; rows.len()];
    let mut low = vec![FAR; rows.len()];
    let mut open = vec![false; rows.len()];
    let mut member = vec![false; rows.len()];
    rows_in.iter().for_each(|&row| member[row] = true);
    let (mut stack, mut found, mut counter) = (Vec::new(), Vec::new(), 0);
    for &root in rows_in {
        if order[root] != FAR {
            continue;
        }
        let mut path = vec![(root, 0)];
        while let Some(&(row, position)) = path.last() {
            if order[row] == FAR {
                order[row] = counter;
                low[row] = counter;
                counter += 1;
                stack.push(row);
                open[row] = true;
            }
            if let Some(&unknown) = rows[row].as_ref().get(position) {
                match matching.equation_of[unknown].filter(|&other| member[other]) {
                    // The position stays: on the way back the other's low is known.
                    Some(other) if order[other] == FAR => path.push((other, 0)),
                    other => {
                        if let Some(other) = other.filter(|&other| open[other]) {
                            low[row] = low[row].min(low[other]);
                        }
                        path.last_mut().into_iter().for_each(|step| step.1 += 1);
                    }
                }
                continue;
            }
            path.pop();
            if low[row] == order[row] {
                let mut block = Part::default();
                while let Some(top) = stack.pop() {
                    open[top] = false;
                    block.equations.push(top);
                    block.unknowns.extend(matching.unknown_of[top]);
                    if top == row {
                        break;
                    }
                }
                block.equations.sort_unstable();
                block.unknowns.sort_unstable();
                found.push(block);
            }
        }
    }
    found
}
