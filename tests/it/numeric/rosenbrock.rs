//! The integrator on problems with known answers. `--nocapture` prints orders and agreeing digits.

use std::ops::ControlFlow;

use borescope::internals::numeric::{
    Dual, IntegrationError, Options, Real, Rosenbrock, Scalar, Step, System, jacobian,
};

/// Number of decimal digits in which `a` agrees with `b`.
fn digits(a: f64, b: f64) -> f64 {
    -((a - b).abs() / b.abs()).max(1e-17).log10()
}

/// An integrator that takes `n` equal steps over a piece of length `length`.
fn equal_steps<const N: usize>(length: f64, n: usize) -> Rosenbrock<N> {
    let h = length / n as f64;
    let mut options = Options::uniform(1e9, 1e9);
    (options.h_initial, options.h_max) = (Some(h), h);
    Rosenbrock::new(options)
}

/// y' = -y + sin t, with or without telling of the dependence on time.
struct Driven {
    tells: bool,
}

impl System<f64, 1> for Driven {
    fn derivative(&mut self, t: f64, y: &[f64; 1], f: &mut [f64; 1]) {
        f[0] = -y[0] + t.sin();
    }
    fn jacobian(&mut self, t: f64, _: &[f64; 1], j: &mut [[f64; 1]; 1], dfdt: &mut [f64; 1]) {
        j[0][0] = -1.0;
        dfdt[0] = if self.tells { t.cos() } else { 0.0 };
    }
}

impl Driven {
    fn exact(t: f64) -> f64 {
        1.5 * (-t).exp() + 0.5 * (t.sin() - t.cos())
    }

    /// Errors at the end, and largest inside the steps, for `n` equal steps over 2 s.
    fn errors(self, n: usize) -> (f64, f64) {
        let mut inside = 0.0_f64;
        let mut system = self;
        let end = equal_steps(2.0, n)
            .integrate(&mut system, 0.0, &[1.0], 2.0, |step| {
                for i in 1..20 {
                    let t = step.t + step.h * f64::from(i) / 20.0;
                    inside = inside.max((step.interpolate_all(t)[0] - Self::exact(t)).abs());
                }
            })
            .expect("integrates");
        ((end[0] - Self::exact(2.0)).abs(), inside)
    }
}

fn order(coarse: f64, fine: f64) -> f64 {
    (coarse / fine).log2()
}

#[test]
fn order_five_with_time_derivative_and_less_without() {
    let mut orders = [0.0; 3];
    for n in [8, 16, 32, 64] {
        let (told, inside) = Driven { tells: true }.errors(n);
        let (told_fine, inside_fine) = Driven { tells: true }.errors(2 * n);
        let (untold, _) = Driven { tells: false }.errors(n);
        let (untold_fine, _) = Driven { tells: false }.errors(2 * n);
        orders = [order(told, told_fine), order(inside, inside_fine), order(untold, untold_fine)];
        println!("{n} steps: error {told:.2e}, orders (end, inside, without df/dt) {orders:.2?}");
    }
    assert!((orders[0] - 5.0).abs() < 0.1, "order {}", orders[0]);
    assert!(orders[1] > 3.9, "dense order {}", orders[1]);
    assert!(orders[2] < 2.5, "without df/dt {}", orders[2]);
}

/// A system from a law written once over any number type; time does not enter.
struct Autonomous<F, G>(F, G);

impl<F, G, const N: usize> System<f64, N> for Autonomous<F, G>
where
    F: Fn([f64; N]) -> [f64; N],
    G: Fn([Dual<f64, N>; N]) -> [Dual<f64, N>; N],
{
    fn derivative(&mut self, _: f64, y: &[f64; N], f: &mut [f64; N]) {
        *f = self.0(*y);
    }
    fn jacobian(&mut self, _: f64, y: &[f64; N], j: &mut [[f64; N]; N], _: &mut [f64; N]) {
        *j = jacobian(y, &self.1).1;
    }
}

fn robertson<T: Real>([a, b, c]: [T; 3]) -> [T; 3] {
    let (slow, fast, back) = (a * 0.04, b * b * 3e7, b * c * 1e4);
    [back - slow, slow - back - fast, fast]
}

fn van_der_pol<T: Real>([y, v]: [T; 2]) -> [T; 2] {
    [v, ((T::one() - y * y) * v - y) * 1e6]
}

