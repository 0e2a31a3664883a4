//! A residual generator and its evaluation on a record.

use super::form::Form;
use super::frame::{self, Frame};
use super::known::{BENDS, Known, LANES, Lanes, Parameters, Second, Unknown};
use super::reading::{Reading, Source};
use crate::complaint::Complaint;
use crate::model::InputSignals;
use crate::numeric::{Dual, Real};
use crate::physics::component::facts;
use crate::physics::component::facts::Residuals;
use crate::physics::fluid;
use crate::record::Record;
use crate::rig::Rig;
use crate::units::Unit;

/// Whether an equation is taken as the paper prints it or as it holds.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize)]
#[cfg_attr(feature = "internals", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
pub enum Variant {
    /// As it holds: balances with compressibility, orifices with the bracket under the root, local pressures.
    Corrected,
    /// As printed, for comparison; biased, and never used for detection.
    Paper,
}

/// One residual of a rig: zero on average for the healthy circuit.
#[derive(Debug, Clone, PartialEq)]
pub struct Generator {
    /// `component.name`, such as `cylinder.leakage`.
    pub id: String,
    /// Equation of the paper, such as `(18)`, or `-` for a balance that it does not print.
    pub equation: &'static str,
    pub variant: Variant,
    /// Unit in which results are shown; series are SI.
    pub unit: Unit,
    /// What it compares, in words.
    pub meaning: &'static str,
    pub(super) readings: Vec<Reading>,
    pub(super) form: Form,
}

/// Why a value does not count.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize)]
#[cfg_attr(feature = "internals", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
pub enum Gate {
    /// It counts.
    Open,
    /// An input jumped and the lags have not settled, or the record has a gap.
    Transient,
    /// A channel bends within the window more than its noise explains.
    Unsteady,
    /// The residual is not defined here: the spool stands near zero.
    Undefined,
    /// The window before, from which the noise is taken, does not count or is not there.
    InitialGuess,
    /// A check valve, or a relief valve that the residual takes as shut, may be open.
    CheckValve,
    /// The piston touches an end stop.
    EndStop,
    /// The relief valve is about to crack: its law has a kink there.
    Cracking,
    /// The law bends within the noise of what it is evaluated at.
    Bent,
}

/// A residual over time.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Series {
    /// Time of each value, s: of the sample, or of the end of the window.
    pub time: Vec<f64>,
    /// Time at which the window of each value begins, s.
    pub start: Vec<f64>,
    /// SI, freed of the bias that noise makes in a curved law; NaN where undefined.
    pub value: Vec<f64>,
    /// One standard deviation by sensor noise, SI.
    pub sigma: Vec<f64>,
    /// One standard deviation by what is uncertain but constant: parameters stated `+-`, rounding of sensors; SI.
    pub tolerance: Vec<f64>,
    pub gate: Vec<Gate>,
}

/// Value of a law at noisy readings.
struct Expansion {
    value: f64,
    bias: f64,
    /// Variance of first and of second order.
    variance: (f64, f64),
}

/// What a window says about the next one.
#[derive(Debug, Clone, Copy)]
pub(super) struct PortVariables {
    steady: bool,
    validity: Gate,
    variance: f64,
}

/// Second order beyond this share of the first leaves the value neither normal nor, once corrected, free of bias.
const BENT: f64 = 0.1;
/// Distance from a switch of a law, in standard deviations, below which noise might have thrown it.
const CLEAR: f64 = 4.0;

impl Generator {
    /// The residual at every sample, with derivatives from windows of `window` s around it.
    ///
    /// `drive` tells when inputs jump. The noise is that of one sample; at such noise the curvature of orifice laws may
    /// show as [`Gate::Bent`], where [`Generator::blocks`] still counts.
    ///
    /// # Errors
    /// A column that the record lacks or has in another dimension.
    #[cfg(feature = "internals")]
    pub fn evaluate(&self, rig: &Rig, record: &Record, drive: &InputSignals, window: f64) -> Result<Series, Complaint> {
        let frames = frame::samples(rig, record, drive, &self.sources(), window)?;
        Ok(self.series(rig, &frames, false, &mut None))
    }

