//! Formulas that cannot be used: each mistake with its place and its remedy, and the limits.

use crate::support::formula;

use borescope::internals::expression::{Expression, FUNCTIONS, MAX_KNOTS, MAX_NESTING, MAX_NODES, Name};
use borescope::internals::units::Dimension;
use formula::{AT, names, near, read, wrong};

/// Formula, offset, message, help.
const WRONG: &[(&str, usize, &str, &str)] = &[
    (
        "p_A - p_T + v",
        10,
        "cannot add velocity (`v`) to pressure (`p_A - p_T`)",
        "both must measure the same; one is in `bar`, the other in `mm/s`",
    ),
    ("p_A - 3", 4, "cannot subtract a pure number (`3`) from pressure (`p_A`)", "give the number a unit: `[3 bar]`"),
    ("1 + v / x", 2, "cannot add velocity (`v / x`) to a pure number (`1`)", "give the number a unit: `[1 mm/s]`"),
    ("exp(p_A)", 4, "`exp` needs a pure number, not pressure (`p_A`)", "divide by a reference, such as `[1 bar]`"),
    (
        "x * tanh( v / 2 )",
        10,
        "`tanh` needs a pure number, not velocity (`v / 2`)",
        "divide by a reference, such as `[1 mm/s]`",
    ),
    (
        "max(p_A, 0)",
        9,
        "`max` cannot compare pressure (`p_A`) with a pure number (`0`)",
        "give the number a unit: `[0 bar]`",
    ),
    (
        "min(p_A, v)",
        9,
        "`min` cannot compare pressure (`p_A`) with velocity (`v`)",
        "both must measure the same; one is in `bar`, the other in `mm/s`",
    ),
    (
        "k * sqrt(p_A) + k * p_A",
        14,
        "cannot add m^2.5.kg^0.5.s-2 (`k * p_A`) to flow (`k * sqrt(p_A)`)",
        "both must measure the same; one is in `L/min`, the other in `m^2.5.kg^0.5.s-2`",
    ),
    (
        "sqrt(sqrt(v))",
        5,
        "the root of m^0.5.s^-0.5 (`sqrt(v)`) has units to powers that are not kept",
        "only whole and half powers up to 100 are kept; divide by a reference before, such as `[1 m^0.5.s^-0.5]`",
    ),
    (
        "v^0.25",
        1,
        "velocity (`v`) to the power 0.25 has units to powers that are not kept",
        "only whole and half powers up to 100 are kept; divide by a reference before, such as `[1 mm/s]`",
    ),
    (
        "v^16 * (v^16 * (v^16 * (v^16 * (v^16 * (v^16 * v^16)))))",
        5,
        "`*` of m16.s-16 (`v^16`) and m96.s-96 (`(v^16 * (v^16 * (v^16 * (v^16 * (v^16 *...`) gives powers of units beyond 100",
        "cancel units earlier, by quotients of like quantities",
    ),
    (
        "table(x; 0: p_A, 1: v)",
        20,
        "this height is velocity (`v`), but the first pressure (`p_A`)",
        "both must measure the same; one is in `bar`, the other in `mm/s`",
    ),
    (
        "curve(p_A; 0: 1, 1: 2)",
        11,
        "the knot is a pure number (`0`), but the argument pressure (`p_A`)",
        "give the number a unit: `[0 bar]`",
    ),
    ("x^y", 2, "an exponent is a constant pure number", EXPONENT),
    ("x^[2 bar]", 2, "an exponent is a constant pure number", EXPONENT),
    ("x^(1 + 1)", 5, "an exponent is a constant pure number", EXPONENT),
    ("x^17", 2, "`17` is no exponent", "exponents reach from -16 to 16, with denominators up to 1000"),
    ("x^(1/0)", 2, "`(1/0)` is no exponent", "exponents reach from -16 to 16, with denominators up to 1000"),
    (
        "x^0.3333",
        2,
        "`0.3333` is no exponent",
        "exponents have at most three decimals and reach from -16 to 16; write thirds as `x^(1/3)`",
    ),
    ("x^2^3", 3, "a power of a power can be read in two ways", "write `(x^2)^3`, or `x^6`"),
    ("", 0, "the formula is empty", "write for example `k * dp`; a constant is one too"),
    ("x + ", 4, "the formula ends where a number, a name or `(` belongs", "the formula is not complete"),
    ("(x + y", 6, "the formula ends where `)` belongs", "every `(` needs its `)`"),
    ("x + y)", 5, "`)` closes nothing", "remove it, or open a bracket with `(` before"),
    ("x ** y", 3, "`*` stands where a number, a name or `(` belongs", "powers are written with `^`: `x^2`"),
    ("x * +y", 4, "`+` stands where a number, a name or `(` belongs", "leave it out: `x`, not `+x`"),
    ("2 x", 2, "an operator is missing before `x`", "products are written with `*`"),
    ("x (y)", 0, "`x` is a quantity, not a function", "products are written with `*`: `x * (...)`"),
    ("p_A - 3.5 bar", 10, "a unit outside of brackets: `bar`", "write `[3.5 bar]`"),
    ("p_A - bar", 6, "unknown name `bar`", "numbers with a unit are written `[1 bar]`"),
    (
        "p_A - [3 baar]",
        8,
        "unknown unit `baar`",
        "did you mean `bar`? Units of pressure: `bar`, `mbar`, `MPa`, `kPa`, `hPa`, `Pa`, `mPa`, `GPa`, `psi`",
    ),
    ("p_A - [3,5 bar]", 8, "`,` within a number", "the decimal mark is a point: `[0.3 bar]`"),
    ("p_A - [bar]", 7, "a number is missing", "digits stand on both sides of a decimal point: `0.5`, `5.0`"),
    ("p_A - [3 bar", 6, "`[` is never closed", "numbers with a unit are written `[0.3 bar]`"),
    ("x * 0,5", 5, "`,` does not belong here", "the decimal mark is a point: `0.5`"),
    ("x * 5.", 4, "`5.` is no number", "digits stand on both sides of a decimal point: `0.5`, `5.0`"),
    ("x * .5", 4, "`.` has no meaning in a formula", "digits stand on both sides of a decimal point: `0.5`"),
    ("1e999", 0, "`1e999` is too large", "numbers go up to 1e308"),
    ("[1e305 bar]", 1, "`1e305 bar` is too large", "numbers go up to 1e308 in SI"),
    ("k * dp", 4, "unknown name `dp`", "known names: `x`, `y`, `z`, `p_A`, `p_T`, `v`, `q`, `k`, `pump.speed`, `T`"),
    (
        "pump.sped",
        0,
        "unknown name `pump.sped`",
        "did you mean `pump.speed`? Known names: `x`, `y`, `z`, `p_A`, `p_T`, `v`, `q`, `k`, `pump.speed`, `T`",
    ),
    (
        "sqr(x)",
        0,
        "unknown function `sqr`",
        "did you mean `sqrt`? Known functions: `sqrt`, `abs`, `exp`, `ln`, `sin`, `cos`, `tanh`, `sign`, `step`, `min`, `max`, `root`, \
         `table`, `curve`",
    ),
    ("sqrt * x", 0, "`sqrt` is a function and needs an argument", "write `sqrt(...)`"),
    ("1 + min(x)", 4, "`min` takes 2 arguments, not 1", "write `min(x, y)`"),
    ("exp(x, y)", 0, "`exp` takes 1 argument, not 2", "write `exp(x)`"),
    (
        "x > y",
        2,
        "`>` has no meaning in a formula",
        "comparisons are written with `step`: `step(x - y)` is 1 where `x` reaches `y`",
    ),
    ("ü*x", 0, "unknown name `ü`", "known names: `x`, `y`, `z`, `p_A`, `p_T`, `v`, `q`, `k`, `pump.speed`, `T`"),
    ("y·x", 1, "`·` has no meaning in a formula", "products are written with `*`"),
    ("table(x; 0: 1)", 0, "a line through a single knot", "write at least two: `table(x; 0: a, 1: b)`"),
    ("table(x; 1: 1, 1: 2)", 15, "the knot `1` does not lie behind the one before", "write the knots in growing order"),
    (
        "table(x; y: 1, 1: 2)",
        9,
        "knots stand at constant places",
        "write a number or a quantity, such as `-0.2` or `[-0.2 bar]`",
    ),
    ("table(x, 0: 1)", 7, "`,` does not belong here", "here belongs `;`"),
];

