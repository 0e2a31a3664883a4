//! What is missing, as a picture: the flow or the force that would explain the misfit, over the state that it goes with.
//!
//! A curve without a formula is put where it may act and fitted along with everything else, to first order around the model
//! as it stands. Its bend is held down by a prior whose size makes the record most likely (MacKay, Neural Computation 4
//! (1992) 415), so the picture shows no more than the record says. It leads to the term (Kristensen, Madsen and Jorgensen,
//! Computers and Chemical Engineering 28 (2004) 1431); effects are judged by their own fits, never by it.

use nalgebra::{Cholesky, DMatrix, DVector, Dyn};
use rayon::prelude::*;

use super::candidate::empirical;
use super::fitted_model::FittedModel;
use super::highest::readings;
use super::law_on_axis::{Found, LawOnAxis};
use super::run::Run;
use super::states::{Axis, piece, stays};
use crate::complaint::Complaint;
use crate::diagnosis::{estimate, is_there, weighed};
use crate::estimation::profile::QUANTILE;
use crate::model::{InputSignals, Model};
use crate::physics::effect::InitialGuess;
use crate::physics::effect::spline::{Curve, HEIGHTS};
use crate::record::Record;
use crate::rig::{EffectInstance, Quantity, Rig, Target};
use crate::settings::LearningSettings;

/// Points of a picture over the whole axis.
const POINTS: usize = 120;
/// Sizes of the bend that are tried, in typical sizes of the curve.
const BENDS: [f64; 7] = [1e-3, 1e-2, 1e-1, 1.0, 1e1, 1e2, 1e3];

