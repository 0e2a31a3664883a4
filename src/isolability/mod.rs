//! Which faults a rig and its sensors can tell apart: from the structure, and at an operating point by the residuals and by how
//! well they could be sized.

mod expected;
mod signatures;

use serde::Serialize;

use crate::complaint::Complaint;
use crate::record::Record;
use crate::rig::Rig;
use crate::structure::{Isolability, analyse};

pub use expected::{AssumedFault, Expectation, ExpectedWidth, TakenFault};
pub use signatures::SignatureRow;

/// Name and version of the JSON schema.
pub const SCHEMA: &str = "borescope.isolability/1";

/// Isolability as programs read it (`borescope.isolability/1`).
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(feature = "internals", derive(schemars::JsonSchema))]
pub struct IsolabilityReport {
    /// Name and version of the JSON schema: `borescope.isolability/1`.
    pub schema: &'static str,
    /// The rig file.
    pub rig: String,
    /// What follows from the structure alone.
    #[serde(flatten)]
    pub structure: Isolability,
    /// How residuals answer at the operating point; `None` without one.
    pub(crate) signatures: Option<Vec<SignatureRow>>,
    /// What a record there would say; `None` without one.
    pub expected: Option<Expectation>,
}

/// Analyses a rig at an operating point: along the inputs of `source`, or over the cycle of the rig file, with the faults of `with`
/// present. Without either there is the structure only.
///
/// # Errors
/// A record without the inputs, an operating point that cannot be simulated, a [context](crate::Context) that was cancelled.
pub fn isolability(rig: &Rig, source: Option<&Record>, with: &[TakenFault]) -> Result<IsolabilityReport, Complaint> {
    rig.context().run(|| {
        rig.context().stage("structure of the circuit");
        let structure = analyse(rig);
        rig.context().check()?;
        rig.context().stage("operating point");
        let point = signatures::operating_point(rig, source)?;
        let (signatures, expected) = match &point {
            Some((drive, record)) => {
                let rows = signatures::rows(rig, drive, record)?;
                (Some(rows), Some(expected::expectation(rig, drive, record, with)?))
            }
            None => (None, None),
        };
        Ok(IsolabilityReport { schema: SCHEMA, rig: rig.path.display().to_string(), structure, signatures, expected })
    })
}
