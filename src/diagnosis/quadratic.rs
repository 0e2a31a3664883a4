//! The cost of a record around one point: a quadratic form that answers for every set of faults at once.

use nalgebra::{Cholesky, DMatrix, DVector, Dyn};

use super::case::{Case, ROBUST};
use crate::fit::{Linearised, Problem, long_run_variance};
use crate::model::SimulationError;
use crate::rig::FaultSet;

/// `2 F(theta) = sum rho(r²)` of the record alone, and its quadratic model by Gauss and Newton. Parameters are in units of
/// their scales, so that they can be compared.
#[derive(Debug, Clone)]
pub struct Quadratic {
    /// Where it was taken, SI.
    pub theta: Vec<f64>,
    pub misfit: Vec<f64>,
    pub scale: Vec<f64>,
    /// Rows of misfits, columns of all estimated parameters, per scale.
    jacobian: DMatrix<f64>,
    /// `J' W J` with the weights of the robust loss.
    matrix: DMatrix<f64>,
}

/// What is left for the faults when everything uncertain follows them: a form over their deviations from healthy.
#[derive(Debug, Clone)]
pub struct Reduced {
    pub matrix: DMatrix<f64>,
    gradient: DVector<f64>,
    /// `2 F` of the healthy rig, in the quadratic model.
    constant: f64,
    /// Deviations allowed, in scales.
    room: Vec<(f64, f64)>,
    /// Inverse variance of a fault's deviation before the record, per scale squared.
    spread: Vec<f64>,
}

/// The best deviations of a set of faults in the quadratic model.
pub struct Best {
    /// `2 F` of record and prior.
    pub cost: f64,
    /// One per member of the set, in scales.
    pub deviation: Vec<f64>,
}

/// What the misfits say of a further change that the model does not have.
#[derive(Debug, Clone)]
pub struct Score {
    /// Factor on the change at which the cost would be least.
    pub factor: f64,
    /// `s_perp' s_perp`: inverse variance of that factor.
    pub information: f64,
    /// Share of the change, root of squares, that nothing estimated can take over.
    pub own: f64,
    /// The estimated parameter that takes over most of it.
    pub absorbed_by: Option<usize>,
}

impl Score {
    /// Fall of the cost at a factor on the change, everything estimated following.
    pub fn fall_at(&self, factor: f64) -> f64 {
        self.information * factor * (2.0 * self.factor - factor)
    }
}

/// A point at which further changes of the misfits are scored.
pub struct Scoring<'a> {
    form: &'a Quadratic,
    free: Vec<usize>,
    /// Of what record and prior say of the free parameters, per scales.
    factor: Cholesky<f64, Dyn>,
    /// Half the derivative of the cost by them: next to nothing at the optimum.
    slope: DVector<f64>,
    weights: Vec<f64>,
    /// Misfits as the robust loss weighs them.
    pull: Vec<f64>,
}

impl Scoring<'_> {
    /// The score test of a `change` of the misfits.
    pub fn of(&self, change: &[f64]) -> Score {
        let weighted = DVector::from_iterator(change.len(), change.iter().zip(&self.weights).map(|(s, w)| s * w));
        let across = self.form.jacobian.tr_mul(&weighted);
        let across = DVector::from_fn(self.free.len(), |a, _| across[self.free[a]]);
        let follow = self.factor.solve(&across);
        let total: f64 = change.iter().zip(weighted.iter()).map(|(s, weighted)| s * weighted).sum();
        let information = (total - across.dot(&follow)).max(0.0);
        // What follows takes its own pull along, that of what is known of it before too.
        let pull = change.iter().zip(&self.pull).map(|(s, pull)| s * pull).sum::<f64>() - follow.dot(&self.slope);
        let taken = |a: usize| (follow[a] * across[a]).abs();
        let most = (0..self.free.len()).max_by(|&a, &b| taken(a).total_cmp(&taken(b)));
        Score {
            factor: if information > 0.0 { -pull / information } else { 0.0 },
            information,
            own: if total > 0.0 { (information / total).sqrt() } else { 0.0 },
            absorbed_by: most.map(|a| self.free[a]),
        }
    }
}