/// How a curve without a formula is told.
struct Told {
    effect: &'static str,
    what: &'static str,
    over: &'static str,
    /// Whether the axis runs to both sides of zero.
    both_sides: bool,
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

/// A quantity with its unit.
#[derive(Debug, Clone, PartialEq)]
pub struct Named {
    pub name: String,
    pub unit: String,
}

/// What is missing at one place, as far as a record shows it.
#[derive(Debug, Clone, PartialEq)]
pub struct Missing {
    /// Where it acts: a node or a component.
    pub at: String,
    pub what: Named,
    pub over: Named,
    /// Share that it takes away of what is missed beyond noise and tolerance, to first order.
    pub explains: f64,
    /// State, value and half of its 95 % band, over what the record visited; NaN between states where it never stays.
    pub curve: Vec<(f64, f64, f64)>,
    /// State and value of the law that was found: where the curve stands for it as it is, elsewhere what the record would make of it
    /// there, with the gaps of the curve; empty without one.
    pub law: Vec<(f64, f64)>,
    /// Share of the law that the state determines where the curve acts at the same nodes; `None` where it does not stand for the law.
    pub stands_for_law: Option<f64>,
}

/// What may be missing at every place of a rig, what explains most first: beside the faults and all else as `base` has them,
/// so that what these have taken over is not in it. `found` is what was found to be missing in it.
///
/// # Errors
/// Columns that are missing, or a model that cannot be solved.
pub fn missing(base: &FittedModel, record: &Record, found: Option<Found<'_>>) -> Result<Vec<Missing>, Complaint> {
    base.rig.context().run(|| missing_here(base, record, found))
}

fn missing_here(base: &FittedModel, record: &Record, found: Option<Found<'_>>) -> Result<Vec<Missing>, Complaint> {
    let own = Slopes::of_fitted(base, record)?;
    let lacking = found.map(|found| {
        let pairs = found.model.fit.outputs.iter().flatten().zip(base.fit.outputs.iter().flatten());
        let mut change: Vec<f64> = pairs.map(|(with, without)| without - with).collect();
        base.fit.weights.apply(&mut change);
        (found, change)
    });
    let curves: Vec<EffectInstance> = empirical(&base.rig).into_iter().map(|curve| curve.placed).collect();
    let mut all: Vec<Missing> =
        curves.par_iter().filter_map(|placed| one(base, record, &own, placed, lacking.as_ref())).collect();
    all.sort_by(|a, b| b.explains.total_cmp(&a.explains));
    Ok(all)
}

/// Weighted derivatives of the misfits by parameters, a column each, and what is known of these before the record.
struct Slopes {
    columns: Vec<Vec<f64>>,
    /// One over the standard deviation; 0 where nothing is known.
    known: Vec<f64>,
    /// How far each stands from where it was expected, SI.
    away: Vec<f64>,
}

impl Slopes {
    /// Of everything that was fitted.
    fn of_fitted(base: &FittedModel, record: &Record) -> Result<Self, Complaint> {
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

/// The curve at one place; `None` where the record shows nothing of it.
fn one(
    base: &FittedModel,
    record: &Record,
    own: &Slopes,
    placed: &EffectInstance,
    lacking: Option<&(Found<'_>, Vec<f64>)>,
) -> Option<Missing> {
    let told = TOLD.iter().find(|told| told.effect == placed.effect.name)?;
    let quantity = match told.over {
        PRESSURE => Quantity::Pressure,
        "speed" => Quantity::Velocity,
        _ => Quantity::Position,
    };
    let drive = InputSignals::from_record(&base.rig, record).ok()?;
    let run = (&drive, record.time.as_slice());
    let (rig, indices) = with_curve(base, run, placed, quantity)?;
    let mut values = base.values.clone();
    values.extend(rig.parameters[values.len()..].iter().map(|parameter| parameter.value));
    let model = Model::new(rig);
    let heights = columns(&model, &values, &indices, &drive, record, &base.fit).ok()?;
    let visited = visited(model.rig.settings().learn.visited_share, &heights)?;
    let unit = model.rig.effect_unit(placed, placed.effect.parameters[0].name);
    let InitialGuess::Value(typical) = placed.effect.parameters[0].first else { return None };
    let fitted =
        Fitted::new(&base.rig.settings().learn, (own, &heights), &base.fit.misfit, unit.difference_to_si(typical))?;
    let (step, spread) = fitted.curve(&fitted.pull);
    let seen = lacking.map(|(found, change)| (fitted.curve(&fitted.slope(change)).0, found.lacking));
    let axis = Axis::of(&model.rig, quantity, told.both_sides)?;
    let shares_of_rows = axis.shares(&model.rig, &values, run, placed)?;
    let stays = stays(&shares_of_rows);
    let law = lacking.and_then(|(found, _)| LawOnAxis::of(found, run, &model.rig, &indices, &axis));
    let (from, to) = match &law {
        None => visited,
        Some(_) => {
            let within = |from: f64, pick: fn(f64, f64) -> f64| {
                shares_of_rows.iter().filter(|share| share.is_finite()).copied().fold(from, pick).clamp(0.0, 1.0)
            };
            (within(f64::INFINITY, f64::min), within(f64::NEG_INFINITY, f64::max))
        }
    };
    let shown = |si: f64| unit.difference_from_si(si);
    let there = |share: f64, si: f64| {
        let asked = stays[piece(share)] && (visited.0..=visited.1).contains(&share);
        if asked { si } else { f64::NAN }
    };
    let mut one = Missing {
        at: placed_name(&model.rig, placed),
        what: Named { name: told.what.to_owned(), unit: unit.symbol.clone() },
        over: Named { name: told.over.to_owned(), unit: axis.unit.symbol.clone() },
        explains: fitted.explains,
        curve: Vec::new(),
        law: Vec::new(),
        stands_for_law: law.as_ref().map(|law| law.determined),
    };
    for k in 0..=POINTS {
        let share = from + (to - from) * k as f64 / POINTS as f64;
        let (at, basis) = (axis.at(share), basis(share));
        let half = QUANTILE * (basis.transpose() * &spread * &basis)[0].sqrt();
        // The record asks for the law that was found, and for what it wants beside what is lacking of it.
        let asked = match &seen {
            None => basis.dot(&step),
            Some((seen, lacking)) => {
                let seen = basis.dot(seen);
                let is = law.as_ref().map_or(there(share, seen / lacking), |law| law.at(axis.unit.to_si(at)));
                one.law.push((at, shown(is)));
                is + basis.dot(&step) - seen
            }
        };
        one.curve.push((at, there(share, shown(asked)), there(share, shown(half))));
    }
    one.curve.iter().any(|point| !point.1.is_nan()).then_some(one)
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

/// The place behind the `@` of an effect.
fn placed_name(rig: &Rig, placed: &EffectInstance) -> String {
    let id = rig.effect_id(placed);
    id.split_once('@').map_or(id.clone(), |(_, at)| at.to_owned())
}

/// First and last place of the axis, as shares of it, that the record has visited.
fn visited(least: f64, heights: &[Vec<f64>]) -> Option<(f64, f64)> {
    let sizes: Vec<f64> = heights.iter().map(|column| column.iter().map(|c| c * c).sum::<f64>().sqrt()).collect();
    let largest = sizes.iter().copied().fold(0.0, f64::max);
    let seen = |size: &f64| largest > 0.0 && *size >= least * largest;
    let (first, last) = (sizes.iter().position(seen)?, sizes.iter().rposition(seen)?);
    let peak = |height: usize| ((height as f64 - 1.0) / (HEIGHTS - 3) as f64).clamp(0.0, 1.0);
    (last > first).then(|| (peak(first), peak(last)))
}

/// Weights of the heights at a share of the axis.
fn basis(share: f64) -> DVector<f64> {
    DVector::from_fn(HEIGHTS, |height, _| {
        let mut alone = [0.0; HEIGHTS];
        alone[height] = 1.0;
        Curve::new(&alone).at(share)
    })
}

/// Normal equations of a curve beside everything fitted, at the bend that makes the record most likely.
struct Fitted<'a> {
    columns: Vec<&'a [f64]>,
    factor: Cholesky<f64, Dyn>,
    /// Slope of half the cost.
    pull: DVector<f64>,
    /// Variance of a misfit that is left.
    left: f64,
    explains: f64,
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
        let left = (after / samples.max(1) as f64).max(1.0);
        let missed = before - samples as f64;
        let explains = if missed > 0.0 { ((before - after) / missed).clamp(0.0, 1.0) } else { 0.0 };
        Some(Self { columns, factor, pull, left, explains })
    }

    fn slope(&self, misfit: &[f64]) -> DVector<f64> {
        DVector::from_iterator(self.columns.len(), self.columns.iter().map(|column| dot(column, misfit)))
    }

    /// Heights, SI, and their covariance, for a slope of half the cost.
    fn curve(&self, pull: &DVector<f64>) -> (DVector<f64>, DMatrix<f64>) {
        let step = -self.factor.solve(pull);
        let first = step.len() - HEIGHTS;
        let covariance = self.factor.inverse() * self.left;
        (step.rows(first, HEIGHTS).into(), covariance.view((first, first), (HEIGHTS, HEIGHTS)).into())
    }
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
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
