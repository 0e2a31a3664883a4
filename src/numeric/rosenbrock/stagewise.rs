//! Numbers of the equations of all stages, as elimination along the pattern takes them: a small matrix for each place, and a row of
//! parameters for each stage.

use super::sparse::Element;

/// Stages.
pub(super) const STAGES: usize = 3;
/// Parameters that are carried side by side.
pub(super) const WIDTH: usize = 8;
/// Derivatives of one state by as many parameters.
pub(super) type Row = [f64; WIDTH];

#[inline(always)]
pub(super) fn axpy(sum: &mut Row, factor: f64, row: &Row) {
    for (sum, value) in sum.iter_mut().zip(row) {
        *sum += factor * value;
    }
}

/// The entries of one place of the Jacobian in the equations of all stages.
pub(super) type Stagewise = [[f64; STAGES]; STAGES];

impl Element for Stagewise {
    const ZERO: Self = [[0.0; STAGES]; STAGES];
    /// One row of each stage.
    type Right = [Row; STAGES];

    fn inverse(&self) -> Option<Self> {
        let m = nalgebra::Matrix3::from_fn(|row, column| self[row][column]).try_inverse()?;
        m.iter()
            .all(|value| value.is_finite())
            .then(|| std::array::from_fn(|row| std::array::from_fn(|column| m[(row, column)])))
    }

    #[inline(always)]
    fn times(&self, other: &Self) -> Self {
        let mut result = Self::ZERO;
        for (result, row) in result.iter_mut().zip(self) {
            for (factor, other) in row.iter().zip(other) {
                result.iter_mut().zip(other).for_each(|(sum, value)| *sum += factor * value);
            }
        }
        result
    }

    #[inline(always)]
    fn minus(&mut self, a: &Self, b: &Self) {
        for (own, row) in self.iter_mut().zip(a) {
            for (factor, b) in row.iter().zip(b) {
                own.iter_mut().zip(b).for_each(|(sum, value)| *sum -= factor * value);
            }
        }
    }

    fn largest(&self) -> f64 {
        self.iter().flatten().fold(0.0, |most, value| if value.abs() <= most { most } else { value.abs() })
    }

    #[inline(always)]
    fn applied_to(&self, right: &[Row; STAGES]) -> [Row; STAGES] {
        let mut result = [[0.0; WIDTH]; STAGES];
        for (result, row) in result.iter_mut().zip(self) {
            row.iter().zip(right).for_each(|(factor, right)| axpy(result, *factor, right));
        }
        result
    }

    #[inline(always)]
    fn taken_from(&self, right: &mut [Row; STAGES], x: &[Row; STAGES]) {
        for (right, row) in right.iter_mut().zip(self) {
            row.iter().zip(x).for_each(|(factor, x)| axpy(right, -factor, x));
        }
    }
}
