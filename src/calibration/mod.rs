//! Calibration: what a data sheet never gets right, learnt from healthy records.
//!
//! [`calibrate`] fits every parameter that a part may have otherwise than its data sheet (or that is stated as uncertain)
//! to all healthy records together, with the data sheet as prior; noise of the sensors and tolerance of the model are
//! estimated along. The result is a rig file with a `[calibration]`, which later fits take as prior with its covariance.
//!
//! One round is: noise from the fast part of the misfit, tolerance from the levels of its phases, what the model lacks beyond both,
//! weights from all three, and the most probable parameters under them. Rounds end when none of it moves any more.

mod clusters;
mod harm;
mod joint;
mod lack_of_fit;
mod lags;
mod noise;
mod plain_error;
mod principal;
mod report;
mod result;
mod switching;
mod tolerance;
mod write;

use nalgebra::{DMatrix, DVector};

use crate::complaint::{Complaint, Kind, Place};
use crate::diagnosis::events::{self, Events};
use crate::diagnosis::noise::{Weights, phases, variances};
use crate::diagnosis::problem::{Estimated, RecordProblem};
use crate::diagnosis::switching::{self as spools, Open};
use crate::diagnosis::weighed;
use crate::estimation::{FitError, Gaussian, Loss, Options as Steps};
use crate::model::{InputSignals, Model, SimulationError};
use crate::record::Record;
use crate::residual::settling;
use crate::rig::{Rig, Sensor, TOLERANCE};
use joint::{Healthy, Joint, Solutions};
use noise::Noise;
pub use report::{CalibratedParameter, CalibratedSensor, CalibrationReport, ChannelFit, RecordFit};
use tolerance::{Evidence, PortVariables};

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

/// How far each of the fits before the first round may go, in standard deviations of the data sheet: the box widens slowly,
/// because far steps over bent laws may end in another valley.
const FIRST: [f64; 10] = [0.7, 1.0, 1.5, 2.0, 2.5, 3.0, 4.0, 5.0, 5.0, 5.0];

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
    rig.context().run(|| fit_all(rig, records, options))
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
    let mut sheet = rig.clone();
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
    let (theta, cost) = first_fits(&solutions, &prior, &prior.mean, &FIRST).map_err(failed)?;
    let given = Given { margins, dynamics: Vec::new() };
    let mut begun = Begun { given, prior: &prior, before, most_rounds: options.rounds.max(1) };
    let other = lags::other_lags(&solutions, &prior, (&theta, cost));
    rig.context().check()?;
    let Some(lags::Found { lags, theta }) = other else { return begun.with_spools(&sheet, records, solutions, theta) };
    begun.given.dynamics = lags.iter().map(|&(own, _)| own).collect();
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

/// The fits before noise and tolerance are known, each within so many standard deviations of the data sheet, as long as they gain: the last
/// one and its cost.
fn first_fits(
    solutions: &Solutions<'_>,
    prior: &Gaussian,
    start: &[f64],
    reaches: &[f64],
) -> Result<(Vec<f64>, f64), FitError> {
    let rig = &solutions.model.rig;
    let rough: Vec<Weights> = solutions.records.iter().map(|one| rough(rig, one)).collect();
    let (mut theta, mut cost) = (start.to_vec(), f64::INFINITY);
    let count = rig.context().count("first fits, at most", reaches.len());
    for &reach in reaches {
        let mut joint = Joint::new(solutions, rough.clone(), prior)
            .robust(&theta, Loss::SoftL1 { k: rig.settings().calibration.first_loss_width })?;
        joint.confine(reach);
        let fit = joint.fit(&theta, ends(rig))?;
        count.one();
        let gained = cost - fit.cost;
        (theta, cost) = (fit.theta, fit.cost);
        if gained.abs() < rig.settings().calibration.first_decrease * cost {
            break;
        }
    }
    Ok((theta, cost))
}

/// What a calibration says beside values, their correlation and the sensors.
struct Given {
    margins: Vec<String>,
    /// Parameters of how spools follow.
    dynamics: Vec<usize>,
}

