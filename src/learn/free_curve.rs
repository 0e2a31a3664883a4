//! A curve without a formula, put where it may act and fitted along with everything else, to first order around a fitted model.
//!
//! Its bend is held down by a prior whose size makes the record most likely (MacKay, Neural Computation 4 (1992) 415), so it shows
//! no more than the record says.

use nalgebra::{Cholesky, DMatrix, DVector, Dyn};
use rayon::prelude::*;

use super::candidate::Candidate;
use super::fitted_model::FittedModel;
use super::highest::readings;
use super::run::Run;
use crate::complaint::Complaint;
use crate::diagnosis::{estimate, is_there, weighed};
use crate::model::{InputSignals, Model};
use crate::numeric::dot;
use crate::physics::effect::InitialGuess;
use crate::physics::effect::spline::{Curve, HEIGHTS};
use crate::record::Record;
use crate::rig::{EffectInstance, Quantity, Rig, Target};
use crate::settings::LearningSettings;
use crate::units::Unit;

/// Sizes of the bend that are tried, in typical sizes of the curve.
const BENDS: [f64; 7] = [1e-3, 1e-2, 1e-1, 1.0, 1e1, 1e2, 1e3];

/// What a curve without a formula is called.
#[derive(Debug)]
pub(super) struct Told {
    effect: &'static str,
    pub what: &'static str,
    pub over: &'static str,
    /// Whether the axis runs to both sides of zero.
    pub both_sides: bool,
}

const PRESSURE: &str = "pressure";
/// Share of the usual range below which a state stands still.
const STILL: f64 = 1e-6;
/// How its card calls the end of a curve over the pressure or the speed.
const RANGE: &str = "range";

const TOLD: [Told; 5] = [
    Told { effect: "empirical-leakage", what: "flow to the tank", over: PRESSURE, both_sides: false },
    Told { effect: "empirical-piston-leakage", what: "conductance from A to B", over: "position", both_sides: false },
    Told { effect: "empirical-drag", what: "force against the motion", over: "speed", both_sides: true },
    Told { effect: "empirical-friction", what: "friction", over: "position", both_sides: false },
    Told { effect: "empirical-load", what: "force against the rod", over: "position", both_sides: false },
];

/// Weighted derivatives of the misfits by parameters, a column each, and what is known of these before the record.
pub(super) struct Slopes {
    columns: Vec<Vec<f64>>,
    /// One over the standard deviation; 0 where nothing is known.
    known: Vec<f64>,
    /// How far each stands from where it was expected, SI.
    away: Vec<f64>,
}

impl Slopes {
    /// Of everything that was fitted.
    pub fn of_fitted(base: &FittedModel, record: &Record) -> Result<Self, Complaint> {
        let rig = &base.rig;
        let present = |parameter: usize| {
            rig.faults
                .iter()
                .position(|fault| fault.parameter == parameter)
                .is_none_or(|fault| base.set.contains(fault))
        };
        let by: Vec<usize> = estimate::estimated_parameters(rig).into_iter().filter(|&index| present(index)).collect();
        let model = Model::new(rig.clone());
        let drive = InputSignals::from_record(rig, record)?;
        let columns = columns(&model, &base.values, &by, &drive, record, &base.fit)
            .map_err(|error| weighed::unsolvable(&model, record, error))?;
        let sigma =
            |&index: &usize| Some(rig.parameters[index].sigma).filter(|sigma| *sigma > 0.0 && !rig.is_fault(index));
        Ok(Self {
            columns,
            known: by.iter().map(|index| sigma(index).map_or(0.0, |sigma| 1.0 / sigma)).collect(),
            away: by.iter().map(|&index| base.values[index] - rig.parameters[index].value).collect(),
        })
    }
}

fn columns(
    model: &Model,
    values: &[f64],
    by: &[usize],
    drive: &InputSignals,
    record: &Record,
    run: &Run,
) -> Result<Vec<Vec<f64>>, crate::model::SimulationError> {
    let derivatives = model.sensitivities(values, by, drive, &record.time)?.derivatives;
    let weighted = |derivative: Vec<Vec<f64>>| {
        let mut column = derivative.concat();
        run.weights.apply(&mut column);
        column
    };
    Ok(derivatives.into_iter().map(weighted).collect())
}

/// A curve where it may act, flat, in a fitted model.
pub(super) struct FreeCurve {
    pub told: &'static Told,
    pub quantity: Quantity,
    /// The rig with the curve as its last component, the indices of its heights, and all values, SI.
    pub rig: Rig,
    pub indices: Vec<usize>,
    pub values: Vec<f64>,
    /// Of a height.
    pub unit: Unit,
    /// A height that is usual, SI.
    typical: f64,
    /// Weighted derivatives of the misfits by the heights.
    heights: Vec<Vec<f64>>,
}

