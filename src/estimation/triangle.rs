//! The triangle that a long Jacobian is reduced to.

use nalgebra::{DMatrix, DVector};

use super::loss::Loss;
use crate::numeric::{sum_of_products, wide};

/// Rows that are taken in at a time: a block of this size with some ten columns stays in the first-level cache.
const BLOCK: usize = 128;

/// `[R z; 0 t]`, the upper triangle of the QR factorisation of `[J r]`.
///
/// It says all about the linear model that least squares asks: `|J d + r|^2 = |R d + z|^2 + t^2`. Unlike `J^T J` it does
/// not square the condition number, and unlike a QR of the whole it needs no copy of `J`.
/// Source: Golub and Van Loan, *Matrix Computations* (4th ed.), sections 5.2 and 6.5 (updating by rows).
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Triangle {
    /// `p` by `p`, upper triangular; diagonal of any sign.
    pub r: DMatrix<f64>,
    /// `p`.
    pub z: DVector<f64>,
    /// What no parameter can explain, `t`.
    pub rest: f64,
}

impl Triangle {
    /// Reduces `[J r]`, each row times the root of its weight in the loss, block by block: `2 m (p+1)^2` operations.
    pub fn reduce(jacobian: &DMatrix<f64>, misfit: &[f64], loss: Loss) -> Self {
        let (m, p) = jacobian.shape();
        let width = p + 1;
        let mut work = DMatrix::zeros(width + BLOCK, width);
        let mut from = 0;
        while from < m {
            let rows = BLOCK.min(m - from);
            let roots: Vec<f64> = misfit[from..from + rows].iter().map(|&r| loss.weight(r).sqrt()).collect();
            let columns = jacobian.as_slice().chunks_exact(m).map(|column| &column[from..from + rows]);
            for (j, source) in columns.chain([&misfit[from..from + rows]]).enumerate() {
                let target = &mut work.as_mut_slice()[j * (width + BLOCK) + width..][..rows];
                for ((t, s), root) in target.iter_mut().zip(source).zip(&roots) {
                    *t = s * root;
                }
            }
            triangularise(&mut work, width, rows);
            from += rows;
        }
        Self::split(&work, p)
    }

    /// Of a small matrix `[A b]`.
    pub fn of(rows: DMatrix<f64>) -> Self {
        let p = rows.ncols() - 1;
        let missing = (p + 1).saturating_sub(rows.nrows());
        let below = rows.nrows();
        let square = rows.insert_rows(below, missing, 0.0).qr().r();
        Self::split(&square, p)
    }

    fn split(square: &DMatrix<f64>, p: usize) -> Self {
        let r = square.view((0, 0), (p, p)).upper_triangle();
        Self { r, z: square.view((0, p), (p, 1)).column(0).into_owned(), rest: square[(p, p)].abs() }
    }

    /// `|J_j|`, the length of each column: how much all misfits together move per unit of a parameter.
    pub fn column_norms(&self) -> Vec<f64> {
        self.r.column_iter().map(|c| c.norm()).collect()
    }

    /// `J^T r`, half the gradient of the sum of squares.
    pub fn gradient(&self) -> DVector<f64> {
        self.r.tr_mul(&self.z)
    }

    /// The same triangle for other misfits, of which half the gradient is known: `R^T z = gradient`.
    pub fn with_gradient(&self, gradient: &DVector<f64>) -> Self {
        let p = gradient.len();
        let mut z = DVector::zeros(p);
        for j in 0..p {
            let column = self.r.column(j);
            let known: f64 = (0..j).map(|k| column[k] * z[k]).sum();
            // A direction without influence has no gradient either.
            z[j] = if column[j].abs() > 1e-12 * column.norm() { (gradient[j] - known) / column[j] } else { 0.0 };
        }
        Self { r: self.r.clone(), z, rest: self.rest }
    }

    /// Fall of the sum of squares over a step in the linear model, free of the cancellation of subtracting two costs.
    pub fn predicted_decrease(&self, step: &[f64]) -> f64 {
        let moved = &self.r * DVector::from_column_slice(step);
        -(2.0 * self.z.dot(&moved) + moved.norm_squared())
    }
}

wide! {
    /// Householder triangularisation, in place, of a matrix whose first `top` rows are an upper triangle already and whose
    /// `below` rows after those are full. Leaves the rows below untidy: they are overwritten by the next block.
    pub(super) fn triangularise(a: &mut DMatrix<f64>, top: usize, below: usize) {
        let (rows, columns) = a.shape();
        let data = a.as_mut_slice();
        for j in 0..columns.min(top) {
            let (head, tail) = data.split_at_mut((j + 1) * rows);
            let column = &mut head[j * rows..];
            let norm_below = sum_of_products(&column[top..top + below], &column[top..top + below]);
            // What is smaller squares to nothing, and a reflection along it to no number: a saturated law has derivatives such as 1e-154.
            if norm_below < f64::MIN_POSITIVE {
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
                let factor = beta * (lead * upper[j] + sum_of_products(vector, lower));
                upper[j] -= factor * lead;
                for (o, v) in lower.iter_mut().zip(vector) {
                    *o -= factor * v;
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn reduces_to_the_same_normal_equations() {
        let m = 1000;
        let jacobian = DMatrix::from_fn(m, 4, |i, j| ((i * (j + 2)) as f64 * 0.37).sin() * 10f64.powi(j as i32));
        let misfit: Vec<f64> = (0..m).map(|i| (i as f64 * 0.11).cos() + 0.5).collect();
        let triangle = Triangle::reduce(&jacobian, &misfit, Loss::None);
        let (squared, expected) = (triangle.r.tr_mul(&triangle.r), jacobian.tr_mul(&jacobian));
        approx::assert_relative_eq!(squared, expected, max_relative = 1e-12, epsilon = 1e-8);
        let gradient = jacobian.tr_mul(&DVector::from_vec(misfit.clone()));
        approx::assert_relative_eq!(triangle.gradient(), gradient, max_relative = 1e-12, epsilon = 1e-9);
        let total = triangle.z.norm_squared() + triangle.rest * triangle.rest;
        approx::assert_relative_eq!(total, 2.0 * Loss::None.cost(&misfit), max_relative = 1e-12);
        let again = triangle.with_gradient(&gradient);
        approx::assert_relative_eq!(again.z, triangle.z, max_relative = 1e-9, epsilon = 1e-9);
    }

    #[test]
    fn derivatives_whose_squares_vanish_leave_numbers() {
        for size in [1e-148, 1e-154, 1e-158, 1e-162] {
            let jacobian = DMatrix::from_fn(300, 3, |i, j| if j == 0 { 1.0 } else { size * (i as f64).powi(j as i32) });
            let triangle = Triangle::reduce(&jacobian, &[1.0; 300], Loss::None);
            assert!(triangle.r.iter().chain(triangle.z.iter()).all(|value| value.is_finite()), "{size}");
            approx::assert_relative_eq!(triangle.r[(0, 0)].abs(), 300f64.sqrt(), max_relative = 1e-12);
        }
    }

    #[test]
    fn a_matrix_with_fewer_rows_than_columns_has_a_triangle_too() {
        let triangle = Triangle::of(DMatrix::from_row_slice(1, 3, &[3.0, 4.0, 5.0]));
        approx::assert_relative_eq!(triangle.r[(0, 0)].abs(), 3.0);
        assert_eq!((triangle.r[(1, 1)], triangle.rest), (0.0, 0.0));
    }
}