impl Quadratic {
    /// # Errors
    /// The model cannot be solved at `theta`.
    pub fn at(case: &Case<'_>, theta: &[f64]) -> Result<Self, SimulationError> {
        Ok(Self::of(case, theta, case.full.linearise(theta)?))
    }

    /// From the misfits and their derivatives at `theta`.
    pub(super) fn of(case: &Case<'_>, theta: &[f64], linearised: Linearised) -> Self {
        let scale = case.full.scale();
        let mut jacobian = linearised.jacobian;
        for (mut column, scale) in jacobian.column_iter_mut().zip(&scale) {
            column *= *scale;
        }
        let misfit = linearised.misfit;
        let weights: Vec<f64> = misfit.iter().map(|r| ROBUST.at(r * r).1).collect();
        let matrix = gram(&jacobian, &weights);
        Self { theta: theta.to_vec(), misfit, scale, jacobian, matrix }
    }

    /// What record and prior (its `precision` per scales) say of the `free` parameters, per scales.
    pub fn information(&self, precision: &DMatrix<f64>, free: &[usize]) -> DMatrix<f64> {
        DMatrix::from_fn(free.len(), free.len(), |a, b| {
            let information = self.matrix[(free[a], free[b])] + precision[(free[a], free[b])];
            // Keeps a direction without influence where it is.
            if a == b { information * (1.0 + 1e-12) + 1e-9 } else { information }
        })
    }

    /// How all parameters move, in scales, with the gradient of one fault while those of `set` are present: a column of
    /// [`Quadratic::inverse`].
    pub fn direction(&self, case: &Case<'_>, set: FaultSet, fault: usize) -> Option<DVector<f64>> {
        let free = case.free(set);
        let mut unit = DVector::zeros(free.len());
        unit[free.iter().position(|&index| index == fault)?] = 1.0;
        let solved = Cholesky::new(self.information(&case.precision(set, &self.scale), &free))?.solve(&unit);
        let mut direction = DVector::zeros(case.count());
        for (a, &index) in free.iter().enumerate() {
            direction[index] = solved[a];
        }
        Some(direction)
    }

    /// Covariance of all parameters while the faults of `set` are present, in scales; zero for those that are held.
    pub fn inverse(&self, case: &Case<'_>, set: FaultSet) -> Option<DMatrix<f64>> {
        let free = case.free(set);
        let solved = Cholesky::new(self.information(&case.precision(set, &self.scale), &free))?.inverse();
        let mut inverse = DMatrix::zeros(case.count(), case.count());
        for (a, &i) in free.iter().enumerate() {
            for (b, &j) in free.iter().enumerate() {
                inverse[(i, j)] = solved[(a, b)];
            }
        }
        Some(inverse)
    }

    /// Half the derivative of `2 F` by the parameters in units of their scales, at other misfits, by the Jacobian from here.
    pub fn gradient(&self, misfit: &[f64]) -> DVector<f64> {
        let pull = DVector::from_iterator(misfit.len(), misfit.iter().map(|&r| r * ROBUST.at(r * r).1));
        self.jacobian.tr_mul(&pull)
    }

    /// Whether the Jacobian foresees what moving from values of all parameters to others (SI) does to the misfits, up to a
    /// share of the squared change.
    pub fn foresees(&self, before: (&[f64], &[f64]), after: (&[f64], &[f64]), share: f64) -> bool {
        let step = (0..self.scale.len()).map(|index| (after.0[index] - before.0[index]) / self.scale[index]);
        let expected = &self.jacobian * DVector::from_iterator(self.scale.len(), step);
        let (mut missed, mut change) = (0.0, 0.0);
        for ((expected, before), after) in expected.iter().zip(before.1).zip(after.1) {
            let moved = after - before;
            missed += (moved - expected).powi(2);
            change += moved * moved;
        }
        missed <= share * change
    }

    /// By how much colour in the misfits raises the variance of the estimate that moves along `direction` (in scales): its
    /// long-run variance over that of white misfits; 1 or more.
    pub fn inflation(&self, direction: &DVector<f64>, series: &[std::ops::Range<usize>]) -> f64 {
        let influence = &self.jacobian * direction;
        let (mut coloured, mut white) = (0.0, 0.0);
        for range in series {
            let score = |row: usize| {
                let r = self.misfit[row];
                influence[row] * r * ROBUST.at(r * r).1
            };
            let scores: Vec<f64> = range.clone().map(score).collect();
            coloured += long_run_variance(&scores);
            white += range.clone().map(|row| influence[row].powi(2)).sum::<f64>();
        }
        if white > 0.0 { (coloured / white).max(1.0) } else { 1.0 }
    }

