//! Formulas of the user: values, exact derivatives, and where they have none.

use crate::support::formula;

use borescope::internals::expression::Expression;
use borescope::internals::numeric::{Dual, Real};
use formula::{AT, NAMES, names, near, read};

/// The value and its derivatives by every name.
fn gradient(expression: &Expression, at: [f64; 10]) -> Dual<f64, 10> {
    expression.evaluate(&Dual::variables(&at))
}

#[test]
fn values_worked_by_hand() {
    for (text, value, dimension) in [
        ("1 + 2 * 3", 7.0, "pure numbers"),
        ("(1 + 2) * 3", 9.0, "pure numbers"),
        ("2 - 3 - 4", -5.0, "pure numbers"),
        ("2 - (3 - 4)", 3.0, "pure numbers"),
        ("24 / 4 / 2", 3.0, "pure numbers"),
        ("24 / (4 / 2)", 12.0, "pure numbers"),
        ("-3^2", -9.0, "pure numbers"),
        ("(-3)^2", 9.0, "pure numbers"),
        ("2 * -3", -6.0, "pure numbers"),
        ("2 - -3", 5.0, "pure numbers"),
        ("--4", 4.0, "pure numbers"),
        ("2^-2", 0.25, "pure numbers"),
        ("4^1.5", 8.0, "pure numbers"),
        ("27^(1/3)", 3.0, "pure numbers"),
        ("16^(-3/4)", 0.125, "pure numbers"),
        ("y^0", 1.0, "pure numbers"),
        ("1.5e2 + 2E-1", 150.2, "pure numbers"),
        ("[5 %]", 0.05, "pure numbers"),
        ("[0.3 bar]", 3e4, "pressure"),
        ("[ -2bar ]", -2e5, "pressure"),
        ("p_A - p_T", 4e5, "pressure"),
        ("(p_A - p_T) / [1 bar]", 4.0, "pure numbers"),
        ("pump.speed * [10 cm3/rev]", 2.5e-4, "flow"),
        ("T - [20 degC]", 20.0, "temperature"),
        // 3e-7 * sqrt(9e4)
        ("k * sqrt(p_A - p_T - [3.1 bar])", 9e-5, "flow"),
        // 2e-4 / (1 + 0.4^2 / 0.2^2)
        ("q / (1 + v^2 / [0.2 m/s]^2)", 4e-5, "flow"),
        ("sqrt([16 mm4])", 4e-6, "area"),
        ("[4 m2]^(3/2)", 8.0, "volume"),
        ("[8 m3]^(1/3)", 2.0, "length"),
        ("abs(z)", 1.5, "pure numbers"),
        ("exp(ln(y))", 2.0, "pure numbers"),
        ("sin(0) + cos(0)", 1.0, "pure numbers"),
        ("tanh(100)", 1.0, "pure numbers"),
        ("sign(p_T - p_A)", -1.0, "pure numbers"),
        ("sign(x - x)", 0.0, "pure numbers"),
        ("sign(v)", 1.0, "pure numbers"),
        ("step(z) + step(x - x) + step(v)", 2.0, "pure numbers"),
        ("min(p_A, p_T)", 1e5, "pressure"),
        ("max(x, min(y, z))", 0.3, "pure numbers"),
        ("table(x; 0: 1, 0.5: 2, 1: 7)", 1.6, "pure numbers"),
        ("table(p_T; [0 bar]: [0 mm], [4 bar]: [8 mm])", 2e-3, "length"),
        ("table(z; -1: 4, 1: 5)", 4.0, "pure numbers"),
        ("table(y; -1: 4, 1: q/[1 m3/s])", 2e-4, "pure numbers"),
    ] {
        let expression = read(text);
        near(text, expression.evaluate(&AT), value);
        assert_eq!(expression.dimension().to_string(), dimension, "{text}");
        assert!(Expression::parse_as(text, &names(), expression.dimension()).is_ok(), "{text}");
    }
}

