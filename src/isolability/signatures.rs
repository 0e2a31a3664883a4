//! The signature matrix: which residual answers to which fault, how strongly, at an operating point.

use serde::Serialize;

use crate::complaint::{Complaint, Kind};
use crate::model::{self, InputSignals};
use crate::number::{difference_in_unit, rounded};
use crate::record::Record;
use crate::residual::{self, Detection, Sensitivity};
use crate::rig::Rig;
use crate::simulation;
use crate::units::Unit;

/// One residual in one phase. Numbers in `unit`.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(feature = "internals", derive(schemars::JsonSchema))]
pub struct SignatureRow {
    /// Id of the residual.
    pub residual: String,
    /// The equation of the paper that it comes from.
    pub equation: &'static str,
    /// What it balances, in words.
    pub meaning: &'static str,
    /// Unit of the residual.
    pub unit: String,
    /// Position of the valve.
    pub phase: &'static str,
    /// Windows of the operating point that count.
    pub windows: usize,
    /// Standard deviation of one window by sensor noise.
    pub sigma: f64,
    /// Standard deviation of the mean over the phase by sensor noise.
    pub sigma_of_mean: f64,
    /// One standard deviation by what is uncertain but constant.
    pub tolerance: f64,
    /// Faults that it answers to.
    pub faults: Vec<Response>,
    /// Offsets and gains of sensors that it answers to and that are no faults of the rig.
    pub sensors: Vec<Response>,
}

/// How a residual answers to one parameter.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(feature = "internals", derive(schemars::JsonSchema))]
pub struct Response {
    /// Id of the parameter.
    pub id: String,
    /// Change of the parameter that `response` belongs to, in `unit`: from healthy to the far end of its range; for a
    /// sensor one standard deviation of its noise, or 1 % of gain.
    pub change: f64,
    /// Unit of the parameter.
    pub unit: String,
    /// Change of the residual, in its unit.
    pub response: f64,
    /// Change of the residual per `unit` of the parameter at its healthy value.
    pub slope: f64,
    /// `response` over noise of the mean and tolerance together.
    pub deviations: f64,
}

/// The healthy rig along a record's commands and loads, or along the cycle; `None` where there is neither.
///
/// # Errors
/// A record without the inputs; a healthy rig that cannot be simulated.
pub(super) fn operating_point(rig: &Rig, source: Option<&Record>) -> Result<Option<(InputSignals, Record)>, Complaint> {
    let (drive, times) = match simulation::drive(rig, source) {
        Ok(found) => found,
        Err(_) if source.is_none() => return Ok(None),
        Err(complaint) => return Err(complaint),
    };
    let outputs = rig.model().solve(&rig.healthy(), &drive, &times).map_err(|error| {
        Complaint::new(Kind::Computation, format!("the healthy rig could not be simulated: {error}"))
            .in_file(&rig.path)
            .help("look for values without physical sense in what is joined there; `borescope check` names those that no catalogue has")
    })?;
    let inputs = model::input_columns(rig, &drive, &times);
    let record = model::recording(rig, "simulated", times, inputs, &outputs, None);
    Ok(Some((drive, record)))
}

/// The matrix at the healthy readings of an operating point.
///
/// # Errors
/// Columns that are missing.
pub(super) fn rows(rig: &Rig, drive: &InputSignals, record: &Record) -> Result<Vec<SignatureRow>, Complaint> {
    let matrix = residual::signatures(rig, record, drive, Detection::default().window)?;
    let row = |signature: residual::Signature| {
        let unit = &signature.generator.unit;
        let (own, others): (Vec<&Sensitivity>, Vec<&Sensitivity>) = signature
            .answers
            .iter()
            .filter(|answer| answer.slope != 0.0 || answer.at_limit != 0.0)
            .partition(|answer| rig.is_fault(answer.index));
        let spread = signature.sigma_of_mean.hypot(signature.tolerance);
        let list = |answers: Vec<&Sensitivity>| answers.into_iter().map(|own| answer(rig, own, unit, spread)).collect();
        SignatureRow {
            residual: signature.generator.id.clone(),
            equation: signature.generator.equation,
            meaning: signature.generator.meaning,
            unit: unit.symbol.clone(),
            phase: signature.phase,
            windows: signature.windows,
            sigma: difference_in_unit(signature.sigma, unit),
            sigma_of_mean: difference_in_unit(signature.sigma_of_mean, unit),
            tolerance: difference_in_unit(signature.tolerance, unit),
            faults: list(own),
            sensors: list(others),
        }
    };
    Ok(matrix.into_iter().map(row).collect())
}

fn answer(rig: &Rig, answer: &Sensitivity, residual: &Unit, spread: f64) -> Response {
    let unit = &rig.parameters[answer.index].unit;
    Response {
        id: answer.parameter.clone(),
        change: difference_in_unit(answer.step, unit),
        unit: unit.symbol.clone(),
        response: difference_in_unit(answer.at_limit, residual),
        slope: rounded(residual.difference_from_si(answer.slope) / unit.difference_from_si(1.0), 9),
        deviations: rounded(answer.at_limit / spread, 4),
    }
}