    /// What the score test needs of values of all estimated parameters (SI) and the misfits there, while the faults of `set`
    /// are estimated too. `None` where the information cannot be inverted.
    pub fn scoring(&self, case: &Case<'_>, set: FaultSet, (theta, misfit): (&[f64], &[f64])) -> Option<Scoring<'_>> {
        let free = case.free(set);
        let precision = case.precision(set, &self.scale);
        let slope = self.gradient(misfit) + &precision * case.away(theta, &self.scale);
        let factor = Cholesky::new(self.information(&precision, &free))?;
        let slope = DVector::from_fn(free.len(), |a, _| slope[free[a]]);
        let weights: Vec<f64> = misfit.iter().map(|&r| ROBUST.at(r * r).1).collect();
        let pull = misfit.iter().zip(&weights).map(|(r, weight)| r * weight).collect();
        Some(Scoring { form: self, free, factor, slope, weights, pull })
    }

    /// The form over the faults with everything uncertain left to follow.
    pub fn reduced(&self, case: &Case<'_>) -> Reduced {
        let count = case.faults();
        let precision = case.precision(FaultSet::EMPTY, &self.scale);
        // From here to the healthy rig.
        let back = -case.away(&self.theta, &self.scale);
        let here = self.gradient(&self.misfit);
        let gradient = &here + &self.matrix * &back;
        let constant = 2.0 * ROBUST.cost(&self.misfit) + 2.0 * here.dot(&back) + back.dot(&(&self.matrix * &back));
        let known = &case.known;
        let inner = DMatrix::from_fn(known.len(), known.len(), |a, b| {
            self.matrix[(known[a], known[b])] + precision[(known[a], known[b])]
        });
        let across = DMatrix::from_fn(known.len(), count, |a, fault| self.matrix[(known[a], fault)]);
        let own = DVector::from_fn(known.len(), |a, _| gradient[known[a]]);
        let direct = self.matrix.view((0, 0), (count, count)).into_owned();
        let pull = gradient.rows(0, count).into_owned();
        let factor = Cholesky::new(inner);
        let (matrix, gradient, constant) = match factor {
            Some(factor) if !known.is_empty() => {
                let (follow, drawn) = (factor.solve(&across), factor.solve(&own));
                (direct - across.tr_mul(&follow), pull - across.tr_mul(&drawn), constant - own.dot(&drawn))
            }
            _ => (direct, pull, constant),
        };
        let faults = &case.rig().faults;
        let in_scales = |fault: usize, value: f64| (value - case.mean[fault]) / self.scale[fault];
        let room = (0..count).map(|i| (in_scales(i, faults[i].bounds.0), in_scales(i, faults[i].bounds.1))).collect();
        let spread = (0..count).map(|i| 2.0 * std::f64::consts::PI * (self.scale[i] / case.range(i)).powi(2)).collect();
        Reduced { matrix, gradient, constant, room, spread }
    }
}

/// Rows whose products are summed at a time: what of a Jacobian stays near the processor.
const ROWS: usize = 512;

/// `J' W J` with a weight for each row.
fn gram(jacobian: &DMatrix<f64>, weights: &[f64]) -> DMatrix<f64> {
    let count = jacobian.ncols();
    let mut matrix = DMatrix::zeros(count, count);
    let mut weighted = DVector::zeros(ROWS);
    for (block, weights) in weights.chunks(ROWS).enumerate() {
        let rows = jacobian.rows(block * ROWS, weights.len());
        for i in 0..count {
            let mut own = weighted.rows_mut(0, weights.len());
            own.iter_mut()
                .zip(rows.column(i).iter())
                .zip(weights)
                .for_each(|((own, value), weight)| *own = value * weight);
            for j in 0..=i {
                matrix[(i, j)] += own.dot(&rows.column(j));
            }
        }
    }
    matrix.fill_upper_triangle_with_lower_triangle();
    matrix
}

impl Reduced {
    /// The best deviations of a set; `None` where a fault that can only go one way would have to go the other.
    pub fn best(&self, set: FaultSet) -> Option<Best> {
        let all: Vec<usize> = set.iter().collect();
        let mut held: Vec<Option<f64>> = vec![None; all.len()];
        loop {
            let free: Vec<usize> = (0..all.len()).filter(|&k| held[k].is_none()).collect();
            let pull = DVector::from_fn(free.len(), |k, _| {
                let at = all[free[k]];
                let others = (0..all.len()).filter_map(|j| Some(self.matrix[(at, all[j])] * held[j]?));
                self.gradient[at] + others.sum::<f64>()
            });
            let factor = self.factor(&free.iter().map(|&k| all[k]).collect::<Vec<_>>())?;
            let step = factor.solve(&(-&pull));
            let mut deviation: Vec<f64> = held.iter().map(|held| held.unwrap_or(0.0)).collect();
            for (place, &k) in free.iter().enumerate() {
                deviation[k] = step[place];
            }
            let outside = free.iter().copied().find(|&k| {
                let (low, high) = self.room[all[k]];
                deviation[k] < low || deviation[k] > high
            });
            if let Some(k) = outside {
                let (low, high) = self.room[all[k]];
                let end = if deviation[k] < low { low } else { high };
                if end == 0.0 {
                    return None;
                }
                held[k] = Some(end);
                continue;
            }
            let mut cost = self.constant;
            for (a, &i) in all.iter().enumerate() {
                cost += 2.0 * self.gradient[i] * deviation[a];
                cost += all.iter().zip(&deviation).map(|(&j, d)| self.matrix[(i, j)] * d).sum::<f64>() * deviation[a];
            }
            return Some(Best { cost, deviation });
        }
    }

