//! A curve without a formula: uniform cubic B-spline, for empirical terms.

use super::{FreeParameter, InitialGuess};
use crate::numeric::Real;
use crate::physics::card::Parameter;

/// Number of heights of a curve; the intervals between them are three fewer.
pub const HEIGHTS: usize = 20;

/// Names of the heights, in their order along the axis.
const NAMES: [&str; HEIGHTS] = [
    "c01", "c02", "c03", "c04", "c05", "c06", "c07", "c08", "c09", "c10", "c11", "c12", "c13", "c14", "c15", "c16",
    "c17", "c18", "c19", "c20",
];

/// The heights as parameters of a card in `unit`, with `more` behind them.
pub const fn card<const N: usize>(unit: &'static str, meaning: &'static str, more: &[Parameter]) -> [Parameter; N] {
    let blank = Parameter::required("", "c", unit, meaning).or(0.0).within(-1e12, 1e12);
    let mut all = [blank; N];
    let mut index = 0;
    while index < N {
        if index < HEIGHTS {
            all[index].name = NAMES[index];
        } else {
            all[index] = more[index - HEIGHTS];
        }
        index += 1;
    }
    all
}

/// The heights as what is estimated of an effect; `first` is a typical size.
pub const fn free(first: f64) -> [FreeParameter; HEIGHTS] {
    let blank =
        FreeParameter { name: "", neutral: Some(0.0), first: InitialGuess::Value(first), plausible: (-1e12, 1e12) };
    let mut all = [blank; HEIGHTS];
    let mut index = 0;
    while index < HEIGHTS {
        all[index].name = NAMES[index];
        index += 1;
    }
    all
}

/// The curve over an axis from 0 to 1; constant beyond its ends.
#[derive(Debug, Clone)]
pub struct Curve<T> {
    heights: Box<[T]>,
}

impl<T: Real> Curve<T> {
    pub fn new(heights: &[T]) -> Self {
        Self { heights: heights.into() }
    }

    /// `sum c_i B(u - i)` with the uniform cubic B-spline (de Boor 1978, chapter X). Heights all equal to `c` give `c`.
    #[inline]
    pub fn at(&self, share: T) -> T {
        let intervals = (HEIGHTS - 3) as f64;
        let u = share.max(T::zero()).min(T::one()) * intervals;
        let first = (u.re().floor() as usize).min(HEIGHTS - 4);
        let t = u - first as f64;
        let rest = T::one() - t;
        let (t2, t3) = (t * t, t * t * t);
        let weights =
            [rest * rest * rest, t3 * 3.0 - t2 * 6.0 + T::constant(4.0), t3 * -3.0 + t2 * 3.0 + t * 3.0 + T::one(), t3];
        let mut sum = T::zero();
        for (height, weight) in self.heights[first..].iter().zip(weights) {
            sum += *height * weight;
        }
        sum * (1.0 / 6.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn equal_heights_give_a_constant_and_straight_ones_a_line() {
        let constant = Curve::new(&[3.0; HEIGHTS]);
        let line = Curve::new(&std::array::from_fn::<f64, HEIGHTS, _>(|i| i as f64 - 1.0));
        for share in [0.0, 0.013, 0.5, 0.77, 1.0] {
            approx::assert_relative_eq!(constant.at(share), 3.0, max_relative = 1e-14);
            approx::assert_relative_eq!(line.at(share), share * 17.0, epsilon = 1e-12);
        }
    }
}
