//! The Schur complement: what is left of a local quadratic model for some parameters when all others follow them.

use std::f64::consts::PI;

use nalgebra::{DMatrix, DVector};

use super::bounded_step::{Linear, bounded_step};
use super::criteria::occam;
use super::local_model::LocalModel;
use super::prior::Gaussian;
use super::triangle::Triangle;

/// Share of what its range alone says of a parameter, in variance, that keeps a direction without influence unique.
const TRACE: f64 = 1e-6;

/// A quadratic form over the deviations of some parameters from their means, everything else at its best:
/// `constant + |R d + z|^2`, per scale. It comes from a QR factorisation whose first columns are those that follow, so
/// nothing is inverted.
#[derive(Debug, Clone, PartialEq)]
pub struct SchurComplement {
    /// Of what is asked for.
    triangle: Triangle,
    /// Columns of those that follow, then of those that are asked for.
    joint: DMatrix<f64>,
    /// Those that follow: indices among all parameters.
    following: Vec<usize>,
    constant: f64,
    /// Deviations allowed, in scales.
    slack: Vec<(f64, f64)>,
    /// Inverse variance of a deviation before the record, per scale squared: that of a normal distribution as high as the
    /// uniform one over the range.
    spread: Vec<f64>,
}

/// The least of the form for some parameters, the others at their means.
#[derive(Debug, Clone, PartialEq)]
pub struct Best {
    /// `2 F` of record and prior.
    pub cost: f64,
    /// One per parameter asked for, in scales.
    pub deviation: Vec<f64>,
}

/// How the estimate of a parameter moves with its own gradient: a column of the covariance, per scale.
#[derive(Debug, Clone, PartialEq)]
pub struct Along {
    /// Of all parameters.
    pub total: DVector<f64>,
    /// The share of it that is uncertain before the record, and held by what is known of it.
    pub known: DVector<f64>,
    /// Of the estimate itself, for white misfits.
    pub variance: f64,
}

impl SchurComplement {
    /// Over the first parameters of a model, one for each of their `bounds`; the members of the `prior` follow. Where one of
    /// the first is a member too, it has a part that is known before, and one that is asked for. `mean` has all parameters.
    pub fn new(model: &LocalModel, prior: &Gaussian, mean: &[f64], bounds: &[(f64, f64)]) -> Self {
        let (p, following, asked) = (model.count(), prior.members.len(), bounds.len());
        let whole = model.triangle();
        let back = DVector::from_fn(p, |i, _| (mean[i] - model.theta[i]) / model.scale[i]);
        let shifted = &whole.z + &whole.r * back;
        let mut rows = DMatrix::zeros(p + prior.len(), following + asked + 1);
        for (k, &j) in prior.members.iter().chain(&(0..asked).collect::<Vec<_>>()).enumerate() {
            rows.view_mut((0, k), (p, 1)).copy_from(&whole.r.column(j));
        }
        rows.view_mut((0, following + asked), (p, 1)).copy_from(&shifted);
        let known = prior.jacobian(p);
        for (k, &j) in prior.members.iter().enumerate() {
            rows.view_mut((p, k), (prior.len(), 1)).copy_from(&(known.column(j) * model.scale[j]));
        }
        let Triangle { r, z, rest } = Triangle::of(rows);
        let own = Triangle {
            r: r.view((following, following), (asked, asked)).into_owned(),
            z: z.rows(following, asked).into_owned(),
            rest,
        };
        let constant = 2.0 * model.loss.cost(&model.misfit) - whole.z.norm_squared() + rest * rest;
        let in_scales = |i: usize, value: f64| (value - mean[i]) / model.scale[i];
        let slack = bounds.iter().enumerate().map(|(i, &(low, high))| (in_scales(i, low), in_scales(i, high)));
        let spread =
            bounds.iter().zip(&model.scale).map(|((low, high), scale)| 2.0 * PI * (scale / (high - low)).powi(2));
        let (slack, spread) = (slack.collect(), spread.collect());
        Self { triangle: own, joint: r, following: prior.members.clone(), constant, slack, spread }
    }

    /// Columns of some parameters, cut off below the last row that is not zero.
    fn columns(&self, all: &[usize]) -> DMatrix<f64> {
        let rows = all.iter().max().map_or(0, |last| last + 1);
        DMatrix::from_fn(rows, all.len(), |i, k| self.triangle.r[(i, all[k])])
    }