const EXPONENT: &str = "write `x^2`, `x^-0.5` or `x^(1/3)`; for an exponent that varies `exp(n * ln(x))`";

#[test]
fn mistakes_are_told_with_their_place_and_what_would_be_right() {
    let mut different = Vec::new();
    for &(text, offset, message, help) in WRONG {
        let error = wrong(text);
        assert_eq!(error.to_string(), error.message);
        if (error.offset, error.message.as_str(), error.help.as_str()) != (offset, message, help) {
            different.push(format!("{text}\n  {error:?}"));
        }
    }
    assert!(different.is_empty(), "{}", different.join("\n"));
}

#[test]
fn a_formula_must_give_what_it_is_used_for() {
    let error = Expression::parse_as(" k * p_A", &names(), Dimension::FLOW).unwrap_err();
    assert_eq!(error.message, "the formula gives m^2.5.kg^0.5.s-2, not flow");
    assert_eq!(error.help, "multiply by a quantity in `m^0.5.kg^-0.5.s`");
    assert_eq!(error.offset, 1);
    assert!(Expression::parse_as("k * sqrt(p_A)", &names(), Dimension::FLOW).is_ok());
}

#[test]
fn names_that_no_formula_could_write_are_refused() {
    let number = |name: &str| Name::new(name, Dimension::NONE);
    for (names, message) in [
        (vec![number("")], "`` cannot be named in a formula"),
        (vec![number("2x")], "`2x` cannot be named in a formula"),
        (vec![number("a b")], "`a b` cannot be named in a formula"),
        (vec![number("a.")], "`a.` cannot be named in a formula"),
        (vec![number("a..b")], "`a..b` cannot be named in a formula"),
        (vec![number("min")], "`min` is a function and cannot name a quantity"),
        (vec![number("a"), number("b"), number("a")], "`a` names two quantities"),
    ] {
        assert_eq!(Expression::parse("1", &names).unwrap_err().message, message);
    }
    for name in FUNCTIONS {
        assert!(Expression::parse("1", &[number(name)]).is_err(), "{name}");
    }
    let greek = Expression::parse("ρ_0 + pump.a2", &[number("ρ_0"), number("pump.a2")]).unwrap();
    assert_eq!(greek.evaluate(&[1.0, 2.0]), 3.0);
}

