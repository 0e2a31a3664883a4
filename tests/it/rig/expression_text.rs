//! Formulas written back as text read the same, and garbage does no harm.

use crate::support::formula;

use borescope::internals::expression::Expression;
use formula::{AT, NAMES, names, read};

#[test]
fn canonical_form() {
    for (text, canonical) in [
        ("x+(y*z)", "x + y * z"),
        ("(x+y)*z", "(x + y) * z"),
        ("x-(y-z)", "x - (y - z)"),
        ("(x-y)-z", "x - y - z"),
        ("x/(y*z)/z", "x / (y * z) / z"),
        ("-(x^2)", "-x^2"),
        ("(-x)^2", "(-x)^2"),
        ("-(x*y)", "-(x * y)"),
        ("(-x)*y", "-x * y"),
        ("x*(-y)", "x * -y"),
        ("(x^2)^0.50", "(x^2)^0.5"),
        ("x^(2/6)+x^(-2)+x^(5/10)", "x^(1/3) + x^-2 + x^0.5"),
        ("[ 0.30bar ]", "[0.3 bar]"),
        ("[5]+[-5]+[5 %]", "5 + [-5] + [5 %]"),
        ("1000000000+0.00000025", "1e9 + 2.5e-7"),
        ("max( x,-y )", "max(x, -y)"),
        ("table( x;-1:y+1,[2]:(z) )", "table(x; -1: y + 1, 2: z)"),
        ("curve(p_A;[0 bar]:k,[1bar]:2*k)", "curve(p_A; [0 bar]: k, [1 bar]: 2 * k)"),
    ] {
        let expression = read(text);
        assert_eq!(expression.to_string(), canonical, "{text}");
        assert_eq!(read(canonical), expression, "{text}");
    }
    assert_ne!(read("x + y"), read("y + x"));
    assert_ne!(read("[1 bar]"), read("[100000 Pa]"), "the unit that was written belongs to the formula");
}

/// Numbers that look random and are the same in each run.
struct Dice(u64);

impl Dice {
    fn below(&mut self, sides: u64) -> u64 {
        self.0 = self.0.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (self.0 >> 33) % sides
    }

    /// A formula with more brackets than needed, and its value by plain arithmetic.
    fn formula(&mut self, depth: u32) -> (String, f64) {
        let blank = [" ", ""][self.below(2) as usize];
        if depth == 0 || self.below(6) == 0 {
            let i = self.below(3) as usize;
            let number = self.below(4000) as f64 / 8.0;
            return if self.below(2) == 0 { (NAMES[i].0.to_owned(), AT[i]) } else { (format!("{number}"), number) };
        }
        let (a, x) = self.formula(depth - 1);
        let (text, value) = match self.below(10) {
            0 => (format!("-({a})"), -x),
            1 => (format!("({a})^2"), x * x),
            2 => (format!("abs({blank}{a})"), x.abs()),
            3 => (format!("cos({a})"), x.cos()),
            choice => {
                let (b, y) = self.formula(depth - 1);
                match choice {
                    4 => (format!("({a}){blank}+ ({b})"), x + y),
                    5 => (format!("({a}){blank}-({b})"), x - y),
                    6 => (format!("({a})*{blank}({b})"), x * y),
                    7 => (format!("({a}) /{blank}({b})"), x / y),
                    8 => (format!("min({a}{blank},{b})"), x.min(y)),
                    _ => (
                        format!("table({a};{blank}-1:{b}, 1: 2)"),
                        (y * (1.0 - x.clamp(-1.0, 1.0)) + 2.0 * (1.0 + x.clamp(-1.0, 1.0))) / 2.0,
                    ),
                }
            }
        };
        (text, value)
    }
}

#[test]
fn what_is_written_reads_the_same() {
    let mut dice = Dice(1);
    let mut finite = 0;
    for _ in 0..3000 {
        let (text, value) = dice.formula(6);
        let expression = read(&text);
        let got: f64 = expression.evaluate(&AT);
        if value.is_finite() && got.is_finite() {
            finite += 1;
            assert!((got - value).abs() <= 1e-9 * value.abs().max(1.0), "{text}: {got} {value}");
        }
        let canonical = expression.to_string();
        let again = read(&canonical);
        assert_eq!(again, expression, "{text}\n{canonical}");
        assert_eq!(again.to_string(), canonical);
    }
    assert!(finite > 2500, "{finite}");
}

#[test]
fn garbage_is_refused_and_does_no_harm() {
    let mut dice = Dice(7);
    let pieces = [
        "x", "p_A", "k", "(", ")", "[", "]", "bar", "2", "0.5", "1e9", "^", "*", "/", "+", "-", ",", ";", ":", "sqrt(",
        "table(", "curve(", "min(", " ", ".", "ß", "\u{0}", "\n", "e", "[1 mm]",
    ];
    let mut read = 0;
    for _ in 0..20_000 {
        let count = 1 + dice.below(12);
        let text: String = (0..count).map(|_| pieces[dice.below(pieces.len() as u64) as usize]).collect();
        match Expression::parse(&text, &names()) {
            Ok(expression) => {
                read += 1;
                assert_eq!(Expression::parse(&expression.to_string(), &names()).as_ref(), Ok(&expression), "{text:?}");
            }
            Err(error) => {
                assert!(text.is_char_boundary(error.offset), "{text:?}: {}", error.offset);
                assert!(!error.message.is_empty() && !error.help.is_empty(), "{text:?}");
            }
        }
    }
    assert!((500..15_000).contains(&read), "{read}");
}