    /// The best deviations of some parameters; `None` where one that can only go one way would have to go the other.
    pub fn best(&self, parameters: impl Iterator<Item = usize>) -> Option<Best> {
        let all: Vec<usize> = parameters.collect();
        let a = self.columns(&all);
        let b = self.triangle.z.rows(0, a.nrows()).into_owned();
        let damping: Vec<f64> = all.iter().map(|&i| (TRACE * self.spread[i]).sqrt()).collect();
        let slack: Vec<(f64, f64)> = all.iter().map(|&i| self.slack[i]).collect();
        let deviation = bounded_step(Linear { a: &a, b: &b, damping: &damping }, &slack);
        let stays = |(d, (low, high)): (&f64, &(f64, f64))| *d == 0.0 && (*low == 0.0 || *high == 0.0);
        if deviation.iter().zip(&slack).any(stays) {
            return None;
        }
        let left = &a * DVector::from_column_slice(&deviation) + b;
        let below = self.triangle.z.rows_range(a.nrows()..).norm_squared();
        Some(Best { cost: self.constant + left.norm_squared() + below, deviation })
    }

    /// Logarithm of the share of their prior volume that the record leaves some parameters; see [`occam`]. `inflation`
    /// divides the information.
    pub fn occam(&self, parameters: impl Iterator<Item = usize>, inflation: f64) -> f64 {
        let all: Vec<usize> = parameters.collect();
        let mut ratio = self.columns(&all);
        for (mut column, &i) in ratio.column_iter_mut().zip(&all) {
            column /= (inflation * self.spread[i]).sqrt();
        }
        occam(ratio)
    }

    /// How everything moves with the estimate of one parameter while some others are asked for too; `count` is that of all
    /// parameters.
    pub fn along(&self, others: impl Iterator<Item = usize>, parameter: usize, count: usize) -> Along {
        let asked: Vec<usize> = others.filter(|&other| other != parameter).chain([parameter]).collect();
        let (rows, first) = (self.joint.nrows(), self.following.len());
        let n = first + asked.len();
        let mut stacked = DMatrix::zeros(rows + asked.len(), n + 1);
        stacked.view_mut((0, 0), (rows, first)).copy_from(&self.joint.columns(0, first));
        for (k, &i) in asked.iter().enumerate() {
            stacked.view_mut((0, first + k), (rows, 1)).copy_from(&self.joint.column(first + i));
            stacked[(rows + k, first + k)] = (TRACE * self.spread[i]).sqrt();
        }
        let r = Triangle::of(stacked).r;
        // A column of the inverse of R'R: the last, so that R'^-1 of its unit vector has one entry.
        let mut unit = DVector::zeros(n);
        unit[n - 1] = r[(n - 1, n - 1)].recip();
        let moved = r.solve_upper_triangular(&unit).unwrap_or(unit);
        let mut known = DVector::zeros(count);
        self.following.iter().zip(moved.iter()).for_each(|(&member, &by)| known[member] = by);
        let mut total = known.clone();
        asked.iter().zip(moved.iter().skip(first)).for_each(|(&i, &by)| total[i] += by);
        Along { total, known, variance: moved[n - 1] }
    }

    /// Independent combinations of parameters of which the record says more than their ranges do.
    pub fn rank(&self) -> usize {
        let mut ratio = self.triangle.r.clone();
        for (mut column, spread) in ratio.column_iter_mut().zip(&self.spread) {
            column /= spread.sqrt();
        }
        ratio.singular_values().iter().filter(|value| **value > 1.0).count()
    }

    /// Standard deviation of one parameter while some others are free too, in scales; `None` where the record says no more
    /// than its range.
    pub fn sigma(&self, others: impl Iterator<Item = usize>, parameter: usize) -> Option<f64> {
        // The last pivot of a triangle is what only the last column has.
        let all: Vec<usize> = others.filter(|&other| other != parameter).chain([parameter]).collect();
        let columns = self.columns(&all);
        let (rows, n) = columns.shape();
        let mut stacked = columns.resize(rows + n, n + 1, 0.0);
        for (k, &i) in all.iter().enumerate() {
            stacked[(rows + k, k)] = (TRACE * self.spread[i]).sqrt();
        }
        let information = Triangle::of(stacked).r[(n - 1, n - 1)].powi(2);
        (information > self.spread[parameter]).then(|| information.sqrt().recip())
    }
}
