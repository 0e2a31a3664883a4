//! What healthy records have taught about a rig: values with their covariance, kept beside the data sheet.

use nalgebra::DMatrix;

use super::Rig;

/// The `[calibration]` of a rig file. It overrides the data sheet: [`Rig::parameters`], the healthy values of faults, and
/// noise and tolerance of sensors hold it already.
#[derive(Debug, Clone, PartialEq)]
pub struct Calibration {
    /// The records that it was made from, as they were called.
    pub records: Vec<String>,
    /// What no circuit is quite without, and is uncertain in this one: see [`Rig::give_margin`].
    pub margins: Vec<String>,
    /// Parameters of how spools follow their commands, mean lags and dead times of inputs that were found, as indices.
    pub dynamics: Vec<usize>,
    /// Indices among the rig's parameters.
    pub parameters: Vec<usize>,
    /// Correlation of the calibrated values, in the order of `parameters`.
    pub correlation: DMatrix<f64>,
}

impl Rig {
    /// Covariance of what is known of these parameters before a record is seen, SI: the squares of their standard
    /// uncertainties, and what calibration has found to go together.
    pub fn covariance(&self, parameters: &[usize]) -> DMatrix<f64> {
        let originals: Vec<usize> = parameters.iter().map(|&parameter| self.original(parameter)).collect();
        let known = |original: &usize| self.calibration.as_ref()?.parameters.iter().position(|known| known == original);
        let place: Vec<Option<usize>> = originals.iter().map(known).collect();
        DMatrix::from_fn(parameters.len(), parameters.len(), |a, b| {
            let correlation = match (&self.calibration, place[a], place[b]) {
                _ if a == b => 1.0,
                (Some(calibration), Some(a), Some(b)) => calibration.correlation[(a, b)],
                _ if originals[a] == originals[b] => 1.0,
                _ => 0.0,
            };
            correlation * self.parameters[parameters[a]].sigma * self.parameters[parameters[b]].sigma
        })
    }
}