impl FreeCurve {
    /// `None` where the model cannot be solved with it, or nobody has told how it is called.
    pub fn of(base: &FittedModel, record: &Record, drive: &InputSignals, placed: &EffectInstance) -> Option<Self> {
        let told = TOLD.iter().find(|told| told.effect == placed.effect.name)?;
        let quantity = match told.over {
            PRESSURE => Quantity::Pressure,
            "speed" => Quantity::Velocity,
            _ => Quantity::Position,
        };
        let (rig, indices) = with_curve(base, (drive, &record.time), placed, quantity)?;
        let mut values = base.values.clone();
        values.extend(rig.parameters[values.len()..].iter().map(|parameter| parameter.value));
        let model = Model::new(rig);
        let heights = columns(&model, &values, &indices, drive, record, &base.fit).ok()?;
        let Model { rig, .. } = model;
        let unit = rig.effect_unit(placed, placed.effect.parameters[0].name);
        let InitialGuess::Value(typical) = placed.effect.parameters[0].first else { return None };
        let typical = unit.difference_to_si(typical);
        Some(Self { told, quantity, rig, indices, values, unit, typical, heights })
    }

    /// Fitted beside everything else; `None` where the record shows nothing of it.
    pub fn fitted<'a>(&'a self, base: &FittedModel, own: &'a Slopes) -> Option<Fitted<'a>> {
        Fitted::new(&base.rig.settings().learn, (own, &self.heights), &base.fit.misfit, self.typical)
    }

    /// First and last place of the axis, as shares of it, that the record has visited.
    pub fn visited(&self) -> Option<(f64, f64)> {
        visited(self.rig.settings().learn.visited_share, &self.heights)
    }
}

/// The rig of a model with a curve in it, and the indices of its heights. A curve with a range of its own runs as far as the record does
/// where that is farther than usual, or so near that all of it lies within one piece and would show no form.
fn with_curve(
    base: &FittedModel,
    run: (&InputSignals, &[f64]),
    placed: &EffectInstance,
    quantity: Quantity,
) -> Option<(Rig, Vec<usize>)> {
    let mut rig = base.rig.clone();
    let indices = rig.give_effect(placed, &[]).ok()?;
    let joined = rig.components.last()?;
    let range = joined.card.parameters.iter().position(|own| own.name == RANGE).map(|own| joined.first_parameter + own);
    let node = *joined.ports.first()?;
    let watched = [(Target::Node(node), quantity)];
    if let Some(range) = range
        && let Some(shown) = readings(&base.rig, &base.values, run, &watched)
    {
        let reach = shown.iter().flatten().copied().map(f64::abs).fold(0.0, f64::max);
        let usual = rig.parameters[range].value;
        // What stands still has no axis.
        let moves = reach > STILL * usual;
        if reach > usual || (moves && reach * ((HEIGHTS - 3) as f64) < usual) {
            rig.parameters[range].value = reach;
        }
    }
    Some((rig, indices))
}

/// A curve that is tried at a place.
pub(super) struct Asked {
    /// As high as the record asks for, to first order: a few newtons on a small axis, kilonewtons on a ram.
    pub candidate: Candidate,
    /// Fall of chi-square that it promises.
    pub fall: f64,
}

/// Those of some curves, each tried at its typical height, of which the record shows anything in a fitted model.
///
/// # Errors
/// Columns that are missing, or a model that cannot be solved.
pub(super) fn curves(base: &FittedModel, record: &Record, tried: Vec<Candidate>) -> Result<Vec<Asked>, Complaint> {
    let own = Slopes::of_fitted(base, record)?;
    let drive = InputSignals::from_record(&base.rig, record)?;
    let asked = |mut candidate: Candidate| {
        let free = FreeCurve::of(base, record, &drive, &candidate.placed)?;
        let fitted = free.fitted(base, &own)?;
        let (heights, _) = fitted.curve(&fitted.pull);
        let seen = seen(base.rig.settings().learn.visited_share, &free.heights);
        let of_seen = heights.iter().zip(seen).filter(|(_, is_seen)| *is_seen);
        let highest = of_seen.map(|(height, _)| height.abs()).fold(0.0, f64::max);
        candidate.tried.iter_mut().for_each(|height| height.value = height.value.max(highest));
        Some(Asked { candidate, fall: fitted.fall })
    };
    Ok(tried.into_par_iter().filter_map(asked).collect())
}

/// Which heights the record has something to say of: those that do more than a share of what the most telling one does.
fn seen(least: f64, heights: &[Vec<f64>]) -> Vec<bool> {
    let sizes: Vec<f64> = heights.iter().map(|column| dot(column, column).sqrt()).collect();
    let largest = sizes.iter().copied().fold(0.0, f64::max);
    sizes.iter().map(|size| largest > 0.0 && *size >= least * largest).collect()
}

/// First and last place of the axis, as shares of it, that the record has visited.
fn visited(least: f64, heights: &[Vec<f64>]) -> Option<(f64, f64)> {
    let seen = seen(least, heights);
    let (first, last) = (seen.iter().position(|&is_seen| is_seen)?, seen.iter().rposition(|&is_seen| is_seen)?);
    let peak = |height: usize| ((height as f64 - 1.0) / (HEIGHTS - 3) as f64).clamp(0.0, 1.0);
    (last > first).then(|| (peak(first), peak(last)))
}

