//! What was fitted, as those who fit models themselves ask for it: estimates, standard errors, their correlation, profiles.

use super::DIGITS;
use super::estimate::Estimate;
use super::result::{FaultReport, FittedReport, ProfileReport};
use crate::estimation::Interval;
use crate::number::rounded;

/// Digits of a correlation and of a rise.
const SHARE: usize = 4;

/// Present faults and uncertain parameters as fitted, and their correlation, row by row; both empty where the fit has none.
pub(super) fn fitted(estimate: &Estimate<'_>) -> (Vec<FittedReport>, Vec<Vec<f64>>) {
    let (case, isolation) = (&estimate.case, &estimate.isolation);
    let rig = case.rig();
    let Ok(known) = case.information(&isolation.local, isolation.set()) else { return (Vec::new(), Vec::new()) };
    let covariance = known.covariance();
    let own = |index: usize| case.full.estimated[index].parameter;
    let is_named = |index: &usize| rig.original(own(*index)) == own(*index) && covariance[(*index, *index)] > 0.0;
    let free: Vec<usize> = (0..case.count()).filter(is_named).collect();
    let report = |&index: &usize| {
        let parameter = &rig.parameters[own(index)];
        let error = covariance[(index, index)].sqrt() * isolation.local.scale[index];
        FittedReport {
            id: parameter.id.clone(),
            value: rounded(parameter.unit.from_si(isolation.best.theta[index]), DIGITS),
            unit: parameter.unit.symbol.clone(),
            standard_error: rounded(parameter.unit.difference_from_si(error), DIGITS),
            fault: index < case.faults() && isolation.set().contains(index),
        }
    };
    let correlation = |&a: &usize| {
        let one = |&b: &usize| covariance[(a, b)] / (covariance[(a, a)] * covariance[(b, b)]).sqrt();
        free.iter().map(|b| rounded(one(b), SHARE)).collect()
    };
    (free.iter().map(report).collect(), free.iter().map(correlation).collect())
}

/// The profiles of the faults that are present.
pub(super) fn profiles(
    estimate: &Estimate<'_>,
    faults: &[FaultReport],
    intervals: &[Option<Interval>],
) -> Vec<ProfileReport> {
    let rig = estimate.case.rig();
    let each = rig.faults.iter().zip(faults).zip(intervals).filter(|((_, report), _)| report.present);
    each.filter_map(|((fault, report), interval)| {
        let interval = interval.as_ref()?;
        let unit = &rig.parameters[fault.parameter].unit;
        let point =
            |value: f64, rise: f64| [rounded(unit.from_si(value), DIGITS), rounded(rise / interval.inflation(), SHARE)];
        let points = interval.points.iter().map(|one| point(one.value, one.rise)).collect();
        Some(ProfileReport { id: report.id.clone(), unit: report.unit.clone(), points })
    })
    .collect()
}
