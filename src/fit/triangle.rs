//! The triangle that a long Jacobian is reduced to.

use super::loss::Loss;
use super::problem::Linearised;
use nalgebra::{DMatrix, DVector};

/// Rows that are taken in at a time: a block of this size with some ten columns stays in the first-level cache.
const BLOCK: usize = 128;

/// `[R z; 0 t]`, the upper triangle of the QR factorisation of `[J r]`.
///
/// It says all about the linear model that least squares asks: `|J d + r|^2 = |R d + z|^2 + t^2`. Unlike `J^T J` it does
/// not square the condition number, and unlike a QR of the whole it needs no copy of `J`.
/// Source: Golub and Van Loan, *Matrix Computations* (4th ed.), sections 5.2 and 6.5 (updating by rows).
#[derive(Debug, Clone, PartialEq)]
pub struct Triangle {
    /// `p` by `p`, upper triangular; diagonal of any sign.
    pub r: DMatrix<f64>,
    /// `p`.
    pub z: DVector<f64>,
    /// What no parameter can explain, `t`.
    pub rest: f64,
}

impl Triangle {
    /// Reduces `[J r]`, with the rows corrected for the loss, block by block: `2 m (p+1)^2` operations.
    pub fn reduce(seen: &Linearised, loss: Loss) -> Self {
        let (m, p) = seen.jacobian.shape();
        let width = p + 1;
        let mut work = DMatrix::zeros(width + BLOCK, width);
        let mut from = 0;
        while from < m {
            let rows = BLOCK.min(m - from);
            let factors: Vec<_> = seen.misfit[from..from + rows].iter().map(|&r| loss.row_factors(r)).collect();
            for j in 0..p {
                let source = &seen.jacobian.as_slice()[j * m + from..j * m + from + rows];
                let target = &mut work.as_mut_slice()[j * (width + BLOCK) + width..][..rows];
                for ((t, s), (_, on_row)) in target.iter_mut().zip(source).zip(&factors) {
                    *t = s * on_row;
                }
            }
            for (i, (on_misfit, _)) in factors.iter().enumerate() {
                work[(width + i, p)] = seen.misfit[from + i] * on_misfit;
            }
            triangularise(&mut work, width, rows);
            from += rows;
        }
        let r = work.view((0, 0), (p, p)).into_owned();
        let z = DVector::from_fn(p, |i, _| work[(i, p)]);
        Self { r, z, rest: work[(p, p)].abs() }
    }

    /// Number of parameters.
    pub fn len(&self) -> usize {
        self.z.len()
    }

    /// Whether there are no parameters.
    pub fn is_empty(&self) -> bool {
        self.z.is_empty()
    }

    /// `J^T r`, the gradient of the cost.
    pub fn gradient(&self) -> DVector<f64> {
        self.r.tr_mul(&self.z)
    }

    /// `|J_j|`, the length of each column: how much all misfits together move per unit of a parameter.
    pub fn column_norms(&self) -> Vec<f64> {
        self.r.column_iter().map(|c| c.norm()).collect()
    }

    /// `F(0) - F(d)` of the linear model, free of the cancellation of subtracting two costs.
    pub fn predicted_decrease(&self, step: &[f64]) -> f64 {
        let moved = &self.r * DVector::from_column_slice(step);
        -(self.z.dot(&moved) + 0.5 * moved.norm_squared())
    }
}

/// Householder triangularisation, in place, of a matrix whose first `top` rows are an upper triangle already and whose
/// `below` rows after those are full. Leaves the rows below untidy: they are overwritten by the next block.
pub(super) fn triangularise(a: &mut DMatrix<f64>, top: usize, below: usize) {
    let (rows, columns) = a.shape();
    let data = a.as_mut_slice();
    for j in 0..columns.min(top) {
        let (head, tail) = data.split_at_mut((j + 1) * rows);
        let column = &mut head[j * rows..];
        let norm_below = column[top..top + below].iter().map(|v| v * v).sum::<f64>();
        if norm_below == 0.0 {
            continue;
        }
        let pivot = column[j];
        let norm = (pivot * pivot + norm_below).sqrt();
        let diagonal = if pivot > 0.0 { -norm } else { norm };
        let lead = pivot - diagonal;
        let beta = -1.0 / (diagonal * lead);
        column[j] = diagonal;
        let vector = &column[top..top + below];
        for other in tail.chunks_exact_mut(rows) {
            let (upper, lower) = other.split_at_mut(top);
            let lower = &mut lower[..below];
            let dot = lead * upper[j] + dot(vector, lower);
            let factor = beta * dot;
            upper[j] -= factor * lead;
            for (o, v) in lower.iter_mut().zip(vector) {
                *o -= factor * v;
            }
        }
    }
}

/// Four running sums, so that the additions need not wait for each other.
fn dot(a: &[f64], b: &[f64]) -> f64 {
    let mut sums = [0.0; 4];
    let (a4, b4) = (a.chunks_exact(4), b.chunks_exact(4));
    let rest: f64 = a4.remainder().iter().zip(b4.remainder()).map(|(x, y)| x * y).sum();
    for (x, y) in a4.zip(b4) {
        for k in 0..4 {
            sums[k] += x[k] * y[k];
        }
    }
    sums.iter().sum::<f64>() + rest
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn reduces_to_the_same_normal_equations() {
        let m = 1000;
        let jacobian = DMatrix::from_fn(m, 4, |i, j| ((i * (j + 2)) as f64 * 0.37).sin() * 10f64.powi(j as i32));
        let misfit: Vec<f64> = (0..m).map(|i| (i as f64 * 0.11).cos() + 0.5).collect();
        let seen = Linearised { misfit: misfit.clone(), jacobian: jacobian.clone() };
        let triangle = Triangle::reduce(&seen, Loss::None);
        let (squared, expected) = (triangle.r.tr_mul(&triangle.r), jacobian.tr_mul(&jacobian));
        approx::assert_relative_eq!(squared, expected, max_relative = 1e-12, epsilon = 1e-8);
        let gradient = jacobian.tr_mul(&DVector::from_vec(misfit.clone()));
        approx::assert_relative_eq!(triangle.gradient(), gradient, max_relative = 1e-12, epsilon = 1e-9);
        let total = triangle.z.norm_squared() + triangle.rest * triangle.rest;
        approx::assert_relative_eq!(total, 2.0 * Loss::None.cost(&misfit), max_relative = 1e-12);
    }
}
