//! What may spare questions about a record.

use super::Diagnosed;
use super::data_sheet::Sparing;
use super::estimate::Estimate;
use crate::complaint::Complaint;

/// Physics that the model lacks, asked about a record that declared faults miss, ahead of values that nobody declared, of a beginning
/// within the record and of parts that deviate.
pub(crate) trait Physics: Sync {
    /// Whether it explains what an estimate with declared faults does not.
    ///
    /// # Errors
    /// A [context](crate::Context) that was cancelled.
    fn explains(&self, first: &Estimate<'_>) -> Result<bool, Complaint>;

    /// Whether it was found to.
    fn has_explained(&self) -> bool;
}

/// What may spare questions about a record.
#[derive(Clone, Copy, Default)]
pub(super) struct Spared<'a> {
    /// Parts that deviate: the question which value is misstated.
    pub sparing: Option<&'a Sparing<'a>>,
    /// Physics that is missing: the same, beginnings within the record, and parts that deviate.
    pub physics: Option<&'a dyn Physics>,
}

impl Spared<'_> {
    /// Whether physics explains what an explanation leaves, so that no other is looked for.
    pub fn by_physics(&self, found: &Diagnosed) -> bool {
        !found.diagnosis.is_explained() && self.physics.is_some_and(Physics::has_explained)
    }
}