#[test]
fn robertson_over_eleven_decades() {
    // Reference: Mazzia and Magherini, Test Set for Initial Value Problem Solvers, problem ROBER, t = 1e11.
    let reference = [0.2083340149701255e-7, 0.8333360770334713e-13, 0.999999979166505];
    for (rtol, least) in [(1e-4, 5.0), (1e-7, 7.4), (1e-10, 10.0)] {
        let mut integrator = Rosenbrock::new(Options::new(rtol, [rtol * 1e-8, rtol * 1e-14, rtol]));
        let mut system = Autonomous(robertson::<f64>, robertson::<Dual<f64, 3>>);
        let y = integrator.integrate(&mut system, 0.0, &[1.0, 0.0, 0.0], 1e11, |_| {}).expect("integrates");
        let agreement: [f64; 3] = std::array::from_fn(|i| digits(y[i], reference[i]));
        println!("Robertson, rtol {rtol:e}: digits {agreement:.1?}, {:?}", integrator.stats());
        assert!(agreement.iter().all(|&d| d > least), "{agreement:?}");
    }
}

#[test]
fn van_der_pol_at_a_million() {
    // Reference: Hairer and Wanner, Solving ODEs II, 2nd ed., IV.10, problem VDPOL with eps = 1e-6 and y(0) = (2, 0).
    let reference = [[-0.186364625480813e1, 0.753543086543546], [0.1706167732170456e1, -0.8928097010248257]];
    for (rtol, least) in [(1e-5, 5.0), (1e-8, 7.5), (1e-10, 9.5)] {
        let mut integrator = Rosenbrock::new(Options::uniform(rtol, rtol));
        let mut system = Autonomous(van_der_pol::<f64>, van_der_pol::<Dual<f64, 2>>);
        let mut y = [2.0, 0.0];
        for (t, truth) in [(0.0, reference[0]), (1.0, reference[1])] {
            y = integrator.integrate(&mut system, t, &y, t + 1.0, |_| {}).expect("integrates");
            let agreement = [digits(y[0], truth[0]), digits(y[1], truth[1])];
            println!("van der Pol, rtol {rtol:e}, t = {}: digits {agreement:.1?}, {:?}", t + 1.0, integrator.stats());
            assert!(agreement.iter().all(|&d| d > least), "{agreement:?}");
        }
    }
}

#[test]
fn lands_exactly_and_keeps_its_step_over_kinks() {
    let mut integrator = Rosenbrock::new(Options::uniform(1e-8, 1e-10));
    let mut system = Driven { tells: true };
    let mut y = [1.0];
    let mut smallest = f64::INFINITY;
    for i in 0..20 {
        let (t0, t1) = (f64::from(i) * 0.1, f64::from(i + 1) * 0.1);
        let mut last = 0.0;
        y = integrator
            .integrate(&mut system, t0, &y, t1, |step: &Step<'_, f64, 1>| {
                last = step.t_end;
                if i > 1 {
                    smallest = smallest.min(step.h);
                }
            })
            .expect("integrates");
        assert_eq!(last, t1);
    }
    assert!((y[0] - Driven::exact(2.0)).abs() < 1e-8);
    assert!(smallest > 0.045, "no slivers: {smallest}");
    let same = integrator.integrate(&mut system, 2.0, &y, 2.0, |_| {}).expect("nothing to do");
    assert_eq!(same, y);
}

#[test]
fn stops_where_the_callback_says() {
    let mut integrator = Rosenbrock::new(Options::uniform(1e-8, 1e-10));
    let arrival = integrator
        .integrate_until(&mut Driven { tells: true }, 0.0, &[1.0], 2.0, |step| {
            if step.t_end < 1.0 { ControlFlow::Continue(()) } else { ControlFlow::Break(1.0) }
        })
        .expect("integrates");
    assert!(arrival.stopped && arrival.t == 1.0);
    assert!((arrival.y[0] - Driven::exact(1.0)).abs() < 1e-7);
}

/// Equations that cannot be continued, one way each.
struct Blows<const CASE: u8>;

impl<const CASE: u8> System<f64, 2> for Blows<CASE> {
    fn derivative(&mut self, _: f64, y: &[f64; 2], f: &mut [f64; 2]) {
        f[0] = 1.0;
        f[1] = match CASE {
            0 => y[1] * y[1],
            1 => (0.5 - y[0]).sqrt(),
            _ => f64::NAN,
        };
    }
    fn jacobian(&mut self, _: f64, y: &[f64; 2], j: &mut [[f64; 2]; 2], _: &mut [f64; 2]) {
        match CASE {
            0 => j[1][1] = 2.0 * y[1],
            1 => j[1][0] = -0.5 / (0.5 - y[0]).sqrt(),
            _ => {}
        }
    }
}

