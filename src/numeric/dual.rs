//! Forward-mode derivatives: numbers that carry their partial derivatives along.

#[cfg(feature = "internals")]
use std::array::from_fn;
use std::ops::{Add, AddAssign, Div, DivAssign, Mul, MulAssign, Neg, Sub, SubAssign};

use super::Real;

/// A value and its derivatives in `K` directions: `re + sum eps[i] e_i`, with `e_i e_j = 0`.
///
/// Everything lives in fixed-size arrays, because dual numbers of run-time length cost tens of times more. The inner type is
/// any [`Real`], so duals nest: `Dual<Dual<f64, P>, K>` gives mixed second derivatives, or the Jacobian of a circuit
/// together with its sensitivity to `P` parameters.
///
/// Derivatives are exact up to rounding. Source: G. F. Corliss et al. / A. Griewank and A. Walther, "Evaluating
/// Derivatives", 2nd ed., SIAM 2008, chapter 3.1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Dual<T, const K: usize> {
    /// The value.
    pub re: T,
    /// The derivative in each direction, in the unit of the value per unit of that direction's variable.
    pub eps: [T; K],
}

impl<T: Real, const K: usize> Dual<T, K> {
    /// A number without derivatives.
    #[inline]
    pub fn lift(re: T) -> Self {
        Self { re, eps: [T::zero(); K] }
    }

    /// The variable of direction `direction`: derivative 1 there, 0 elsewhere. A `direction` of `K` or more has no place
    /// to go and gives a number without derivatives.
    #[inline]
    pub fn variable(re: T, direction: usize) -> Self {
        let mut eps = [T::zero(); K];
        if let Some(e) = eps.get_mut(direction) {
            *e = T::one();
        }
        Self { re, eps }
    }

    /// All `K` variables at once, variable `i` in direction `i`.
    #[inline]
    #[cfg(feature = "internals")]
    pub fn variables(values: &[T; K]) -> [Self; K] {
        from_fn(|i| Self::variable(values[i], i))
    }

    /// A function of this number from its value and slope at `re`.
    #[inline]
    fn chain(mut self, value: T, slope: T) -> Self {
        self.re = value;
        self.eps.iter_mut().for_each(|e| *e *= slope);
        self
    }

    /// As [`chain`](Self::chain), where the slope may be infinite: 0 times infinity is 0 here, because a number that does
    /// not depend on a variable has no derivative in it whatever the function does.
    #[inline]
    fn chain_guarded(self, value: T, slope: T) -> Self {
        if slope.is_finite() {
            self.chain(value, slope)
        } else {
            let mut guarded = self;
            guarded.re = value;
            guarded.eps.iter_mut().filter(|e| !e.is_zero()).for_each(|e| *e *= slope);
            guarded
        }
    }
}

/// Value and partial derivatives of a vector function: returns `(f, j)` with `j[row][column] = df[row]/dx[column]`.
///
/// ```
/// use borescope::internals::numeric::{jacobian, Real};
/// let (f, j) = jacobian(&[2.0, 3.0], |[x, y]| [x * y, x.square()]);
/// assert_eq!((f, j), ([6.0, 4.0], [[3.0, 2.0], [4.0, 0.0]]));
/// ```
#[inline]
#[cfg(feature = "internals")]
pub fn jacobian<T: Real, const K: usize, const M: usize>(
    x: &[T; K],
    f: impl FnOnce([Dual<T, K>; K]) -> [Dual<T, K>; M],
) -> ([T; M], [[T; K]; M]) {
    let y = f(Dual::variables(x));
    (from_fn(|i| y[i].re), from_fn(|i| y[i].eps))
}

impl<T: Real, const K: usize> Neg for Dual<T, K> {
    type Output = Self;
    #[inline]
    fn neg(mut self) -> Self {
        self.re = -self.re;
        self.eps.iter_mut().for_each(|e| *e = -*e);
        self
    }
}

impl<T: Real, const K: usize> Add for Dual<T, K> {
    type Output = Self;
    #[inline]
    fn add(mut self, other: Self) -> Self {
        self.re += other.re;
        self.eps.iter_mut().zip(&other.eps).for_each(|(e, other)| *e += *other);
        self
    }
}

impl<T: Real, const K: usize> Sub for Dual<T, K> {
    type Output = Self;
    #[inline]
    fn sub(mut self, other: Self) -> Self {
        self.re -= other.re;
        self.eps.iter_mut().zip(&other.eps).for_each(|(e, other)| *e -= *other);
        self
    }
}

