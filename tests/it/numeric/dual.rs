//! Dual numbers against closed forms and finite differences.

use borescope::internals::numeric::{Dual, Real, jacobian};

/// Every function of the trait in one expression, smooth around x = 0.7, y = 1.3.
fn mixture<T: Real>(x: T, y: T) -> T {
    let a = (x * y + 1.0).sqrt() + (-x).exp() / y - (y + 2.0).ln();
    let b = x.powi(3) - y.powi(-2) + x.powf(1.7) * y.tanh() + (x * 2.0).sin() * y.cos();
    let c = (x - y).abs().max(T::constant(0.1)).min(T::constant(9.0)) + x.clamp(0.0, 1.0);
    let mut d = a * b - c / 3.0;
    d += x;
    d -= y * 0.5;
    d *= y;
    d /= x + 1.0;
    d *= 1.1;
    d - 0.25
}

#[test]
fn gradient_agrees_with_central_differences() {
    let (x, y) = (0.7, 1.3);
    let (value, [gradient]) = jacobian(&[x, y], |[x, y]| [mixture(x, y)]);
    assert_eq!(value, [mixture(x, y)], "the real part rounds as the plain number does");
    let h = 1e-5;
    let dx = (mixture(x + h, y) - mixture(x - h, y)) / (2.0 * h);
    let dy = (mixture(x, y + h) - mixture(x, y - h)) / (2.0 * h);
    for (exact, difference) in gradient.into_iter().zip([dx, dy]) {
        println!("digits {:.1}", -((exact / difference - 1.0).abs().log10()));
        assert!((exact / difference - 1.0).abs() < 1e-8, "{exact} {difference}");
    }
}

#[test]
fn closed_forms() {
    let x = Dual::<f64, 1>::variable(0.3, 0);
    let cases = [
        (x.sqrt(), 0.5 / 0.3_f64.sqrt()),
        (x.exp(), 0.3_f64.exp()),
        (x.ln(), 1.0 / 0.3),
        (x.powi(5), 5.0 * 0.3_f64.powf(4.0)),
        (x.powi(-3), -3.0 * 0.3_f64.powf(-4.0)),
        (x.powi(0), 0.0),
        (x.powf(2.5), 2.5 * 0.3_f64.powf(1.5)),
        (x.tanh(), 1.0 - 0.3_f64.tanh() * 0.3_f64.tanh()),
        (x.sin(), 0.3_f64.cos()),
        (x.cos(), -0.3_f64.sin()),
        (Dual::one() / x, -1.0 / 0.09),
        ((-x).abs(), 1.0),
        (x.square(), 0.6),
    ];
    for (i, (number, slope)) in cases.into_iter().enumerate() {
        assert!((number.eps[0] - slope).abs() < 1e-13 * slope.abs().max(1.0), "case {i}: {number:?} {slope}");
    }
}

#[test]
fn nested_duals_give_second_derivatives() {
    // f = x^3 y^2: fxx = 6 x y^2, fxy = 6 x^2 y, fyy = 2 x^3.
    let f = |x: Dual<Dual<f64, 2>, 2>, y: Dual<Dual<f64, 2>, 2>| x.powi(3) * y * y;
    let (x, y) = (1.5, 0.8);
    let inner = [Dual::variable(x, 0), Dual::variable(y, 1)];
    let [x2, y2] = Dual::variables(&inner);
    let value = f(x2, y2);
    let hessian = [6.0 * x * y * y, 6.0 * x * x * y, 6.0 * x * x * y, 2.0 * x * x * x];
    for (i, expected) in hessian.into_iter().enumerate() {
        let got = value.eps[i / 2].eps[i % 2];
        assert!((got - expected).abs() < 1e-13, "{i}: {got} {expected}");
    }
    let root = Dual::<Dual<f64, 1>, 1>::variable(Dual::variable(4.0, 0), 0).sqrt();
    assert!((root.eps[0].eps[0] + 0.25 * 4.0_f64.powf(-1.5)).abs() < 1e-15);
}

#[test]
fn roots_at_zero_do_not_poison_other_directions() {
    let mut zero = Dual::<f64, 2>::constant(0.0);
    assert_eq!(zero.sqrt(), Dual::constant(0.0));
    assert_eq!(zero.powf(0.5), Dual::constant(0.0));
    zero.eps[1] = 2.0;
    let root = zero.sqrt();
    assert_eq!(root.eps[0], 0.0);
    assert_eq!(root.eps[1], f64::INFINITY);
    assert!(!root.is_finite() && root.re().is_finite());
    assert_eq!(Dual::<Dual<f64, 2>, 1>::constant(0.0).sqrt(), Dual::constant(0.0));
}

#[test]
fn conditions_follow_the_branch_taken() {
    let x = Dual::<f64, 1>::variable(2.0, 0);
    assert_eq!(x.clamp(0.0, 1.0), Dual::constant(1.0));
    assert_eq!(x.clamp(3.0, 4.0), Dual::constant(3.0));
    assert_eq!(x.clamp(0.0, 2.0), x);
    assert_eq!(x.max(Dual::constant(2.0)), x);
    assert_eq!(Dual::<f64, 1>::variable(-2.0, 0).abs().eps, [-1.0]);
    assert!(Real::max(f64::NAN, 1.0).is_nan() && Real::clamp(f64::NAN, 0.0, 1.0).is_nan());
    assert_eq!(Dual::<f64, 1>::variable(1.0, 5), Dual::constant(1.0));
}
