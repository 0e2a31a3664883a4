//! Calibration: what a data sheet never gets right, learnt from healthy records.
//!
//! [`calibrate`] fits every parameter that a part may have otherwise than its data sheet (or that is stated as uncertain)
//! to all healthy records together, with the data sheet as prior; noise of the sensors and tolerance of the model are
//! estimated along. The result is a rig file with a `[calibration]`, which later fits take as prior with its covariance.
//!
//! One round is: noise from the fast part of the misfit, tolerance from the levels of its phases, what the model lacks beyond both,
//! weights from all three, and the most probable parameters under them. Rounds end when none of it moves any more.

mod along;
mod clusters;
mod first_fits;
mod harm;
mod joint;
mod lack_of_fit;
mod lags;
mod noise;
mod plain_error;
mod principal;
mod report;
mod result;
mod rounds;
mod switching;
mod tolerance;
mod valleys;
mod write;

use nalgebra::{DMatrix, DVector};

use crate::complaint::{Complaint, Kind, Place};
use crate::diagnosis::problem::Estimated;
use crate::diagnosis::switching::{self as spools, Open};
use crate::diagnosis::weighed;
use crate::estimation::{FitError, Gaussian, NotFinite};
use crate::model::{InputSignals, Model};
use crate::record::Record;
use crate::rig::Rig;
use first_fits::{FIRST, first_fits};
use joint::{Healthy, Solutions};
pub use report::{CalibratedDynamics, CalibratedParameter, CalibratedSensor, CalibrationReport, ChannelFit, RecordFit};
use rounds::Rounds;

/// What the user may choose.
#[derive(Debug, Clone, PartialEq)]
pub struct CalibrationOptions {
    /// Most rounds of noise, tolerance and fit.
    pub rounds: usize,
}

impl Default for CalibrationOptions {
    fn default() -> Self {
        Self { rounds: 12 }
    }
}

/// A calibrated rig.
#[derive(Debug, Clone)]
pub struct Calibrated {
    /// As reading `text` gives it.
    pub rig: Rig,
    /// The rig file with its `[calibration]` written anew behind everything else, which is untouched.
    pub text: String,
    /// What was found.
    pub report: CalibrationReport,
}

/// Calibrates the rig of a rig file on healthy records. `rig_text` is the text of the file, `rig` what was read from it; a
/// calibration that is already there is replaced, not used.
///
/// # Errors
/// No records, no sensors, missing columns, a model that cannot be solved, a rig file that cannot be read, a context that was
/// cancelled, a calibrated model that follows the records worse than the data sheet's.
pub fn calibrate(
    rig_text: &str,
    rig: &Rig,
    records: &[Record],
    options: &CalibrationOptions,
) -> Result<Calibrated, Complaint> {
    let bare = write::without_calibration(&rig.path, rig_text)?;
    let sheet = Rig::parse(&rig.path, bare.clone())?.with_context(rig.context());
    let (learnt, report) = calibrate_rig(&sheet, records, options)?;
    harm::refuse(&sheet, &report)?;
    let text = bare + &write::section(&learnt, &report);
    Ok(Calibrated { rig: Rig::parse(&rig.path, text.clone())?.with_context(rig.context()), text, report })
}

/// The same for a rig that has no file. Values, standard uncertainties and their correlation, healthy values of faults,
/// noise and tolerance of the rig that comes back are those found. Its own values are taken as a data sheet's.
///
/// # Errors
/// As [`calibrate`].
pub fn calibrate_rig(
    rig: &Rig,
    records: &[Record],
    options: &CalibrationOptions,
) -> Result<(Rig, CalibrationReport), Complaint> {
    let (learnt, mut report) = rig.context().run(|| fit_all(rig, records, options))?;
    report.dynamics = result::dynamics(rig, &learnt);
    Ok((learnt, report))
}

