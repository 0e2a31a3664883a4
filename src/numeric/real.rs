//! The number type that physical laws are written over.

use std::fmt::Debug;
use std::ops::{Add, AddAssign, Div, DivAssign, Mul, MulAssign, Neg, Sub, SubAssign};

/// A real number, or a real number that carries derivatives ([`Dual`](super::Dual)).
///
/// A law is written once as `fn q<T: Real>(dp: T, d: T) -> T`; with `T = f64` it gives the value, with dual numbers the
/// derivatives as well. The real part of every operation is computed by the same floating-point operations for all number
/// types, so a run with derivatives makes bit for bit the same decisions as one without.
///
/// Constants stand to the right: `x * 2.0`, `x + 1.0`; for `2.0 - x` write `-x + 2.0` or `T::constant(2.0) - x`.
/// Conditions look at [`re`](Real::re): the derivative is that of the branch taken.
///
/// ```
/// use borescope::internals::numeric::{Dual, Real};
///
/// /// Orifice flow, its root smoothed below `d`.
/// fn q<T: Real>(dp: T, d: T) -> T {
///     dp / (dp * dp + d * d).sqrt().sqrt()
/// }
///
/// let slope = q(Dual::<f64, 1>::variable(4.0, 0), Dual::constant(1e-9)).eps[0];
/// assert!((slope - 0.25).abs() < 1e-12);
/// ```
pub trait Real:
    Copy
    + Debug
    + PartialEq
    + Send
    + Sync
    + 'static
    + Neg<Output = Self>
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Add<f64, Output = Self>
    + Sub<f64, Output = Self>
    + Mul<f64, Output = Self>
    + Div<f64, Output = Self>
    + AddAssign
    + SubAssign
    + MulAssign
    + DivAssign
    + MulAssign<f64>
{
    /// The number `value` with all derivatives zero.
    fn constant(value: f64) -> Self;

    /// The real part, all derivatives dropped (of a nested dual number: the innermost value).
    fn re(self) -> f64;

    /// Whether the value and every derivative is finite.
    fn is_finite(self) -> bool;

    /// Whether the value and every derivative is exactly zero.
    fn is_zero(self) -> bool;

    /// Square root. At exactly 0 a direction with zero derivative keeps derivative 0; any other direction gets an
    /// infinite one, as the root has there: smooth the law if that point can be reached.
    fn sqrt(self) -> Self;

    /// Exponential.
    fn exp(self) -> Self;

    /// Natural logarithm. Directions with zero derivative keep it at 0.
    fn ln(self) -> Self;

    /// Integer power by repeated squaring; `x.powi(0)` is 1.
    fn powi(self, exponent: i32) -> Self;

    /// Real power of a number that is not negative. At exactly 0 with an exponent below 1 as for [`sqrt`](Real::sqrt).
    fn powf(self, exponent: f64) -> Self;

    /// Hyperbolic tangent.
    fn tanh(self) -> Self;

    /// Sine; the argument in rad.
    fn sin(self) -> Self;

    /// Cosine; the argument in rad.
    fn cos(self) -> Self;

    /// Zero.
    #[inline]
    fn zero() -> Self {
        Self::constant(0.0)
    }

    /// One.
    #[inline]
    fn one() -> Self {
        Self::constant(1.0)
    }

    /// The square.
    #[inline]
    fn square(self) -> Self {
        self * self
    }

    /// The absolute value; the derivative at 0 is that from the right.
    #[inline]
    fn abs(self) -> Self {
        if self.re() < 0.0 { -self } else { self }
    }

    /// The larger of two, and `self` when the real parts are equal or not comparable (a NaN in `self` survives).
    #[inline]
    fn max(self, other: Self) -> Self {
        if self.re() < other.re() { other } else { self }
    }

    /// The smaller of two, and `self` when the real parts are equal or not comparable (a NaN in `self` survives).
    #[inline]
    fn min(self, other: Self) -> Self {
        if self.re() > other.re() { other } else { self }
    }

    /// The number held within `low..=high`; outside, the derivative is 0, and on the ends it is that from inside.
    #[inline]
    fn clamp(self, low: f64, high: f64) -> Self {
        if self.re() < low {
            Self::constant(low)
        } else if self.re() > high {
            Self::constant(high)
        } else {
            self
        }
    }
}

impl Real for f64 {
    #[inline]
    fn constant(value: f64) -> Self {
        value
    }

    #[inline]
    fn re(self) -> f64 {
        self
    }

    #[inline]
    fn is_finite(self) -> bool {
        f64::is_finite(self)
    }

    #[inline]
    fn is_zero(self) -> bool {
        self == 0.0
    }

    #[inline]
    fn sqrt(self) -> Self {
        f64::sqrt(self)
    }

    #[inline]
    fn exp(self) -> Self {
        f64::exp(self)
    }

    #[inline]
    fn ln(self) -> Self {
        f64::ln(self)
    }

    #[inline]
    fn powi(self, exponent: i32) -> Self {
        // Not `f64::powi`: its rounding may change with what the compiler knows of the exponent.
        let mut square = self;
        let mut power = 1.0;
        let mut rest = exponent.unsigned_abs();
        while rest > 0 {
            if rest & 1 == 1 {
                power *= square;
            }
            square *= square;
            rest >>= 1;
        }
        if exponent < 0 { 1.0 / power } else { power }
    }

    #[inline]
    fn powf(self, exponent: f64) -> Self {
        f64::powf(self, exponent)
    }

    #[inline]
    fn tanh(self) -> Self {
        f64::tanh(self)
    }

    #[inline]
    fn sin(self) -> Self {
        f64::sin(self)
    }

    #[inline]
    fn cos(self) -> Self {
        f64::cos(self)
    }
}