#[test]
fn derivatives_in_closed_form() {
    let [x, y, z, p_a, p_t, v, q, k, _, _] = AT;
    let dp = p_a - p_t;
    for (text, name, slope) in [
        ("k * sqrt(abs(p_T - p_A)) * sign(p_T - p_A)", "p_A", -0.5 * k / dp.sqrt()),
        ("k * sqrt(abs(p_T - p_A)) * sign(p_T - p_A)", "p_T", 0.5 * k / dp.sqrt()),
        ("k * sqrt(abs(p_T - p_A)) * sign(p_T - p_A)", "k", -dp.sqrt()),
        ("q / (1 + v^2 / [0.2 m/s]^2)", "v", -q * 2.0 * v / 0.04 / 25.0),
        ("x^3 / y", "x", 3.0 * x * x / y),
        ("x^3 / y", "y", -x.powf(3.0) / (y * y)),
        ("x^-2", "x", -2.0 * x.powf(-3.0)),
        ("x^1.5 + x^(1/3)", "x", 1.5 * x.sqrt() + x.powf(-2.0 / 3.0) / 3.0),
        ("exp(-x * y)", "x", -y * (-x * y).exp()),
        ("ln(1 + x)", "x", 1.0 / (1.0 + x)),
        ("sin(x) * cos(y)", "x", x.cos() * y.cos()),
        ("sin(x) * cos(y)", "y", -x.sin() * y.sin()),
        ("tanh(x / y)", "x", (1.0 - (x / y).tanh().powi(2)) / y),
        ("abs(z)", "z", -1.0),
        ("sign(z) + step(z)", "z", 0.0),
        ("min(x, y * z)", "x", 0.0),
        ("min(x, y * z)", "y", z),
        ("max(x, y * z)", "x", 1.0),
        // Where both are equal, between their slopes; a dead zone of no width is none.
        ("max(y, 2)", "y", 0.5),
        ("max(y - 2, 0) + min(y - 2, 0)", "y", 1.0),
        ("table(x; 0: y, 0.5: z, 1: 7)", "x", (z - y) / 0.5),
        ("table(x; 0: y, 0.5: z, 1: 7)", "y", 0.4),
        ("table(x; 0: y, 0.5: z, 1: 7)", "z", 0.6),
        ("table(y; 0: y, 0.5: z, 1: z)", "z", 1.0),
        ("curve(y; 0: y, 0.5: z, 1: z)", "y", 0.0),
        ("-(x - y)", "y", 1.0),
        ("3 / 4 - x", "x", -1.0),
    ] {
        let expression = read(text);
        let index = NAMES.iter().position(|(known, _)| *known == name).unwrap();
        let number = gradient(&expression, AT);
        near(&format!("d/d{name} of {text}"), number.eps[index], slope);
        assert_eq!(number.re, expression.evaluate(&AT), "{text}: a value that depends on the number type");
    }
}

#[test]
fn second_derivatives_by_nested_numbers() {
    // d2/dx dy of exp(x y) = (1 + x y) exp(x y)
    let (x, y) = (AT[0], AT[1]);
    let inner = AT.map(Dual::<f64, 1>::constant);
    let mut outer = inner.map(Dual::<Dual<f64, 1>, 1>::lift);
    outer[0] = Dual::variable(Dual::constant(x), 0);
    outer[1] = Dual::lift(Dual::variable(y, 0));
    let mixed = read("exp(x * y)").evaluate(&outer).eps[0].eps[0];
    near("exp(x * y)", mixed, (1.0 + x * y) * (x * y).exp());
}

/// Knots 0, 1, 3, 4 with heights 0, 1, 2, 5 have the secants 1, 1/2 and 3. Slopes at the knots after Fritsch and Butland:
/// 9 / (5/1 + 4/(1/2)) = 9/13, 9 / (4/(1/2) + 5/3) = 27/29; at the start by three points (4 * 1 - 1 * 1/2) / 3 = 7/6.
#[test]
fn the_curve_is_the_monotone_cubic() {
    let curve = read("curve(y; 0: 0, 1: 1, 3: 2, 4: 5)");
    let at = |place: f64| {
        let mut values = AT;
        values[1] = place;
        let number = gradient(&curve, values);
        (number.re, number.eps[1])
    };
    near("first half way", at(0.5).0, 0.5 + (7.0 / 6.0 - 9.0 / 13.0) / 8.0);
    near("second half way", at(2.0).0, 1.5 + 2.0 * (9.0 / 13.0 - 27.0 / 29.0) / 8.0);
    near("slope half way", at(2.0).1, 1.5 * 0.5 - (9.0 / 13.0 + 27.0 / 29.0) / 4.0);
    for (place, height, slope) in [(0.0, 0.0, 7.0 / 6.0), (1.0, 1.0, 9.0 / 13.0), (3.0, 2.0, 27.0 / 29.0)] {
        assert_eq!(at(place).0, height);
        near("slope at a knot", at(place).1, slope);
    }
    assert_eq!([at(-1.0), at(4.0), at(9.0)], [(0.0, 0.0), (5.0, 0.0), (5.0, 0.0)]);

    // Towards a peak the three points would have 6.5; the start stays within three times its secant.
    let peak = read("curve(y; 0: 0, 1: 1, 2: -9)");
    let mut values = AT;
    values[1] = 0.5;
    near("before a peak", peak.evaluate(&values), 0.5 + 3.0 / 8.0);

    // A step that other cubics overshoot, and two knots that make a straight line.
    let shape = read("curve(y; 0: 0, 1: 0, 2: 1, 3: 1)");
    let straight = read("curve(y; 0: 1, 4: 3)");
    let mut before = 0.0;
    for i in 0..=300 {
        let mut values = AT;
        values[1] = f64::from(i) / 100.0;
        let height = shape.evaluate(&values);
        assert!((before..=1.0).contains(&height), "{height} at {}", values[1]);
        before = height;
        near("straight", straight.evaluate(&values), 1.0 + values[1] / 2.0);
    }
}