fn fit_all(rig: &Rig, records: &[Record], options: &CalibrationOptions) -> Result<(Rig, CalibrationReport), Complaint> {
    let lacks = |what: &str, help: &str| Complaint::new(Kind::MissingEntry, what).at(Place::file(&rig.path)).help(help);
    if records.is_empty() {
        return Err(lacks("there are no records to calibrate on", "give at least one record of the healthy rig"));
    }
    if rig.sensors.is_empty() {
        return Err(lacks(
            "the rig has no sensors, so a record shows nothing of it",
            "add `[sensors]`, one line per measured column",
        ));
    }
    let failed = |error: FitError| failed(rig, records, &error);
    let mut margins = rig.calibration.as_ref().map_or_else(Vec::new, |known| known.margins.clone());
    let mut sheet = rig.as_commanded(records).unwrap_or_else(|| rig.clone());
    for margin in rig.margins() {
        sheet.give_margin(&margin)?;
        margins.push(margin);
    }
    let mut healthy = sheet.clone();
    for fault in &rig.faults {
        healthy.parameters[fault.parameter].value = fault.healthy;
    }
    let model = Model::new(healthy);
    let taken = taken(&model.rig, records)?;
    let solutions = Solutions::new(&model, &taken, open(&model.rig));
    let prior = prior(&model.rig, &solutions.estimated);
    // The first fit starts here, so this costs no further simulation.
    let before = solutions.errors(&prior.mean).map_err(|error| failed(error.into()))?;
    let first = first_fits(&solutions, &prior, &prior.mean, &FIRST).map_err(failed)?;
    let (theta, cost) = valleys::lowest(&solutions, &prior, first).map_err(failed)?;
    let given = Given { margins, dynamics: Vec::new() };
    let lags = lags::of(&model.rig);
    let begun = Begun { given, lags, prior: &prior, before, most_rounds: options.rounds.max(1) };
    let other = lags::other_lags(&solutions, &prior, (&theta, cost));
    rig.context().check()?;
    let Some(lags::Found { lags, theta }) = other else { return begun.with_spools(&sheet, records, solutions, theta) };
    let (sheet, model) = (spools::applied(&sheet, &lags), Model::new(spools::applied(&model.rig, &lags)));
    let taken = self::taken(&model.rig, records)?;
    let solutions = Solutions::new(&model, &taken, open(&model.rig));
    begun.with_spools(&sheet, records, solutions, theta)
}

/// The complaint about a rig that no values make follow the records.
fn failed(rig: &Rig, records: &[Record], error: &FitError) -> Complaint {
    let mut complaint = Complaint::new(Kind::Computation, format!("the rig could not be calibrated: {error}"))
        .at(Place::file(&rig.path));
    complaint.places.extend(records.iter().map(|record| Place::file(&record.path)));
    complaint.help("check values and units of the rig with `borescope check`")
}

/// What the records say of a rig, and what drives it in them.
fn taken<'a>(rig: &Rig, records: impl IntoIterator<Item = &'a Record>) -> Result<Vec<Healthy<'a>>, Complaint> {
    let one = |record: &'a Record| {
        let measured = weighed::measured(rig, record)?;
        // Noise and tolerance are learned of each sensor.
        for sensor in &rig.sensors {
            record.require(&sensor.column, sensor.dimension, sensor.place.clone())?;
        }
        Ok(Healthy { record, drive: InputSignals::from_record(rig, record)?, measured })
    };
    records.into_iter().map(one).collect()
}

/// What a calibration says beside values, their correlation and the sensors.
#[derive(Clone)]
struct Given {
    margins: Vec<String>,
    /// Parameters of how spools follow, mean lags and dead times.
    dynamics: Vec<usize>,
}

/// What a calibration has begun with.
struct Begun<'a> {
    given: Given,
    /// What may have another mean lag or dead time, with what the data sheet has, SI.
    lags: Vec<(usize, f64)>,
    prior: &'a Gaussian,
    /// Errors of the model as stated, root mean squares `[record][sensor]`, SI.
    before: Vec<Vec<f64>>,
    most_rounds: usize,
}

