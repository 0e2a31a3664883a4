//! From an explanation and its intervals to the diagnosis of a record.

use super::data_sheet;
use super::estimate::Estimate;
use super::problem::over_sensors;
use super::result::{Diagnosis, FitReport, Verdict};
use super::{DIGITS, Diagnosed, SCHEMA, alike, fitted, hypotheses, missed, onset, summary};
use crate::estimation::Interval;
use crate::model::Model;
use crate::number::rounded;
use crate::record::survey::Finding;
use crate::residual::{Detection, ResidualReport};

/// What was seen of a record beside its explanation.
pub(super) struct Seen<'s> {
    pub residuals: Vec<ResidualReport>,
    pub left_out: Vec<Finding>,
    /// The moment at which the faults begin within the record, s.
    pub onset: Option<f64>,
    pub detection: &'s Detection,
}

/// The diagnosis with the curves behind it. `model`: with parameters as they are from the first row on.
pub(super) fn reported(
    model: &Model,
    estimate: &Estimate<'_>,
    intervals: Vec<Option<Interval>>,
    seen: Seen<'_>,
) -> Diagnosed {
    let (case, isolation) = (&estimate.case, &estimate.isolation);
    let (rig, full) = (&model.rig, &case.full);
    let curves = |model: &Model, theta: &[f64]| {
        let solved = model.solve(&full.parameters(theta), full.drive, full.times);
        solved.map(|outputs| outputs.values).unwrap_or_default()
    };
    let (outputs, healthy) = (curves(full.model, &isolation.best.theta), curves(model, &case.mean));
    let misfit: Vec<Vec<f64>> = full.series().into_iter().map(|range| isolation.best.misfit[range].to_vec()).collect();
    let channels = summary::channels(estimate, &outputs, &healthy);
    let adequate = channels.iter().all(|channel| channel.adequate);
    let faults = summary::faults(estimate, &intervals, &isolation.of_faults(case.faults()), !adequate);
    let verdict = match (adequate, faults.iter().any(|fault| fault.present)) {
        (false, _) => Verdict::ModelInadequate,
        (true, true) => Verdict::Faulty,
        (true, false) => Verdict::Healthy,
    };
    let alarms = seen.residuals.iter().filter_map(|residual| residual.alarm_at_s);
    let detected_at_s = match verdict {
        Verdict::Healthy => None,
        _ => alarms.reduce(f64::min).or_else(|| onset::parted_at(estimate, seen.detection)),
    };
    let samples = full.weights.all_samples().saturating_sub(rig.faults.len()).max(1) as f64;
    let id = |fault: usize| rig.fault_id(fault).to_owned();
    let measured = channels.iter().map(|channel| (channel.samples > 0).then_some(channel.times_noise));
    let weighed = rig.sensors.iter().enumerate().map(|(index, sensor)| {
        let misfit = outputs.get(index)?.iter().zip(full.measured[index]).map(|(model, measured)| model - measured);
        Some(full.weights.mean_square(index, misfit)?.sqrt() / sensor.noise)
    });
    // What explains nothing has no like.
    let is_present = |&fault: &usize| adequate && faults.get(fault).is_some_and(|one| one.present);
    let present: Vec<usize> = (0..rig.faults.len()).filter(is_present).collect();
    let alike = alike::alike(estimate, &present).into_iter().map(|(fault, values)| {
        let values = values.into_iter().map(|value| rig.parameters[value].id.clone());
        std::iter::once(id(fault)).chain(values).collect()
    });
    let alike = alike.collect();
    let groups = hypotheses::ambiguity(isolation, case);
    let (parameters, correlation) = fitted::fitted(estimate);
    let diagnosis = Diagnosis {
        schema: SCHEMA,
        rig: rig.path.display().to_string(),
        record: case.record.path.display().to_string(),
        verdict,
        common_cause: None,
        missing_effect: None,
        off_data_sheet: None,
        undeclared: Vec::new(),
        dynamics: Vec::new(),
        rival_effects: Vec::new(),
        times_noise: rounded(over_sensors(measured), DIGITS),
        times_noise_weighed: rounded(over_sensors(weighed), DIGITS),
        detected_at_s,
        onset_s: seen.onset.map(|time| rounded(time, DIGITS)),
        ambiguity: groups.into_iter().map(|group| group.into_iter().map(id).collect()).collect(),
        alike,
        hypotheses: isolation.hypotheses(case),
        residuals: seen.residuals,
        fit: FitReport {
            chi2_reduced: misfit.iter().map(|channel| missed::tame_squares(case.settings(), channel)).sum::<f64>()
                / samples,
            iterations: isolation.rounds,
            solves: full.solves(),
            stopped_because: isolation.stopped.to_string(),
            parameters,
            correlation,
            profiles: fitted::profiles(estimate, &faults, &intervals),
        },
        channels,
        uncertain: summary::uncertain(estimate),
        taken_as_exact: rig.exact_by_sheet().into_iter().map(|index| rig.parameters[index].id.clone()).collect(),
        as_new: data_sheet::as_new(rig, &faults),
        below_vacuum: full.model.below_vacuum(&full.parameters(&isolation.best.theta), full.drive, full.times),
        at_odds: Vec::new(),
        unfilled: rig.unfilled.len(),
        left_out: seen.left_out,
        faults,
    };
    Diagnosed {
        diagnosis,
        model: outputs,
        healthy,
        misfit,
        weights: full.weights.clone(),
        intervals,
        corrected: None,
        other_rig: None,
        evidence: isolation.evidence(case),
        occam: estimate.occam(),
    }
}
