//! Overdetermined parts with their equivalence classes lumped: what both searches walk through.

use super::bits::Bits;
use super::matching::{Decomposition, decompose};

/// A proper structurally overdetermined set: every equation can be spared for some other to be tested.
///
/// Its rows are equations, or several that are only ever removed together (an equivalence class, lumped into one row
/// without the unknowns that only they hold). A matching that covers every unknown is kept from set to set, so that
/// each step needs one alternating path and one sweep.
#[derive(Clone)]
pub struct Lumped<const W: usize> {
    /// Unknowns of each row.
    unknowns: Vec<Bits<W>>,
    /// Equations that each row stands for.
    equations: Vec<Bits<W>>,
    alive: Bits<W>,
    /// Rows that are solved for nothing; as many as the redundancy.
    free: Bits<W>,
    row_of: Vec<u16>,
    unknown_of: Vec<u16>,
}

impl<const W: usize> Lumped<W> {
    /// The overdetermined part of a decomposed structure, its equations numbered by their place in `over.equations`. It
    /// must have at most `64 * W` equations.
    pub fn new<R: AsRef<[usize]>>(rows: &[R], parts: &Decomposition) -> Self {
        let over = &parts.over;
        let number = |unknown: &usize| over.unknowns.binary_search(unknown).ok();
        let mut set = Self {
            unknowns: Vec::new(),
            equations: Vec::new(),
            alive: Bits::EMPTY,
            free: Bits::EMPTY,
            row_of: vec![0; over.unknowns.len()],
            unknown_of: vec![u16::MAX; over.equations.len()],
        };
        for (row, &equation) in over.equations.iter().enumerate() {
            let (mut unknowns, mut equations) = (Bits::EMPTY, Bits::EMPTY);
            rows[equation].as_ref().iter().filter_map(number).for_each(|unknown| unknowns.insert(unknown));
            equations.insert(row);
            set.unknowns.push(unknowns);
            set.equations.push(equations);
            set.alive.insert(row);
            match parts.matching.unknown_of[equation].as_ref().and_then(number) {
                Some(unknown) => {
                    set.row_of[unknown] = row as u16;
                    set.unknown_of[row] = unknown as u16;
                }
                None => set.free.insert(row),
            }
        }
        set
    }

    /// Equations less unknowns.
    pub fn redundancy(&self) -> usize {
        self.free.len()
    }

    pub fn rows(&self) -> Bits<W> {
        self.alive
    }

    /// Takes what one walk over the rows costs from an effort, in rows; whether there was so much left.
    pub fn is_worth(&self, effort: &mut u64) -> bool {
        let left = effort.checked_sub(self.alive.len() as u64);
        *effort = left.unwrap_or(0);
        left.is_some()
    }

    /// The equations of these rows.
    pub fn equations(&self, rows: Bits<W>) -> Bits<W> {
        rows.iter().fold(Bits::EMPTY, |all, row| all.union(&self.equations[row]))
    }

    /// Makes `row` one of the free rows, by an alternating path from another.
    fn release(&mut self, row: usize) {
        if self.free.contains(row) {
            return;
        }
        let target = usize::from(self.unknown_of[row]);
        let mut parent = [[0u16; 64]; W];
        let (mut seen, mut open) = (Bits::<W>::EMPTY, self.free);
        while let Some(at) = open.first() {
            open.remove(at);
            let new = self.unknowns[at].minus(&seen);
            seen = seen.union(&new);
            for unknown in new.iter() {
                parent[unknown / 64][unknown % 64] = at as u16;
                open.insert(usize::from(self.row_of[unknown]));
            }
            if seen.contains(target) {
                break;
            }
        }
        let mut unknown = target;
        loop {
            let at = parent[unknown / 64][unknown % 64];
            let before = std::mem::replace(&mut self.unknown_of[usize::from(at)], unknown as u16);
            self.row_of[unknown] = at;
            if self.free.contains(usize::from(at)) {
                self.free.remove(usize::from(at));
                break;
            }
            unknown = usize::from(before);
        }
        self.free.insert(row);
    }

    /// The equivalence class of `row`: the rows that leave the overdetermined part together with it; and the unknowns
    /// that stay there. `row` is free afterwards.
    pub fn class(&mut self, row: usize) -> (Bits<W>, Bits<W>) {
        self.release(row);
        let mut open = self.free;
        open.remove(row);
        let (mut rows, mut unknowns) = (open, Bits::<W>::EMPTY);
        while let Some(at) = open.first() {
            open.remove(at);
            let new = self.unknowns[at].minus(&unknowns);
            unknowns = unknowns.union(&new);
            for unknown in new.iter() {
                let other = usize::from(self.row_of[unknown]);
                rows.insert(other);
                open.insert(other);
            }
        }
        (self.alive.minus(&rows), unknowns)
    }

    /// Puts the equivalence class of `row` into its place; what rows that were.
    pub fn lump(&mut self, row: usize) -> Bits<W> {
        let (class, stay) = self.class(row);
        if class.len() > 1 {
            let held = class.iter().fold(Bits::EMPTY, |all, other| self.unknowns[other].union(&all));
            self.unknowns[row] = held.intersection(&stay);
            self.equations[row] = self.equations(class);
            self.alive = self.alive.minus(&class);
            self.alive.insert(row);
        }
        class
    }

    /// Takes out a row that is an equivalence class by itself; what remains is overdetermined throughout.
    pub fn remove(&mut self, row: usize) {
        self.release(row);
        self.free.remove(row);
        self.alive.remove(row);
    }
}

/// The overdetermined part of all of `rows`.
pub fn whole<R: AsRef<[usize]>>(rows: &[R], unknowns: usize) -> Decomposition {
    let keep: Vec<usize> = (0..rows.len()).collect();
    decompose(rows, &keep, unknowns)
}

/// Calls `$search::<W>($argument...)` with the least number of words for `$size` members, or gives `$else`.
macro_rules! sized {
    ($size:expr, $search:ident($($argument:expr),*), $otherwise:expr) => {
        match $size {
            0..=64 => $search::<1>($($argument),*),
            65..=128 => $search::<2>($($argument),*),
            129..=256 => $search::<4>($($argument),*),
            257..=512 => $search::<8>($($argument),*),
            513..=1024 => $search::<16>($($argument),*),
            _ => $otherwise,
        }
    };
}
pub(super) use sized;
