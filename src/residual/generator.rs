//! A residual generator and its evaluation on a record.

use super::form::Form;
use super::frame::{self, Frame};
use super::reading::{Reading, Source};
use crate::complaint::Complaint;
use crate::model::Drive;
use crate::numeric::{Dual, Real};
use crate::physics::fluid;
use crate::record::Record;
use crate::rig::Rig;
use crate::units::Unit;

/// Whether an equation is taken as the paper prints it or as it holds.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize)]
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
    First,
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
#[derive(Clone, Copy)]
struct Seen {
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
    pub fn evaluate(&self, rig: &Rig, record: &Record, drive: &Drive, window: f64) -> Result<Series, Complaint> {
        let frames = frame::samples(rig, record, drive, &self.sources(), window)?;
        Ok(self.series(rig, &frames, false))
    }

    /// The residual over non-overlapping windows of `window` s: means and slopes of the channels, whose noise is
    /// independent from window to window.
    ///
    /// # Errors
    /// As [`Generator::evaluate`].
    pub fn blocks(&self, rig: &Rig, record: &Record, drive: &Drive, window: f64) -> Result<Series, Complaint> {
        let frames = frame::blocks(rig, record, drive, &self.sources(), window)?;
        Ok(self.series(rig, &frames, true))
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
    pub(super) fn residual<T: Real>(&self, rig: &Rig, p: &[T], shown: &[T]) -> Option<T> {
        let x: Vec<T> =
            self.readings.iter().zip(shown).map(|(reading, &shown)| reading.corrected(rig, p, shown)).collect();
        self.form.value(rig, p, &x)
    }

    fn series(&self, rig: &Rig, frames: &[Frame], predictable: bool) -> Series {
        let nominal = rig.healthy();
        let second: Vec<Dual<Dual<f64, 1>, 1>> = nominal.iter().map(|&value| Dual::constant(value)).collect();
        let first: Vec<Dual<f64, 1>> = nominal.iter().map(|&value| Dual::constant(value)).collect();
        let uncertain = self.uncertain(rig, &nominal);
        let mut series = Series::default();
        let mut before: Option<Seen> = None;
        for frame in frames {
            let shown = self.shown(frame);
            let expansion = self.expand(rig, &second, &shown, &self.variances(frame));
            let motion = self.motion(frame, expansion.as_ref());
            let own = Seen {
                steady: motion == Gate::Open,
                validity: self.validity(rig, &nominal, frame, &shown, expansion.as_ref()),
                variance: expansion.as_ref().map_or(f64::NAN, |expansion| expansion.variance.0 + expansion.variance.1),
            };
            // Noise that made a value large must not also choose its weight or whether it counts, so both come from the
            // window before.
            let judge = if predictable { before.filter(|before| frame.follows && before.steady) } else { Some(own) };
            series.time.push(frame.to);
            series.start.push(frame.from);
            series.value.push(expansion.as_ref().map_or(f64::NAN, |expansion| expansion.value - expansion.bias));
            series.sigma.push(judge.unwrap_or(own).variance.sqrt());
            series.tolerance.push(self.tolerance(rig, &first, &uncertain, &shown));
            series.gate.push(match (motion, judge) {
                (Gate::Open, None) => Gate::First,
                (Gate::Open, Some(judge)) => judge.validity,
                (closed, _) => closed,
            });
            before = Some(own);
        }
        series
    }

    fn expand(&self, rig: &Rig, p: &[Dual<Dual<f64, 1>, 1>], shown: &[f64], variances: &[f64]) -> Option<Expansion> {
        let mut x: Vec<Dual<Dual<f64, 1>, 1>> = shown.iter().map(|&value| Dual::constant(value)).collect();
        let value = self.residual(rig, p, &x)?.re();
        let mut expansion = Expansion { value, bias: 0.0, variance: (0.0, 0.0) };
        for (index, &variance) in variances.iter().enumerate() {
            if variance == 0.0 {
                continue;
            }
            x[index] = Dual::variable(Dual::variable(shown[index], 0), 0);
            let probed = self.residual(rig, p, &x)?;
            x[index] = Dual::constant(shown[index]);
            let (slope, bend) = (probed.re.eps[0], probed.eps[0].eps[0]);
            expansion.bias += 0.5 * bend * variance;
            expansion.variance.0 += slope * slope * variance;
            expansion.variance.1 += 0.5 * (bend * variance).powi(2);
        }
        Some(expansion)
    }

    /// Whether the circuit stands or runs straight in a frame.
    fn motion(&self, frame: &Frame, expansion: Option<&Expansion>) -> Gate {
        if frame.disturbed {
            Gate::Transient
        } else if expansion.is_none() {
            Gate::Undefined
        } else if frame.moments.iter().any(|moment| !moment.steady) {
            Gate::Unsteady
        } else {
            Gate::Open
        }
    }

    /// Whether the formula holds at the readings of a frame.
    fn validity(&self, rig: &Rig, p: &[f64], frame: &Frame, shown: &[f64], expansion: Option<&Expansion>) -> Gate {
        let Some(expansion) = expansion else { return Gate::Undefined };
        let variances = self.variances(frame);
        let spread =
            |readings: [Option<usize>; 2]| CLEAR * readings.iter().flatten().map(|&r| variances[r]).sum::<f64>().sqrt();
        let over = |view: &super::view::View| {
            let drop = view.pressure(0, p, shown) - view.pressure(1, p, shown) - view.parameter(rig, 0, p);
            (drop, spread([view.reading(0), view.reading(1)]))
        };
        if self.form.shut().iter().any(|view| matches!(over(view), (drop, spread) if drop > -spread)) {
            return Gate::CheckValve;
        }
        for view in self.form.views() {
            match rig.components[view.component].card.kind {
                "relief-valve" if matches!(over(view), (drop, spread) if drop.abs() < spread) => return Gate::Cracking,
                "cylinder" if matches!(self.form, Form::Force { .. }) => {
                    let (position, stroke) = (view.pressure(2, p, shown), view.parameter(rig, 2, p));
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

    /// Parameters of the formula with a stated uncertainty, each with the dual numbers that differentiate by it.
    fn uncertain(&self, rig: &Rig, nominal: &[f64]) -> Vec<(f64, Vec<Dual<f64, 1>>)> {
        let components = self.form.components().into_iter().map(|component| {
            let component = &rig.components[component];
            component.first_parameter..component.first_parameter + component.card.parameters.len()
        });
        let sensors = self.readings.iter().filter_map(|reading| match reading.source {
            Source::Sensor(sensor) => {
                Some(rig.sensors[sensor].first_parameter..rig.sensors[sensor].first_parameter + 2)
            }
            Source::Input(_) => None,
        });
        let fluid = std::iter::once(0..fluid::CARD.parameters.len());
        let own: Vec<std::ops::Range<usize>> = fluid.chain(components).chain(sensors).collect();
        let stated = rig.parameters.iter().enumerate().filter(|(_, parameter)| parameter.sigma > 0.0);
        let held = stated.filter(|(index, _)| own.iter().any(|range| range.contains(index)));
        held.map(|(index, parameter)| (parameter.sigma, along(nominal, index))).collect()
    }

    fn tolerance(
        &self,
        rig: &Rig,
        nominal: &[Dual<f64, 1>],
        uncertain: &[(f64, Vec<Dual<f64, 1>>)],
        shown: &[f64],
    ) -> f64 {
        let mut x: Vec<Dual<f64, 1>> = shown.iter().map(|&value| Dual::constant(value)).collect();
        let by_parameters = uncertain.iter().filter_map(|(sigma, p)| Some(self.residual(rig, p, &x)?.eps[0] * sigma));
        let mut variance: f64 = by_parameters.map(|share| share * share).sum();
        for (index, reading) in self.readings.iter().enumerate() {
            let systematic = reading.systematic(rig);
            if systematic > 0.0 {
                x[index].eps[0] = systematic;
                variance += self.residual(rig, nominal, &x).map_or(0.0, |probed| probed.eps[0] * probed.eps[0]);
                x[index].eps[0] = 0.0;
            }
        }
        variance.sqrt()
    }
}

/// These parameters, one of them a variable.
pub(super) fn along(values: &[f64], index: usize) -> Vec<Dual<f64, 1>> {
    let number = |(at, &value)| if at == index { Dual::variable(value, 0) } else { Dual::constant(value) };
    values.iter().enumerate().map(number).collect()
}