    /// The residual over non-overlapping windows of `window` s: means and slopes of the channels, whose noise is
    /// independent from window to window.
    ///
    /// # Errors
    /// As [`Generator::evaluate`].
    pub fn blocks(&self, rig: &Rig, record: &Record, drive: &InputSignals, window: f64) -> Result<Series, Complaint> {
        let frames = frame::blocks(rig, record, drive, &self.sources(), window)?;
        Ok(self.series(rig, &frames, true, &mut None))
    }

    /// The residual over windows of many sources, of which `own` are those of its readings; `before` is carried from piece to
    /// piece of a record.
    pub(super) fn series_of(
        &self,
        rig: &Rig,
        frames: &[Frame],
        own: &[usize],
        before: &mut Option<PortVariables>,
    ) -> Series {
        let frames: Vec<Frame> = frames.iter().map(|frame| frame.of(own)).collect();
        self.series(rig, &frames, true, before)
    }

    pub(super) fn sources(&self) -> Vec<Source> {
        self.readings.iter().map(|reading| reading.source).collect()
    }

    /// Values of the readings in a frame, SI, as shown.
    pub(super) fn shown(&self, frame: &Frame) -> Vec<f64> {
        self.readings.iter().zip(&frame.moments).map(|(reading, moment)| moment.value[reading.order]).collect()
    }

    fn variances(&self, frame: &Frame) -> Vec<f64> {
        self.readings.iter().zip(&frame.moments).map(|(reading, moment)| moment.variance[reading.order]).collect()
    }

    /// The residual for these parameters of the rig and readings, SI.
    pub(super) fn residual<T: Real>(&self, rig: &Rig, p: &Parameters<T>, shown: &[T]) -> Option<T> {
        let x: Vec<T> =
            self.readings.iter().zip(shown).map(|(reading, &shown)| reading.corrected(rig, &p.values, shown)).collect();
        self.form.value(rig, p, &x)
    }

    fn series(&self, rig: &Rig, frames: &[Frame], predictable: bool, before: &mut Option<PortVariables>) -> Series {
        let known = self.known(rig);
        let mut series = Series::default();
        for frame in frames {
            let shown = self.shown(frame);
            let expansion = self.expand(rig, &known.second, &shown, &self.variances(frame));
            let motion = motion(frame, expansion.is_some());
            let own = self.seen(rig, &known, frame, &shown, motion, expansion.as_ref());
            // Noise that made a value large must not also choose its weight or whether it counts, so both come from the
            // window before.
            let judge = if predictable { before.filter(|seen| frame.follows && seen.steady) } else { Some(own) };
            let value = expansion.as_ref().map_or(f64::NAN, |expansion| expansion.value - expansion.bias);
            let sigma = judge.unwrap_or(own).variance.sqrt();
            series.push(frame, [value, sigma, self.tolerance(rig, &known.lanes, &shown)], gate(motion, judge));
            *before = Some(own);
        }
        series
    }

    /// The gates of [`Generator::series_of`], and its numbers where a value counts; NaN elsewhere, which is sooner done.
    pub(super) fn counting(
        &self,
        rig: &Rig,
        known: &Known,
        frames: &[Frame],
        own: &[usize],
        before: &mut Option<PortVariables>,
    ) -> Series {
        let mut series = Series::default();
        for frame in frames.iter().map(|frame| frame.of(own)) {
            let shown = self.shown(&frame);
            if frame.disturbed || frame.moments.iter().any(|moment| !moment.steady) {
                let defined = frame.disturbed || self.residual(rig, &known.nominal, &shown).is_some();
                series.push(&frame, [f64::NAN; 3], motion(&frame, defined));
                *before = Some(PortVariables { steady: false, validity: Gate::Undefined, variance: f64::NAN });
                continue;
            }
            let expansion = self.expand(rig, &known.second, &shown, &self.variances(&frame));
            let motion = motion(&frame, expansion.is_some());
            let judge = before.filter(|seen| frame.follows && seen.steady);
            *before = Some(self.seen(rig, known, &frame, &shown, motion, expansion.as_ref()));
            let (gate, value) = (gate(motion, judge), expansion.map(|expansion| expansion.value - expansion.bias));
            let numbers = match (gate, value, judge) {
                (Gate::Open, Some(value), Some(judge)) => {
                    [value, judge.variance.sqrt(), self.tolerance(rig, &known.lanes, &shown)]
                }
                _ => [f64::NAN; 3],
            };
            series.push(&frame, numbers, gate);
        }
        series
    }