#[test]
fn failures_name_time_and_state() {
    let run = |error: Result<[f64; 2], IntegrationError>| error.expect_err("cannot be integrated");
    let mut integrator = Rosenbrock::new(Options::uniform(1e-6, 1e-8));

    // y' = y^2 from 1 is infinite at t = 1.
    let error = run(integrator.integrate(&mut Blows::<0>, 0.0, &[0.0, 1.0], 2.0, |_| {}));
    println!("{error}");
    assert!(matches!(error, IntegrationError::StepTooSmall { t, worst_state: 1, .. } if (t - 1.0).abs() < 1e-6));

    // Beyond t = 0.5 the derivative is no number: it is approached by halving, then given up.
    integrator.restart();
    let error = run(integrator.integrate(&mut Blows::<1>, 0.0, &[0.0, 0.0], 2.0, |_| {}));
    println!("{error}");
    assert!(matches!(error, IntegrationError::StepTooSmall { t, worst_state: 1, .. } if (t - 0.5).abs() < 1e-6));

    integrator.restart();
    let error = run(integrator.integrate(&mut Blows::<2>, 0.0, &[0.0, 0.0], 2.0, |_| {}));
    assert_eq!(error, IntegrationError::NotFinite { t: 0.0, worst_state: 1 });
    assert_eq!(error.to_string(), "at t = 0 s the derivative of state 1, or its Jacobian row, is not finite");

    let mut integrator = Rosenbrock::new(Options { max_steps: 5, ..Options::uniform(1e-6, 1e-9) });
    let error = run(integrator.integrate(&mut Blows::<0>, 0.0, &[0.0, 1.0], 0.999, |_| {}));
    println!("{error}");
    assert!(matches!(error, IntegrationError::TooManySteps { steps: 5, worst_state: 1, .. }));

    let mut integrator = Rosenbrock::new(Options { max_rejected: 3, ..Options::uniform(1e-6, 1e-9) });
    let error = run(integrator.integrate(&mut Blows::<1>, 0.0, &[0.0, 0.0], 2.0, |_| {}));
    println!("{error}");
    assert!(matches!(error, IntegrationError::TooManyRejected { rejected: 3, worst_state: 1, .. }));

    let error = run(integrator.integrate(&mut Blows::<0>, 1.0, &[0.0, 1.0], 0.0, |_| {}));
    assert_eq!(error, IntegrationError::NoInterval { t0: 1.0, t1: 0.0 });
}

/// y' = -a y + b sin(a t) with the parameters a and b.
struct Parametric<S> {
    a: S,
    b: S,
}

impl<S: Scalar> System<S, 1> for Parametric<S> {
    fn derivative(&mut self, t: f64, y: &[S; 1], f: &mut [S; 1]) {
        f[0] = -self.a * y[0] + self.b * (self.a * t).sin();
    }
    fn jacobian(&mut self, t: f64, _: &[S; 1], j: &mut [[S; 1]; 1], dfdt: &mut [S; 1]) {
        j[0][0] = -self.a;
        dfdt[0] = self.b * self.a * (self.a * t).cos();
    }
}

#[test]
fn sensitivities_of_a_driven_equation_have_a_closed_form() {
    // y = y0 e^(-at) + b/(2a) (sin at - cos at + e^(-at)).
    let exact = |a: Dual<f64, 2>, b: Dual<f64, 2>, t: f64| {
        let decay = (-a * t).exp();
        decay + b / (a * 2.0) * ((a * t).sin() - (a * t).cos() + decay)
    };
    let (a, b) = (Dual::variable(3.0, 0), Dual::variable(0.5, 1));
    let mut integrator = Rosenbrock::new(Options::uniform(1e-9, 1e-11));
    let y = integrator.integrate(&mut Parametric { a, b }, 0.0, &[Dual::one()], 1.5, |_| {}).expect("integrates");
    let truth = exact(a, b, 1.5);
    for p in 0..2 {
        println!("digits {:.1}", digits(y[0].eps[p], truth.eps[p]));
        assert!(digits(y[0].eps[p], truth.eps[p]) > 7.5);
    }
}
