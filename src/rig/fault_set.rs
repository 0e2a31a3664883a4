//! Sets of faults of one rig.

use std::cmp::Ordering;
use std::fmt;

const WORDS: usize = 4;

/// A set of faults, each by its index among the rig's faults. Small and `Copy`, since thousands of sets are compared.
///
/// Sets are ordered by their highest fault first, so that a list of sets has one order on every machine.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Default)]
pub struct FaultSet {
    words: [u64; WORDS],
}

impl FaultSet {
    /// No fault: the healthy rig.
    pub const EMPTY: Self = Self { words: [0; WORDS] };
    /// Faults that a rig may have; a rig with more is refused.
    pub const CAPACITY: usize = WORDS * u64::BITS as usize;

    /// One fault alone.
    pub fn of(fault: usize) -> Self {
        Self::EMPTY.with(fault)
    }

    /// With one fault more.
    #[must_use]
    pub fn with(mut self, fault: usize) -> Self {
        debug_assert!(fault < Self::CAPACITY, "rigs with so many faults are refused");
        if let Some(word) = self.words.get_mut(fault / 64) {
            *word |= 1 << (fault % 64);
        }
        self
    }

    /// Without one fault.
    #[must_use]
    pub fn without(self, fault: usize) -> Self {
        self.difference(Self::of(fault))
    }

    /// With a fault that it does not hold, without one that it holds.
    #[must_use]
    pub fn toggled(self, fault: usize) -> Self {
        self.symmetric_difference(Self::of(fault))
    }

    pub fn contains(self, fault: usize) -> bool {
        self.words.get(fault / 64).is_some_and(|word| word >> (fault % 64) & 1 == 1)
    }

    /// Number of faults.
    pub fn len(self) -> usize {
        self.words.iter().map(|word| word.count_ones() as usize).sum()
    }

    pub fn is_empty(self) -> bool {
        self == Self::EMPTY
    }

    /// The faults, rising.
    pub fn iter(self) -> impl Iterator<Item = usize> {
        self.words.into_iter().enumerate().flat_map(|(place, mut word)| {
            std::iter::from_fn(move || {
                let lowest = word.trailing_zeros() as usize;
                word &= word.checked_sub(1)?;
                Some(64 * place + lowest)
            })
        })
    }

    /// Faults of either set.
    #[must_use]
    pub fn union(self, other: Self) -> Self {
        self.by_words(other, |a, b| a | b)
    }

    /// Faults that the other set does not hold.
    #[must_use]
    pub fn difference(self, other: Self) -> Self {
        self.by_words(other, |a, b| a & !b)
    }

    /// Faults of one of the two sets only.
    #[must_use]
    pub fn symmetric_difference(self, other: Self) -> Self {
        self.by_words(other, |a, b| a ^ b)
    }

    fn by_words(self, other: Self, join: impl Fn(u64, u64) -> u64) -> Self {
        Self { words: std::array::from_fn(|word| join(self.words[word], other.words[word])) }
    }
}

impl Ord for FaultSet {
    fn cmp(&self, other: &Self) -> Ordering {
        self.words.iter().rev().cmp(other.words.iter().rev())
    }
}

impl PartialOrd for FaultSet {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl FromIterator<usize> for FaultSet {
    fn from_iter<I: IntoIterator<Item = usize>>(faults: I) -> Self {
        faults.into_iter().fold(Self::EMPTY, Self::with)
    }
}

impl fmt::Debug for FaultSet {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_set().entries(self.iter()).finish()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn set(faults: &[usize]) -> FaultSet {
        faults.iter().copied().collect()
    }

    #[test]
    fn holds_faults_beyond_one_machine_word() {
        let all = set(&[0, 63, 64, 200, 255]);
        assert_eq!(all.iter().collect::<Vec<_>>(), [0, 63, 64, 200, 255]);
        assert_eq!(all.len(), 5);
        assert!(all.contains(200) && !all.contains(199) && !all.contains(10_000));
        assert_eq!(all.without(64).without(64), set(&[0, 63, 200, 255]));
        assert!(set(&[70]).without(70).is_empty());
    }

    #[test]
    fn set_operations_are_those_of_mathematics() {
        let (a, b) = (set(&[1, 70]), set(&[70, 130]));
        assert_eq!(a.union(b), set(&[1, 70, 130]));
        assert_eq!(a.difference(b), set(&[1]));
        assert_eq!(a.symmetric_difference(b), set(&[1, 130]));
        assert_eq!(a.toggled(1).toggled(2), set(&[2, 70]));
    }

    #[test]
    fn the_highest_fault_decides_the_order() {
        let mut sets = [set(&[130]), set(&[0, 1, 2]), set(&[64]), FaultSet::EMPTY, set(&[3])];
        sets.sort_unstable();
        assert_eq!(sets, [FaultSet::EMPTY, set(&[0, 1, 2]), set(&[3]), set(&[64]), set(&[130])]);
    }
}