    /// What a frame says about the next one.
    fn seen(
        &self,
        rig: &Rig,
        known: &Known,
        frame: &Frame,
        shown: &[f64],
        motion: Gate,
        expansion: Option<&Expansion>,
    ) -> PortVariables {
        PortVariables {
            steady: motion == Gate::Open,
            validity: self.validity(rig, &known.nominal, frame, shown, expansion),
            variance: expansion.map_or(f64::NAN, |expansion| expansion.variance.0 + expansion.variance.1),
        }
    }

    fn expand(&self, rig: &Rig, p: &Parameters<Second>, shown: &[f64], variances: &[f64]) -> Option<Expansion> {
        let mut x: Vec<Second> = shown.iter().map(|&value| Dual::constant(value)).collect();
        let noisy: Vec<usize> = (0..shown.len()).filter(|&index| variances[index] != 0.0).collect();
        let mut expansion = Expansion { value: f64::NAN, bias: 0.0, variance: (0.0, 0.0) };
        if noisy.is_empty() {
            expansion.value = self.residual(rig, p, &x)?.re();
        }
        for lanes in noisy.chunks(BENDS) {
            for (lane, &index) in lanes.iter().enumerate() {
                x[index] = Dual::variable(Dual::variable(shown[index], lane), lane);
            }
            let probed = self.residual(rig, p, &x)?;
            expansion.value = probed.re();
            for (lane, &index) in lanes.iter().enumerate() {
                x[index] = Dual::constant(shown[index]);
                let (slope, bend, variance) = (probed.re.eps[lane], probed.eps[lane].eps[lane], variances[index]);
                expansion.bias += 0.5 * bend * variance;
                expansion.variance.0 += slope * slope * variance;
                expansion.variance.1 += 0.5 * (bend * variance).powi(2);
            }
        }
        Some(expansion)
    }

    /// Whether the formula holds at the readings of a frame.
    fn validity(
        &self,
        rig: &Rig,
        p: &Parameters<f64>,
        frame: &Frame,
        shown: &[f64],
        expansion: Option<&Expansion>,
    ) -> Gate {
        let Some(expansion) = expansion else { return Gate::Undefined };
        let variances = self.variances(frame);
        let spread =
            |readings: [Option<usize>; 2]| CLEAR * readings.iter().flatten().map(|&r| variances[r]).sum::<f64>().sqrt();
        let over = |view: &super::view::View| {
            let opens_at = facts(rig.components[view.component].card).opens_at()?;
            let drop = view.pressure(0, p, shown) - view.pressure(1, p, shown) - view.parameter(rig, opens_at, p);
            Some((drop, spread([view.reading(0), view.reading(1)])))
        };
        if self.form.shut().iter().any(|view| matches!(over(view), Some((drop, spread)) if drop > -spread)) {
            return Gate::CheckValve;
        }
        for view in self.form.views() {
            match facts(rig.components[view.component].card).residuals {
                Residuals::Relief { .. } if matches!(over(view), Some((drop, spread)) if drop.abs() < spread) => {
                    return Gate::Cracking;
                }
                Residuals::Cylinder { stroke, .. } if matches!(self.form, Form::Force { .. }) => {
                    let (position, stroke) = (view.pressure(2, p, shown), view.parameter(rig, stroke, p));
                    let spread = spread([view.reading(2), None]);
                    if position < spread || position > stroke - spread {
                        return Gate::EndStop;
                    }
                }
                _ => {}
            }
        }
        if expansion.variance.1.sqrt() > BENT * expansion.variance.0.sqrt() { Gate::Bent } else { Gate::Open }
    }