impl Begun<'_> {
    /// Goes on with the spools that the records show, from `theta`. `sheet`: the rig that is calibrated.
    fn with_spools(
        mut self,
        sheet: &Rig,
        records: &[Record],
        solutions: Solutions<'_>,
        theta: Vec<f64>,
    ) -> Result<(Rig, CalibrationReport), Complaint> {
        let rig = &solutions.model.rig;
        let other = switching::with_other_spools(&solutions, self.prior, &theta);
        rig.context().check()?;
        let Some((other, theta)) = other else { return self.settled(sheet, records, solutions, theta) };
        let found = spools::values(rig, &other, Open::All);
        self.given.dynamics.extend(found.iter().map(|&(own, _)| own));
        let sheet = spools::applied(sheet, &found);
        let model = Model::new(other);
        let taken = taken(&model.rig, records)?;
        let solutions = Solutions::new(&model, &taken, open(&model.rig));
        self.settled(&sheet, records, solutions, theta)
    }

    /// Rounds from `theta`, and what they end with.
    fn settled(
        self,
        sheet: &Rig,
        records: &[Record],
        solutions: Solutions<'_>,
        theta: Vec<f64>,
    ) -> Result<(Rig, CalibrationReport), Complaint> {
        let asked = (sheet.settings().calibration.dynamics_rounds, f64::INFINITY);
        let found = self.ended((sheet, records), (solutions, theta), asked);
        sheet.context().check()?;
        found
            .and_then(|found| found.ok_or(FitError::NotFinite(NotFinite::Misfit)))
            .map_err(|error| failed(sheet, records, &error))
    }

    /// The same, the mean lags asked for again where the rounds have ended, so many times. What follows with others is kept where its
    /// least plain error is less, taken where it has led: a far step along derivatives may promise what is not there. `None` where
    /// that of these rounds is not below a limit.
    fn ended(
        &self,
        (sheet, records): (&Rig, &[Record]),
        (solutions, theta): (Solutions<'_>, Vec<f64>),
        (times, limit): (usize, f64),
    ) -> Result<Option<(Rig, CalibrationReport)>, FitError> {
        let mut rounds = Rounds::new(solutions, self.prior, self.before.clone());
        let settled = rounds.settle(theta, self.most_rounds)?;
        let (solutions, theta) = (&rounds.solutions, &settled.fit.theta);
        let asked = lags::again(solutions, self.prior, theta, &self.lags);
        let cost = asked.as_ref().map_or(f64::INFINITY, |asked| asked.cost);
        if limit.is_finite() && cost >= limit {
            return Ok(None);
        }
        if let (Some(times), Some(better)) = (times.checked_sub(1), asked.and_then(|asked| asked.better)) {
            let further = self.with_lags((sheet, records), (solutions, theta), &better, (times, cost));
            if further.is_some() {
                return Ok(further);
            }
        }
        let moved = self.lags.iter().filter(|&&(lag, stated)| sheet.parameters[lag].value != stated);
        let mut given = self.given.clone();
        given.dynamics.splice(0..0, moved.map(|&(lag, _)| lag));
        rounds.finish((sheet, given), records, settled).map(Some)
    }

    /// The same from a fit with other mean lags; `None` also where the model cannot be solved with them.
    fn with_lags(
        &self,
        (sheet, records): (&Rig, &[Record]),
        (solutions, theta): (&Solutions<'_>, &[f64]),
        lags: &[(usize, f64)],
        asked: (usize, f64),
    ) -> Option<(Rig, CalibrationReport)> {
        let model = Model::new(spools::applied(&solutions.model.rig, lags));
        let taken = taken(&model.rig, records).ok()?;
        let solutions = Solutions::new(&model, &taken, open(&model.rig));
        self.ended((&spools::applied(sheet, lags), records), (solutions, theta.to_vec()), asked).ok()?
    }
}

/// What calibration fits: what a part may have otherwise than its data sheet, and what is stated as uncertain, healthy values of faults
/// among them.
fn open(rig: &Rig) -> Vec<Estimated> {
    estimated(rig, &[])
}

/// The same with the means of these lags, which may be others in each switching.
fn estimated(rig: &Rig, lags: &[usize]) -> Vec<Estimated> {
    let mut open = Vec::new();
    for (index, parameter) in rig.parameters.iter().enumerate() {
        let fault = rig.faults.iter().find(|fault| fault.parameter == index);
        // Parts differ from data sheets, and what is of a record is of no part.
        let spread = if parameter.role.is_of_record() { 0.0 } else { parameter.spread };
        let known = spread.max(parameter.sigma);
        let is_asked = !parameter.per_event || lags.contains(&index);
        if known == 0.0 || !is_asked || parameter.role.is_reference() {
            continue;
        }
        let (low, high) = fault.map_or(parameter.bounds, |fault| fault.bounds);
        let (near, far) = (
            parameter.value - rig.settings().calibration.search_reach * known,
            parameter.value + rig.settings().calibration.search_reach * known,
        );
        // What is positive by its nature does not vanish, since laws are singular there; what a fault may take away may.
        let low = if fault.is_none() && low >= 0.0 && parameter.value > 0.0 && !parameter.role.is_of_the_drive() {
            low.max(rig.settings().calibration.least_share * parameter.value)
        } else {
            low
        };
        open.push(Estimated { parameter: index, bounds: (low.max(near), high.min(far)), scale: known });
    }
    open
}

fn prior(rig: &Rig, open: &[Estimated]) -> Gaussian {
    let mean = open.iter().map(|one| rig.parameters[one.parameter].value).collect();
    let variance = DVector::from_iterator(open.len(), open.iter().map(|one| one.scale * one.scale));
    Gaussian::new((0..open.len()).collect(), mean, &DMatrix::from_diagonal(&variance))
}