#[test]
fn limits_hold_exactly() {
    let nested = |depth: usize, open: &str| {
        format!("{}x{}", open.repeat(depth), ")".repeat(if open == "-" { 0 } else { depth }))
    };
    for open in ["(", "abs(", "-"] {
        read(&nested(MAX_NESTING, open));
        let error = wrong(&nested(MAX_NESTING + 1, open));
        assert_eq!(error.message, "nested more than 64 deep");
        assert_eq!(error.offset, MAX_NESTING * open.len());
        // Far beyond, where a recursion without limit would end the process.
        assert_eq!(wrong(&nested(800, open)).message, "nested more than 64 deep");
    }

    let long = |terms: usize| vec!["x"; terms].join("+");
    assert_eq!(
        read(&long(MAX_NODES / 2)).evaluate(&AT),
        (0..500).fold(0.0, |sum, i| if i == 0 { 0.3 } else { sum + 0.3 })
    );
    assert_eq!(wrong(&long(MAX_NODES / 2 + 1)).message, "the formula has more than 1000 numbers, names and operators");

    // Blanks do not count.
    read(&format!("{}x{}", " ".repeat(9000), " ".repeat(9000)));
    let digits = |count: usize| format!("1 + 0.{}", "3".repeat(count - 4));
    read(&digits(4096));
    let error = wrong(&digits(4097));
    assert_eq!((error.message.as_str(), error.offset), ("the formula has more than 4096 bytes", 4098));

    // Brackets to the right make every left side wait.
    let waiting = |depth: usize| format!("{}x{}", "x + (".repeat(depth), ")".repeat(depth));
    for depth in 1..=63 {
        near("waiting", read(&waiting(depth)).evaluate(&AT), (depth + 1) as f64 * 0.3);
    }
    assert_eq!(wrong(&waiting(64)).message, "more than 64 values wait for each other here");

    let knots =
        |count: usize| format!("curve(x; {})", (0..count).map(|i| format!("{i}: {i}")).collect::<Vec<_>>().join(", "));
    near("knots", read(&knots(MAX_KNOTS)).evaluate(&AT), 0.3);
    assert_eq!(wrong(&knots(MAX_KNOTS + 1)).message, "more than 32 knots");
}
