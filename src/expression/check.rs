//! Dimensions: what may meet what.

use super::ExpressionError;
use super::program::{Exponent, Function};
use crate::units::{Dimension, Unit};

/// A part of the formula that has been read.
#[derive(Debug, Clone, Copy)]
pub(super) struct Part {
    pub dimension: Dimension,
    /// Its first byte.
    pub start: usize,
    /// The byte behind its last.
    pub end: usize,
    /// A number without unit, which may lack one.
    pub bare: bool,
}

/// The dimension of `left sign right`; `offset` is that of the sign.
pub(super) fn binary(
    text: &str,
    (sign, offset): (char, usize),
    left: Part,
    right: Part,
) -> Result<Dimension, ExpressionError> {
    let (l, r) = (told(text, left), told(text, right));
    let product = match sign {
        '*' => left.dimension.times(right.dimension),
        '/' => left.dimension.per(right.dimension),
        _ if left.dimension == right.dimension => return Ok(left.dimension),
        _ => {
            let what =
                if sign == '-' { format!("cannot subtract {r} from {l}") } else { format!("cannot add {r} to {l}") };
            return Err(ExpressionError::new(offset, what, unlike(text, left, right)));
        }
    };
    product.rational_power(1, 1).ok_or_else(|| {
        let what = format!("`{sign}` of {l} and {r} gives powers of units beyond 100");
        ExpressionError::new(offset, what, "cancel units earlier, by quotients of like quantities")
    })
}

/// The dimension of `base^exponent`; `offset` is that of the `^`.
pub(super) fn power(text: &str, offset: usize, base: Part, exponent: Exponent) -> Result<Dimension, ExpressionError> {
    let Exponent { numerator, denominator } = exponent;
    base.dimension.rational_power(numerator, denominator).ok_or_else(|| {
        let what = format!("{} to the power {exponent} has units to powers that are not kept", told(text, base));
        ExpressionError::new(offset, what, powers_kept(base.dimension))
    })
}

/// The dimension of a function of one or two arguments.
pub(super) fn call(
    text: &str,
    function: Function,
    first: Part,
    second: Option<Part>,
) -> Result<Dimension, ExpressionError> {
    let name = function.name();
    match function {
        Function::Abs => Ok(first.dimension),
        Function::Sign | Function::Step => Ok(Dimension::NONE),
        Function::Sqrt => root(text, first),
        Function::Exp | Function::Ln | Function::Sin | Function::Cos | Function::Tanh => {
            if first.dimension == Dimension::NONE {
                return Ok(Dimension::NONE);
            }
            let what = format!("`{name}` needs a pure number, not {}", told(text, first));
            let help = format!("divide by a reference, such as `[1 {}]`", unit_of(first.dimension));
            Err(ExpressionError::new(first.start, what, help))
        }
        Function::Min | Function::Max | Function::Root => match second {
            Some(second) if second.dimension != first.dimension => {
                let what = format!("`{name}` cannot compare {} with {}", told(text, first), told(text, second));
                Err(ExpressionError::new(second.start, what, unlike(text, first, second)))
            }
            _ if function == Function::Root => root(text, first),
            _ => Ok(first.dimension),
        },
    }
}

/// The dimension of a square root.
fn root(text: &str, of: Part) -> Result<Dimension, ExpressionError> {
    of.dimension.rational_power(1, 2).ok_or_else(|| {
        let what = format!("the root of {} has units to powers that are not kept", told(text, of));
        ExpressionError::new(of.start, what, powers_kept(of.dimension))
    })
}

/// That an argument of a table is what the table is over.
pub(super) fn argument(text: &str, name: &str, wanted: Dimension, argument: Part) -> Result<(), ExpressionError> {
    if argument.dimension == wanted {
        return Ok(());
    }
    let what = format!("the table `{name}` is over {}, not {}", named(wanted), told(text, argument));
    let help = format!("multiply by a quantity in `{}`", unit_of(wanted.per(argument.dimension)));
    Err(ExpressionError::new(argument.start, what, help))
}

/// That a knot lies along the argument.
pub(super) fn knot(text: &str, argument: Part, knot: Part) -> Result<(), ExpressionError> {
    if knot.dimension == argument.dimension {
        return Ok(());
    }
    let what = format!("the knot is {}, but the argument {}", told(text, knot), told(text, argument));
    Err(ExpressionError::new(knot.start, what, unlike(text, argument, knot)))
}

/// That all heights measure the same.
pub(super) fn height(text: &str, first: Part, height: Part) -> Result<(), ExpressionError> {
    if height.dimension == first.dimension {
        return Ok(());
    }
    let what = format!("this height is {}, but the first {}", told(text, height), told(text, first));
    Err(ExpressionError::new(height.start, what, unlike(text, first, height)))
}

/// That the whole formula measures `wanted`.
pub(super) fn whole(text: &str, found: Dimension, wanted: Dimension) -> Result<(), ExpressionError> {
    if found == wanted {
        return Ok(());
    }
    let what = format!("the formula gives {}, not {}", named(found), named(wanted));
    let help = format!("multiply by a quantity in `{}`", unit_of(wanted.per(found)));
    Err(ExpressionError::new(text.len() - text.trim_start().len(), what, help))
}

/// ``pressure (`p_A - p_T`)``.
fn told(text: &str, part: Part) -> String {
    const SHOWN: usize = 40;
    let written = text[part.start..part.end].split_whitespace().collect::<Vec<_>>().join(" ");
    let written = match written.char_indices().nth(SHOWN) {
        Some((cut, _)) => format!("{}...", written[..cut].trim_end()),
        None => written,
    };
    format!("{} (`{written}`)", named(part.dimension))
}

fn named(dimension: Dimension) -> String {
    if dimension == Dimension::NONE { "a pure number".to_owned() } else { dimension.to_string() }
}

fn unlike(text: &str, a: Part, b: Part) -> String {
    for (bare, other) in [(b, a), (a, b)] {
        if bare.bare {
            return format!("give the number a unit: `[{} {}]`", &text[bare.start..bare.end], unit_of(other.dimension));
        }
    }
    let (first, second) = (unit_of(a.dimension), unit_of(b.dimension));
    format!("both must measure the same; one is in `{first}`, the other in `{second}`")
}

fn powers_kept(dimension: Dimension) -> String {
    let unit = unit_of(dimension);
    format!("only whole and half powers up to 100 are kept; divide by a reference before, such as `[1 {unit}]`")
}

/// The unit that people would write.
fn unit_of(dimension: Dimension) -> String {
    Unit::known_for(dimension).first().map_or_else(|| dimension.base_units(), |unit| (*unit).to_owned())
}