    fn factor(&self, faults: &[usize]) -> Option<Cholesky<f64, Dyn>> {
        // A trace of the spread keeps a direction without influence unique.
        let inner = DMatrix::from_fn(faults.len(), faults.len(), |a, b| {
            let trace = if a == b { 1e-6 * self.spread[faults[a]] } else { 0.0 };
            self.matrix[(faults[a], faults[b])] + trace
        });
        Cholesky::new(inner)
    }

    /// Logarithm of the share of its prior volume that the record leaves a set, at most 0: Laplace's approximation with a
    /// normal prior as high as the uniform one over the range. `colour` divides the information.
    pub fn occam(&self, set: FaultSet, colour: f64) -> f64 {
        let all: Vec<usize> = set.iter().collect();
        let ratio = DMatrix::from_fn(all.len(), all.len(), |a, b| {
            let (i, j) = (all[a], all[b]);
            let one = if a == b { 1.0 } else { 0.0 };
            self.matrix[(i, j)] / (colour * (self.spread[i] * self.spread[j]).sqrt()) + one
        });
        // Half the logarithm of the determinant is the sum of those of the factor's diagonal.
        Cholesky::new(ratio).map_or(0.0, |factor| -factor.l_dirty().diagonal().iter().map(|d| d.ln()).sum::<f64>())
    }

    /// Independent combinations of faults of which the record says more than their ranges do.
    pub fn rank(&self) -> usize {
        let ratio = DMatrix::from_fn(self.spread.len(), self.spread.len(), |i, j| {
            self.matrix[(i, j)] / (self.spread[i] * self.spread[j]).sqrt()
        });
        ratio.symmetric_eigenvalues().iter().filter(|information| **information > 1.0).count()
    }

    /// Standard deviation of one fault while those of `set` are present too, in scales; `None` where the record says nothing.
    pub fn sigma(&self, set: FaultSet, fault: usize) -> Option<f64> {
        let all: Vec<usize> = set.with(fault).iter().collect();
        let place = all.iter().position(|&member| member == fault)?;
        let mut unit = DVector::zeros(all.len());
        unit[place] = 1.0;
        let variance = self.factor(&all)?.solve(&unit)[place];
        let most = 1.0 / self.spread[fault];
        (variance > 0.0 && variance < most).then(|| variance.sqrt())
    }
}