#[test]
fn the_curve_is_smooth_in_its_argument_and_its_heights() {
    let curve = read("curve(y; 0: x, 1: x * z, 3: z, 4: 5, 6: z^2)");
    for place in [0.2, 0.9, 1.7, 3.5, 5.2] {
        let mut at = AT;
        at[1] = place;
        let exact = gradient(&curve, at);
        for name in [0, 1, 2] {
            let h = 1e-6;
            let (mut up, mut down) = (at, at);
            up[name] += h;
            down[name] -= h;
            let difference = (curve.evaluate(&up) - curve.evaluate(&down)) / (2.0 * h);
            assert!((exact.eps[name] - difference).abs() < 1e-7, "{place} {name}: {exact:?} {difference}");
        }
        assert!(exact.eps[0].abs() + exact.eps[2].abs() > 1e-3, "nothing depends on the heights at {place}");
    }
}

#[test]
fn no_derivative_is_lost_where_the_value_is_finite() {
    type Nested = Dual<Dual<f64, 10>, 10>;
    let inner = |at: &[f64; 10]| Dual::<f64, 10>::variables(at);
    let mut at = AT;
    at[0] = 0.0;
    at[4] = at[3];
    for text in [
        "sqrt(x)",
        "sqrt(abs(x))",
        "x^0.5",
        "x^(1/3)",
        "x^1.5",
        "x^2.5",
        "x^1",
        "x^2",
        "abs(x)",
        "sign(x) * sqrt(abs(x))",
        "k * sqrt(abs(p_A - p_T)) * sign(p_A - p_T)",
        "x * ln(x + 1)",
        "min(x, x) + max(x, 0)",
        "sqrt(sqrt(x^4))",
        "table(x; 0: y, 1: y)",
        "curve(x; -1: y, 0: y, 1: y)",
        "curve(x; 0: x, 1: x)",
        "tanh(1000 + x)",
    ] {
        let expression = read(text);
        let value: f64 = expression.evaluate(&at);
        assert!(value.is_finite(), "{text}: {value}");
        let number: Nested = expression.evaluate(&Dual::variables(&inner(&at)));
        assert!(number.is_finite(), "{text}: {number:?}");
        assert_eq!(number.re(), value, "{text}");
    }
    // The slope is the one at 1e-24, from both sides of that place.
    assert_eq!(gradient(&read("sqrt(x)"), at).eps[0], 0.5 / 1e-24_f64.sqrt());
    for tiny in [0.999e-24, 1.001e-24] {
        at[0] = tiny;
        let root = gradient(&read("sqrt(x)"), at);
        assert_eq!(root.re, tiny.sqrt());
        assert!((root.eps[0] * 2e-12 - 1.0).abs() < 1e-3, "{tiny}: {}", root.eps[0]);
        let cube = gradient(&read("x^1.5"), at);
        near("x^1.5", cube.eps[0], 1.5 * tiny.sqrt());
    }
}

#[test]
fn what_has_no_value_is_not_hidden() {
    for text in [
        "sqrt(z)",
        "z^0.5",
        "ln(z)",
        "0 / (x - x)",
        "min(x, ln(z))",
        "min(ln(z), x)",
        "max(x, ln(z))",
        "sign(ln(z))",
        "step(ln(z))",
        "table(ln(z); 0: 1, 1: 2)",
        "curve(ln(z); 0: 1, 1: 2)",
    ] {
        let value: f64 = read(text).evaluate(&AT);
        assert!(value.is_nan(), "{text}: {value}");
    }
}

#[test]
fn a_formula_knows_which_names_it_uses() {
    let expression = read("k * sqrt(abs(p_A))");
    let used: Vec<&str> = expression
        .names()
        .iter()
        .enumerate()
        .filter(|(i, _)| expression.uses(*i))
        .map(|(_, n)| n.name.as_str())
        .collect();
    assert_eq!(used, ["p_A", "k"]);
}

#[test]
#[should_panic(expected = "2 values for 10 names")]
fn too_few_values_are_a_mistake_of_the_program() {
    read("x").evaluate(&[1.0, 2.0]);
}