/// What a calibration has begun with.
struct Begun<'a> {
    given: Given,
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
        let failed = |error: FitError| failed(sheet, records, &error);
        let rig = &solutions.model.rig;
        let other = switching::with_other_spools(&solutions, self.prior, &theta);
        rig.context().check()?;
        let Some((other, theta)) = other else { return self.settled(sheet, records, solutions, theta).map_err(failed) };
        let found = spools::values(rig, &other, Open::All);
        self.given.dynamics.extend(found.iter().map(|&(own, _)| own));
        let sheet = spools::applied(sheet, &found);
        let model = Model::new(other);
        let taken = taken(&model.rig, records)?;
        let solutions = Solutions::new(&model, &taken, open(&model.rig));
        self.settled(&sheet, records, solutions, theta).map_err(failed)
    }

    /// Rounds of noise, tolerance and fit, from `theta`, until none of it moves any more. `sheet`: the rig that is calibrated.
    fn settled(
        self,
        sheet: &Rig,
        records: &[Record],
        solutions: Solutions<'_>,
        mut theta: Vec<f64>,
    ) -> Result<(Rig, CalibrationReport), FitError> {
        let Self { given, prior, before, most_rounds } = self;
        let noises = vec![None; sheet.sensors.len()];
        let mut rounds = Rounds { rig: solutions.model.rig.clone(), noises, solutions, prior, before };
        let mut round = 0;
        let count = sheet.context().count("rounds of noise, tolerance and fit, at most", most_rounds);
        let (fit, weights, settled) = loop {
            round += 1;
            let before = rounds.rig.clone();
            rounds.forget_lack_of_fit();
            rounds.estimate_noise(&theta)?;
            let events = rounds.events(&rounds.rig, &theta)?;
            rounds.estimate_tolerance(&theta, &events, if round == 1 { 2 } else { 1 })?;
            let mut weights = Rounds::weights(&rounds.rig, &events);
            if rounds.estimate_lack_of_fit(&theta, &weights)? {
                weights = Rounds::weights(&rounds.rig, &rounds.events(&rounds.rig, &theta)?);
            }
            let joint =
                rounds.joint(weights.clone(), &theta, Loss::Huber { k: sheet.settings().calibration.huber_width })?;
            let fit = joint.fit(&theta, ends(sheet))?;
            let settled = joint.within(&fit.theta, &theta, sheet.settings().calibration.settled_deviation)?
                && alike(&before, &rounds.rig);
            theta.clone_from(&fit.theta);
            count.one();
            if settled || round >= most_rounds {
                break (fit, weights, settled);
            }
        };
        rounds.finish((sheet, given), records, fit, weights, (round, settled))
    }
}

fn ends(rig: &Rig) -> Steps {
    let settings = &rig.settings().calibration;
    Steps { function: settings.decrease, ..Steps::steps(settings.iterations, 0.0) }
}