    /// What does not change from frame to frame.
    pub(super) fn known(&self, rig: &Rig) -> Known {
        let nominal = rig.healthy();
        let second = nominal.iter().map(|&value| Dual::constant(value)).collect();
        let parameters = self.uncertain(rig).into_iter().map(|(index, sigma)| Unknown::Parameter(index, sigma));
        let roundings = self.readings.iter().enumerate().map(|(index, reading)| (index, reading.systematic(rig)));
        let roundings = roundings.filter(|(_, size)| *size > 0.0).map(|(index, size)| Unknown::Reading(index, size));
        let unknowns: Vec<Unknown> = parameters.chain(roundings).collect();
        let lanes = unknowns.chunks(LANES).map(|unknowns| Lanes::new(rig, &nominal, unknowns)).collect();
        Known { nominal: Parameters::new(rig, nominal), second: Parameters::new(rig, second), lanes }
    }

    /// Parameters of the formula with a stated uncertainty, with that.
    fn uncertain(&self, rig: &Rig) -> Vec<(usize, f64)> {
        let of_reading = |reading: &Reading, parameter: usize| match reading.source {
            Source::Sensor(sensor) => rig.sensors[sensor].owns(parameter),
            Source::Input(_) => false,
        };
        let components = self.form.components();
        let own = |parameter: usize| {
            parameter < fluid::CARD.parameters.len()
                || components.iter().any(|&component| rig.components[component].owns(parameter))
                || self.readings.iter().any(|reading| of_reading(reading, parameter))
        };
        let stated = rig.parameters.iter().enumerate().filter(|(_, parameter)| parameter.sigma > 0.0);
        let held = stated.filter(|(index, _)| own(*index));
        held.map(|(index, parameter)| (index, parameter.sigma)).collect()
    }

    fn tolerance(&self, rig: &Rig, all: &[Lanes], shown: &[f64]) -> f64 {
        let mut variance = 0.0;
        for lanes in all {
            let mut x: Vec<Dual<f64, LANES>> = shown.iter().map(|&value| Dual::constant(value)).collect();
            for (lane, unknown) in lanes.unknowns.iter().enumerate() {
                if let Unknown::Reading(index, size) = *unknown {
                    x[index].eps[lane] = size;
                }
            }
            let Some(probed) = self.residual(rig, &lanes.parameters, &x) else { continue };
            for (slope, unknown) in probed.eps.iter().zip(&lanes.unknowns) {
                let share = slope * if let Unknown::Parameter(_, sigma) = unknown { *sigma } else { 1.0 };
                variance += share * share;
            }
        }
        variance.sqrt()
    }
}

/// Whether the circuit stands or runs straight in a frame.
fn motion(frame: &Frame, defined: bool) -> Gate {
    if frame.disturbed {
        Gate::Transient
    } else if !defined {
        Gate::Undefined
    } else if frame.moments.iter().any(|moment| !moment.steady) {
        Gate::Unsteady
    } else {
        Gate::Open
    }
}

/// Whether a value counts, by how the circuit moves and what the window before says.
fn gate(motion: Gate, judge: Option<PortVariables>) -> Gate {
    match (motion, judge) {
        (Gate::Open, None) => Gate::InitialGuess,
        (Gate::Open, Some(judge)) => judge.validity,
        (closed, _) => closed,
    }
}

impl Series {
    fn push(&mut self, frame: &Frame, [value, sigma, tolerance]: [f64; 3], gate: Gate) {
        self.time.push(frame.to);
        self.start.push(frame.from);
        self.value.push(value);
        self.sigma.push(sigma);
        self.tolerance.push(tolerance);
        self.gate.push(gate);
    }
}

/// These parameters, one of them a variable.
pub(super) fn along(values: &[f64], index: usize) -> Vec<Dual<f64, 1>> {
    let number = |(at, &value)| if at == index { Dual::variable(value, 0) } else { Dual::constant(value) };
    values.iter().enumerate().map(number).collect()
}