/// Weights of the heights at a share of the axis.
pub(super) fn basis(share: f64) -> DVector<f64> {
    DVector::from_fn(HEIGHTS, |height, _| {
        let mut alone = [0.0; HEIGHTS];
        alone[height] = 1.0;
        Curve::new(&alone).at(share)
    })
}

/// Normal equations of a curve beside everything fitted, at the bend that makes the record most likely.
pub(super) struct Fitted<'a> {
    columns: Vec<&'a [f64]>,
    factor: Cholesky<f64, Dyn>,
    /// Slope of half the cost.
    pub pull: DVector<f64>,
    /// Variance of a misfit that is left.
    left: f64,
    /// Share that it takes away of what is missed beyond noise and tolerance.
    pub explains: f64,
    /// Fall of the sum of squares, in variances of a misfit that is left.
    pub fall: f64,
}

impl<'a> Fitted<'a> {
    fn new(
        settings: &LearningSettings,
        (own, heights): (&'a Slopes, &'a [Vec<f64>]),
        misfit: &[f64],
        typical: f64,
    ) -> Option<Self> {
        let columns: Vec<&[f64]> = own.columns.iter().chain(heights).map(Vec::as_slice).collect();
        let count = columns.len();
        let mut square = DMatrix::zeros(count, count);
        for i in 0..count {
            for j in 0..=i {
                square[(i, j)] = dot(columns[i], columns[j]);
                square[(j, i)] = square[(i, j)];
            }
        }
        let mut pull = DVector::from_iterator(count, columns.iter().map(|column| dot(column, misfit)));
        for (index, (known, away)) in own.known.iter().zip(&own.away).enumerate() {
            square[(index, index)] += known * known;
            pull[index] += known * known * away;
        }
        let first = own.columns.len();
        let bent = |bend: f64| {
            let prior = prior(settings.curve_sigma, typical, bend);
            let mut whole = square.clone();
            let mut corner = whole.view_mut((first, first), (HEIGHTS, HEIGHTS));
            corner += &prior;
            let (factor, prior) = (Cholesky::new(whole)?, Cholesky::new(prior)?);
            let fall = pull.dot(&factor.solve(&pull));
            Some((fall - factor.ln_determinant() + prior.ln_determinant(), factor))
        };
        let tried = BENDS.into_iter().filter_map(bent);
        let (_, factor) = tried.max_by(|a, b| a.0.total_cmp(&b.0))?;
        let step = -factor.solve(&pull);
        let mut after = misfit.to_vec();
        for (column, step) in columns.iter().zip(step.iter()) {
            after.iter_mut().zip(*column).for_each(|(slot, slope)| *slot += slope * step);
        }
        let (before, after) = (dot(misfit, misfit), dot(&after, &after));
        let samples = misfit.iter().filter(|misfit| is_there(**misfit)).count();
        let fall = (before - after) * samples as f64 / after;
        let left = (after / samples.max(1) as f64).max(1.0);
        let missed = before - samples as f64;
        let explains = if missed > 0.0 { ((before - after) / missed).clamp(0.0, 1.0) } else { 0.0 };
        Some(Self { columns, factor, pull, left, explains, fall })
    }

    pub fn slope(&self, misfit: &[f64]) -> DVector<f64> {
        DVector::from_iterator(self.columns.len(), self.columns.iter().map(|column| dot(column, misfit)))
    }

    /// Heights, SI, and their covariance, for a slope of half the cost.
    pub fn curve(&self, pull: &DVector<f64>) -> (DVector<f64>, DMatrix<f64>) {
        let step = -self.factor.solve(pull);
        let first = step.len() - HEIGHTS;
        let covariance = self.factor.inverse() * self.left;
        (step.rows(first, HEIGHTS).into(), covariance.view((first, first), (HEIGHTS, HEIGHTS)).into())
    }
}

/// Precision of the heights: their second differences are small, they themselves anything.
fn prior(sigma: f64, typical: f64, bend: f64) -> DMatrix<f64> {
    let mut precision = DMatrix::identity(HEIGHTS, HEIGHTS) / (sigma * typical).powi(2);
    let weight = 1.0 / (bend * typical).powi(2);
    for middle in 1..HEIGHTS - 1 {
        let difference = [(middle - 1, 1.0), (middle, -2.0), (middle + 1, 1.0)];
        for (i, a) in difference {
            for (j, b) in difference {
                precision[(i, j)] += weight * a * b;
            }
        }
    }
    precision
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::physics::effect::EFFECTS;

    #[test]
    fn every_curve_without_a_formula_is_told() {
        let names: Vec<&str> = EFFECTS.iter().filter(|effect| effect.empirical).map(|effect| effect.name).collect();
        let mut told: Vec<&str> = TOLD.iter().map(|told| told.effect).collect();
        told.sort_unstable();
        let mut sorted = names.clone();
        sorted.sort_unstable();
        assert_eq!(told, sorted);
    }
}
