//! The formula in postfix order, and how it runs.

use super::{Literal, MAX_WAITING, Sheet, interpolation};
use crate::numeric::Real;
use std::fmt;
use std::sync::Arc;

/// Below this argument (SI) a root has the slope that it has here. Small enough for squares of leakage flows (1e-18 m6/s2);
/// large enough that the slope, 5e11, still leaves digits beside it in a Jacobian.
const STEEPEST: f64 = 1e-24;

#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Op {
    /// In SI; how it is written stands in the list of literals.
    Constant(f64),
    /// By index among the names.
    Value(usize),
    Negate,
    Add,
    Subtract,
    Multiply,
    Divide,
    Power(Exponent),
    Call(Function),
    /// By index among the lines.
    Line(usize),
    /// By index among the sheets.
    Sheet(usize),
}

/// A fraction in lowest terms, denominator positive.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(super) struct Exponent {
    pub numerator: i32,
    pub denominator: i32,
}

/// Writes it as it may follow a `^`.
impl fmt::Display for Exponent {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { numerator, denominator } = *self;
        // Decimals of at most three digits are read as the fraction they are.
        if 1000 % denominator == 0 {
            write!(f, "{}", f64::from(numerator) / f64::from(denominator))
        } else {
            write!(f, "({numerator}/{denominator})")
        }
    }
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(super) enum Function {
    Sqrt,
    Abs,
    Exp,
    Ln,
    Sin,
    Cos,
    Tanh,
    Sign,
    Step,
    Min,
    Max,
    Root,
}

impl Function {
    const ALL: [(&'static str, Self); 12] = [
        ("sqrt", Self::Sqrt),
        ("abs", Self::Abs),
        ("exp", Self::Exp),
        ("ln", Self::Ln),
        ("sin", Self::Sin),
        ("cos", Self::Cos),
        ("tanh", Self::Tanh),
        ("sign", Self::Sign),
        ("step", Self::Step),
        ("min", Self::Min),
        ("max", Self::Max),
        ("root", Self::Root),
    ];

    pub(super) fn find(name: &str) -> Option<Self> {
        Self::ALL.iter().find(|(known, _)| *known == name).map(|(_, function)| *function)
    }

    pub(super) fn name(self) -> &'static str {
        Self::ALL.iter().find(|(_, function)| *function == self).map_or("", |(name, _)| *name)
    }

    pub(super) fn arguments(self) -> usize {
        if matches!(self, Self::Min | Self::Max | Self::Root) { 2 } else { 1 }
    }
}

/// The fixed part of a `table` or `curve`.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Line {
    /// `curve` rather than `table`.
    pub smooth: bool,
    pub knots: Vec<Literal>,
    /// The knots in SI.
    pub at: Vec<f64>,
}

/// `waiting` is the largest number of values that wait at once, at most [`MAX_WAITING`].
#[derive(Debug, Clone, PartialEq, Default)]
pub(super) struct Program {
    ops: Vec<Op>,
    /// One for each [`Op::Constant`], in order.
    pub literals: Vec<Literal>,
    pub lines: Vec<Line>,
    pub sheets: Vec<Arc<Sheet>>,
    pub waiting: usize,
}

impl Program {
    pub(super) fn uses(&self, index: usize) -> bool {
        self.ops.contains(&Op::Value(index))
    }

    /// In postfix order.
    pub(super) fn ops(&self) -> &[Op] {
        &self.ops
    }

    pub(super) fn push(&mut self, op: Op) {
        self.ops.push(op);
    }

    /// `values` covers every [`Op::Value`].
    pub(super) fn evaluate<T: Real>(&self, values: &[T]) -> T {
        // Most formulas are shallow, and clearing 64 dual numbers would cost more than the formula.
        match self.waiting {
            0..=6 => self.run::<T, 6>(values),
            7..=16 => self.run::<T, 16>(values),
            _ => self.run::<T, MAX_WAITING>(values),
        }
    }