impl<T: Real, const K: usize> Mul for Dual<T, K> {
    type Output = Self;
    #[inline]
    fn mul(mut self, other: Self) -> Self {
        for (e, other_e) in self.eps.iter_mut().zip(&other.eps) {
            *e = *e * other.re + *other_e * self.re;
        }
        self.re *= other.re;
        self
    }
}

impl<T: Real, const K: usize> Div for Dual<T, K> {
    type Output = Self;
    #[inline]
    fn div(mut self, other: Self) -> Self {
        // The value is divided, not multiplied by the reciprocal, so that it rounds as it does without derivatives.
        self.re /= other.re;
        let reciprocal = T::one() / other.re;
        for (e, other) in self.eps.iter_mut().zip(&other.eps) {
            *e = (*e - self.re * *other) * reciprocal;
        }
        self
    }
}

impl<T: Real, const K: usize> Add<f64> for Dual<T, K> {
    type Output = Self;
    #[inline]
    fn add(self, other: f64) -> Self {
        Self { re: self.re + other, eps: self.eps }
    }
}

impl<T: Real, const K: usize> Sub<f64> for Dual<T, K> {
    type Output = Self;
    #[inline]
    fn sub(self, other: f64) -> Self {
        Self { re: self.re - other, eps: self.eps }
    }
}

impl<T: Real, const K: usize> Mul<f64> for Dual<T, K> {
    type Output = Self;
    #[inline]
    fn mul(mut self, other: f64) -> Self {
        self *= other;
        self
    }
}

impl<T: Real, const K: usize> Div<f64> for Dual<T, K> {
    type Output = Self;
    #[inline]
    fn div(mut self, other: f64) -> Self {
        self.re = self.re / other;
        self.eps.iter_mut().for_each(|e| *e = *e / other);
        self
    }
}

impl<T: Real, const K: usize> AddAssign for Dual<T, K> {
    #[inline]
    fn add_assign(&mut self, other: Self) {
        self.re += other.re;
        self.eps.iter_mut().zip(&other.eps).for_each(|(e, other)| *e += *other);
    }
}

impl<T: Real, const K: usize> SubAssign for Dual<T, K> {
    #[inline]
    fn sub_assign(&mut self, other: Self) {
        self.re -= other.re;
        self.eps.iter_mut().zip(&other.eps).for_each(|(e, other)| *e -= *other);
    }
}

impl<T: Real, const K: usize> MulAssign for Dual<T, K> {
    #[inline]
    fn mul_assign(&mut self, other: Self) {
        *self = *self * other;
    }
}

impl<T: Real, const K: usize> DivAssign for Dual<T, K> {
    #[inline]
    fn div_assign(&mut self, other: Self) {
        *self = *self / other;
    }
}

impl<T: Real, const K: usize> MulAssign<f64> for Dual<T, K> {
    #[inline]
    fn mul_assign(&mut self, other: f64) {
        self.re *= other;
        self.eps.iter_mut().for_each(|e| *e *= other);
    }
}

impl<T: Real, const K: usize> Real for Dual<T, K> {
    #[inline]
    fn constant(value: f64) -> Self {
        Self::lift(T::constant(value))
    }

    #[inline]
    fn re(self) -> f64 {
        self.re.re()
    }

    #[inline]
    fn is_finite(self) -> bool {
        self.re.is_finite() && self.eps.iter().all(|e| e.is_finite())
    }

    #[inline]
    fn is_zero(self) -> bool {
        self.re.is_zero() && self.eps.iter().all(|e| e.is_zero())
    }

    #[inline]
    fn sqrt(self) -> Self {
        let root = self.re.sqrt();
        self.chain_guarded(root, T::constant(0.5) / root)
    }

    #[inline]
    fn exp(self) -> Self {
        let value = self.re.exp();
        self.chain(value, value)
    }

    #[inline]
    fn ln(self) -> Self {
        self.chain_guarded(self.re.ln(), T::one() / self.re)
    }

    #[inline]
    fn powi(self, exponent: i32) -> Self {
        if exponent == 0 {
            return Self::one();
        }
        self.chain_guarded(self.re.powi(exponent), self.re.powi(exponent - 1) * f64::from(exponent))
    }

    #[inline]
    fn powf(self, exponent: f64) -> Self {
        if exponent == 0.0 {
            return Self::one();
        }
        self.chain_guarded(self.re.powf(exponent), self.re.powf(exponent - 1.0) * exponent)
    }

    #[inline]
    fn tanh(self) -> Self {
        let value = self.re.tanh();
        self.chain(value, -(value * value) + 1.0)
    }

    #[inline]
    fn sin(self) -> Self {
        self.chain(self.re.sin(), self.re.cos())
    }

    #[inline]
    fn cos(self) -> Self {
        self.chain(self.re.cos(), -self.re.sin())
    }
}
