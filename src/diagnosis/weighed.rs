//! A record and a rig as a case, weighed by where the model has its events at a point.

use super::case::{Case, robust};
use super::events::weights_along;
use super::noise::Weights;
use crate::complaint::{Complaint, Kind, Place};
use crate::estimation::{FitError, LocalModel};
use crate::model::{InputSignals, Model};
use crate::record::{Channel, Record};
use crate::rig::Rig;

/// The columns of a record that the rig's sensors read, SI; NaN where there is no sample. Some may have none at all.
///
/// # Errors
/// A column that is missing or of another dimension, or not one that has a value.
pub fn measured<'a>(rig: &Rig, record: &'a Record) -> Result<Vec<&'a [f64]>, Complaint> {
    let channels = rig.sensors.iter().map(|sensor| rig.sensor_column(record, sensor));
    let channels: Vec<&Channel> = channels.collect::<Result<_, _>>()?;
    if channels.iter().all(|channel| channel.is_empty()) {
        return Err(Complaint::new(Kind::Empty, "no sensor of the rig has a value in any row")
            .at(record.header())
            .help("take a record that has values of its sensors; `check` says what it has"));
    }
    Ok(channels.into_iter().map(|channel| channel.values.as_slice()).collect())
}

/// A record and a rig whose weights are still to come.
pub(super) fn unweighed<'a>(
    model: &'a Model,
    record: &'a Record,
    drive: &'a InputSignals,
) -> Result<Case<'a>, Complaint> {
    let none = Weights::new(&model.rig, &[], &[], &[]);
    Ok(Case::new(model, record, drive, measured(&model.rig, record)?, none))
}

/// A record and a rig under given weights, or those of the model's events at `theta`, and the local model there.
pub(super) fn case_at<'a>(
    model: &'a Model,
    record: &'a Record,
    drive: &'a InputSignals,
    theta: &[f64],
    weights: Option<&Weights>,
) -> Result<(Case<'a>, LocalModel), Complaint> {
    let mut case = unweighed(model, record, drive)?;
    let form = match weights {
        Some(weights) => {
            case.full.weights = weights.clone();
            case.local_model(theta)
        }
        None => renewed(&mut case, theta),
    };
    let form = form.map_err(|error| unsolvable(model, record, error))?;
    Ok((case, form))
}

/// Renews the weights of a case at `theta`, and gives the form there.
pub(super) fn renewed(case: &mut Case<'_>, theta: &[f64]) -> Result<LocalModel, FitError> {
    let (weights, solved) = weights_along(&case.full, case.record, theta)?;
    case.full.weights = weights;
    LocalModel::of(&case.full, theta, case.full.linearised(theta, &solved), robust(case.rig()))
}

/// The complaint about a model that cannot be solved on a record.
pub(crate) fn unsolvable(model: &Model, record: &Record, error: impl Into<FitError>) -> Complaint {
    let error = error.into();
    Complaint::new(Kind::Computation, format!("the faults could not be fitted: {error}"))
        .at(Place::file(&model.rig.path))
        .at(Place::file(&record.path))
        .help("check values and units of the rig with `borescope check`")
}