    fn run<T: Real, const N: usize>(&self, values: &[T]) -> T {
        let mut stack = [T::zero(); N];
        let mut count = 0;
        for &op in &self.ops {
            match op {
                Op::Constant(value) => {
                    stack[count] = T::constant(value);
                    count += 1;
                }
                Op::Value(index) => {
                    stack[count] = values[index];
                    count += 1;
                }
                Op::Negate => stack[count - 1] = -stack[count - 1],
                Op::Power(exponent) => stack[count - 1] = power(stack[count - 1], exponent),
                Op::Line(index) => {
                    let line = &self.lines[index];
                    let argument = count - 1 - line.at.len();
                    let (x, heights) = (stack[argument], &stack[argument + 1..count]);
                    let interpolate = if line.smooth { interpolation::monotone } else { interpolation::broken };
                    stack[argument] = interpolate(x, &line.at, heights);
                    count = argument + 1;
                }
                Op::Sheet(index) => {
                    let sheet = &self.sheets[index];
                    let first = count - sheet.arguments.len();
                    stack[first] = sheet.evaluate(&stack[first..count]);
                    count = first + 1;
                }
                Op::Call(function) if function.arguments() == 1 => {
                    stack[count - 1] = unary(function, stack[count - 1]);
                }
                Op::Add | Op::Subtract | Op::Multiply | Op::Divide | Op::Call(_) => {
                    count -= 1;
                    stack[count - 1] = binary(op, stack[count - 1], stack[count]);
                }
            }
        }
        stack[0]
    }
}

pub(super) fn binary<T: Real>(op: Op, a: T, b: T) -> T {
    match op {
        Op::Add => a + b,
        Op::Subtract => a - b,
        Op::Multiply => a * b,
        Op::Divide => a / b,
        // A NaN must not vanish because the other one is smaller.
        _ if b.re().is_nan() => b,
        Op::Call(Function::Root) => root(a, b),
        // Between two slopes the mean: a dead zone of no width, `max(x - 0, 0) + min(x + 0, 0)`, has the slope of `x` at 0 too.
        _ if a.re() == b.re() => (a + b) * 0.5,
        Op::Call(Function::Min) => a.min(b),
        _ => a.max(b),
    }
}

pub(super) fn unary<T: Real>(function: Function, x: T) -> T {
    match function {
        Function::Sqrt if x.re() >= STEEPEST => x.sqrt(),
        Function::Sqrt => near_zero(x, x.re().sqrt(), 0.5),
        Function::Exp => x.exp(),
        Function::Ln => x.ln(),
        Function::Sin => x.sin(),
        Function::Cos => x.cos(),
        Function::Tanh => x.tanh(),
        Function::Sign | Function::Step if x.re().is_nan() => x,
        Function::Sign if x.re() == 0.0 => T::zero(),
        Function::Sign => T::constant(x.re().signum()),
        Function::Step => T::constant(if x.re() < 0.0 { 0.0 } else { 1.0 }),
        Function::Abs | Function::Min | Function::Max | Function::Root => x.abs(),
    }
}

/// Square root with the sign of `x`, straight where `x` is small against `width`.
fn root<T: Real>(x: T, width: T) -> T {
    let squares = x * x + width * width;
    // Without a width there is nothing that the slope at 0 could be.
    if squares.re() == 0.0 { T::zero() } else { x / squares.sqrt().sqrt() }
}

pub(super) fn power<T: Real>(x: T, exponent: Exponent) -> T {
    let Exponent { numerator, denominator } = exponent;
    if denominator == 1 {
        return x.powi(numerator);
    }
    let exponent = f64::from(numerator) / f64::from(denominator);
    if x.re() >= STEEPEST { x.powf(exponent) } else { near_zero(x, x.re().powf(exponent), exponent) }
}

/// A power where its derivatives may not be finite: the exact value, the slope of the power or the steepest that is allowed.
fn near_zero<T: Real>(x: T, value: f64, exponent: f64) -> T {
    let at = if exponent < 1.0 { STEEPEST } else { x.re().max(0.0) };
    T::constant(value) + (x - x.re()) * (exponent * at.powf(exponent - 1.0))
}