/// Whether noise and tolerance have settled.
fn alike(before: &Rig, after: &Rig) -> bool {
    let settings = &after.settings().calibration;
    before.sensors.iter().zip(&after.sensors).all(|(before, after)| {
        (after.noise - before.noise).abs() <= settings.settled_noise * before.noise
            && (after.tolerance - before.tolerance).abs()
                <= settings.settled_tolerance * before.tolerance.max(after.tolerance)
    })
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
        let known = parameter.spread.max(parameter.sigma);
        if known == 0.0 || parameter.per_event && !lags.contains(&index) {
            continue;
        }
        let (low, high) = fault.map_or(parameter.bounds, |fault| fault.bounds);
        let (near, far) = (
            parameter.value - rig.settings().calibration.search_reach * known,
            parameter.value + rig.settings().calibration.search_reach * known,
        );
        // What is positive by its nature does not vanish: laws are singular there.
        let low = if low >= 0.0 && parameter.value > 0.0 {
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

/// Weights before anything has been fitted.
fn rough(rig: &Rig, one: &Healthy<'_>) -> Weights {
    let mut variance = variances(rig, one.record, &one.measured, true);
    let phases = phases(rig, &one.drive, &one.record.time, &variance);
    unsettled(rig, one, &mut variance);
    Weights::new(rig, &phases, &variance, &[])
}

/// Takes the weight from the samples behind each jump of an input until the lags have settled. Small physics that the model
/// left out is largest there, and thousands of precise samples would force it upon parameters that nothing else tells.
fn unsettled(rig: &Rig, one: &Healthy<'_>, variance: &mut [Vec<f64>]) {
    /// As good as no sample.
    const NOTHING: f64 = 1e6;
    let settling = settling(rig);
    let time = &one.record.time;
    for jump in one.drive.pieces.iter().filter(|piece| piece.jump) {
        let from = time.partition_point(|&t| t <= jump.start);
        let to = time.partition_point(|&t| t <= jump.start + settling);
        variance.iter_mut().for_each(|sensor| sensor[from..to].iter_mut().for_each(|variance| *variance *= NOTHING));
    }
}

/// What changes from round to round.
struct Rounds<'a> {
    /// With the noise and tolerance found so far.
    rig: Rig,
    noises: Vec<Option<Noise>>,
    solutions: Solutions<'a>,
    prior: &'a Gaussian,
    /// Root mean square errors of the model as stated: `[record][sensor]`, SI.
    before: Vec<Vec<f64>>,
}

impl Rounds<'_> {
    fn joint(&self, weights: Vec<Weights>, theta: &[f64], loss: Loss) -> Result<Joint<'_>, SimulationError> {
        Joint::new(&self.solutions, weights, self.prior).robust(theta, loss)
    }

    /// The events of each record under the noise and tolerance of a rig.
    fn events(&self, rig: &Rig, theta: &[f64]) -> Result<Vec<Events>, SimulationError> {
        let model = Model::new(rig.clone());
        let each = self.solutions.records.iter().enumerate().map(|(record, one)| {
            let empty = Weights::new(rig, &[], &[], &[]);
            let (open, theta) = self.solutions.of(theta, record);
            let (times, measured) = (&one.record.time, one.measured.clone());
            let problem = RecordProblem::new(&model, &one.drive, times, measured, empty, open);
            let mut events = events::events(&problem, one.record, &theta)?;
            unsettled(rig, one, &mut events.variance);
            Ok(events)
        });
        each.collect()
    }

    fn weights(rig: &Rig, events: &[Events]) -> Vec<Weights> {
        events.iter().map(|one| Weights::new(rig, &one.phases, &one.variance, &one.changes)).collect()
    }

    fn estimate_noise(&mut self, theta: &[f64]) -> Result<(), SimulationError> {
        let curves = self.solutions.curves(theta)?;
        self.noises = noise::estimate(&self.rig, &self.solutions, &curves);
        for (sensor, noise) in self.rig.sensors.iter_mut().zip(&self.noises) {
            if let Some(noise) = noise {
                sensor.noise = noise.sigma;
            }
        }
        Ok(())
    }

    fn estimate_tolerance(&mut self, theta: &[f64], events: &[Events], sweeps: usize) -> Result<(), SimulationError> {
        let mut free = self.rig.clone();
        free.sensors.iter_mut().for_each(|sensor| sensor.tolerance = 0.0);
        if events.iter().map(|one| one.phases.len()).sum::<usize>() < free.settings().calibration.tolerance_phases {
            return Ok(());
        }
        let curves = self.solutions.curves(theta)?;
        let mut seen = Vec::new();
        for (record, one) in events.iter().enumerate() {
            seen.push(PortVariables {
                weights: Weights::new(&free, &one.phases, &one.variance, &one.changes),
                phases: one.phases.clone(),
                misfit: self.solutions.misfit(&curves, record),
                columns: self.solutions.columns(theta, record)?,
            });
        }
        let precision = self.prior.precision();
        let away = DVector::from_iterator(theta.len(), self.prior.mean.iter().zip(theta).map(|(mean, at)| mean - at));
        let pull = &precision * away;
        let colour: Vec<f64> = self.noises.iter().map(|noise| noise.map_or(1.0, |noise| noise.colour())).collect();
        let stated = &self.solutions.model.rig.sensors;
        // A tolerance that is stated as none is not believed, but taken as the usual one.
        let share = |sensor: &Sensor| if sensor.tolerance > 0.0 { sensor.tolerance / sensor.noise } else { TOLERANCE };
        let scale = stated.iter().map(share).collect();
        let evidence = Evidence::new(&free, seen, precision, pull, &colour, scale);
        let start: Vec<f64> = self.rig.sensors.iter().map(|sensor| sensor.tolerance).collect();
        for (sensor, tolerance) in self.rig.sensors.iter_mut().zip(evidence.tolerances(&start, sweeps)) {
            sensor.tolerance = tolerance.max(free.settings().calibration.least_tolerance_share * sensor.noise);
        }
        Ok(())
    }
}
