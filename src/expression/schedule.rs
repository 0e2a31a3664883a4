//! Formulas that build on each other as one straight line of steps: what they have in common is computed once, what no variable
//! changes ahead of time, and nothing that no answer needs.

mod graph;

use std::sync::Arc;

use super::program::{Exponent, Function, Line, Op, binary, power, unary};
use super::{Expression, Sheet, interpolation};
use crate::numeric::Real;
use graph::{Graph, Node};

/// Formulas over the same values: constants, quantities of them, variables, quantities of all. Every result is bit for bit that of
/// [`Expression::evaluate`], formula by formula.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Schedule {
    constants: usize,
    variables: usize,
    /// What no variable changes, over the constants as the first of its registers.
    ahead: Vec<Step>,
    /// Registers of those steps that the others need; they come first in the file of registers, the variables behind them.
    kept: Vec<usize>,
    steps: Vec<Step>,
    /// Registers of all together.
    registers: usize,
    /// The register of each answer.
    answers: Vec<usize>,
    /// Registers that steps with more than two operands read.
    operands: Vec<usize>,
    lines: Vec<Line>,
    sheets: Vec<Arc<Sheet>>,
}

/// One step: what it does to registers, and where the result goes. `b` of a step with one operand is that operand; of a step with many,
/// they are `a..b` of the list of operands.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Step {
    what: What,
    to: u16,
    a: u16,
    b: u16,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
enum What {
    /// A number by its bits.
    Number(u64),
    Add,
    Subtract,
    Multiply,
    Divide,
    Negate,
    Power(Exponent),
    One(Function),
    Two(Function),
    /// By index among the lines.
    Line(usize),
    /// By index among the sheets.
    Sheet(usize),
}

impl Schedule {
    /// Of `formulas`, those of the `answers` last: first `fixed` ones, each over `constants` values and the fixed quantities ahead of
    /// it, then, over these and `variables` values, `moving` ones, each also over those ahead of it, and the answers over all.
    pub fn new<'a>(
        (constants, fixed): (usize, &[Expression]),
        (variables, moving): (usize, &[Expression]),
        answers: impl Iterator<Item = &'a Expression>,
    ) -> Self {
        let mut graph = Graph::default();
        let mut values: Vec<usize> = (0..constants).map(|index| graph.node(Node::Constant(index))).collect();
        for formula in fixed {
            let node = graph.formula(formula, &values);
            values.push(node);
        }
        values.extend((0..variables).map(|index| graph.node(Node::Variable(index))));
        for formula in moving {
            let node = graph.formula(formula, &values);
            values.push(node);
        }
        let answers: Vec<usize> = answers.map(|formula| graph.formula(formula, &values)).collect();
        graph.lowered(constants, variables, &answers)
    }

    /// What no variable changes, for these constants.
    pub fn ahead<T: Real>(&self, constants: &[T]) -> Vec<T> {
        let mut file = vec![T::zero(); self.constants + self.ahead.len()];
        file[..self.constants].copy_from_slice(&constants[..self.constants]);
        self.run(&self.ahead, &mut file);
        self.kept.iter().map(|&register| file[register]).collect()
    }

    /// Gives the answers, in their order, to `take`. `ahead` is what [`Self::ahead`] gave, `fill` writes the variables. Nothing is allocated
    /// unless more than 128 values wait at once.
    pub fn evaluate<T: Real>(
        &self,
        ahead: &[T],
        fill: impl FnOnce(&mut [T]),
        take: impl FnOnce(&mut dyn Iterator<Item = T>),
    ) {
        // Clearing many dual numbers would cost more than most laws.
        match self.registers {
            0..=32 => self.evaluate_in(&mut [T::zero(); 32], ahead, fill, take),
            33..=64 => self.evaluate_in(&mut [T::zero(); 64], ahead, fill, take),
            65..=128 => self.evaluate_in(&mut [T::zero(); 128], ahead, fill, take),
            many => self.evaluate_in(&mut vec![T::zero(); many], ahead, fill, take),
        }
    }

    fn evaluate_in<T: Real>(
        &self,
        file: &mut [T],
        ahead: &[T],
        fill: impl FnOnce(&mut [T]),
        take: impl FnOnce(&mut dyn Iterator<Item = T>),
    ) {
        let kept = self.kept.len();
        file[..kept].copy_from_slice(ahead);
        fill(&mut file[kept..kept + self.variables]);
        self.run(&self.steps, file);
        take(&mut self.answers.iter().map(|&register| file[register]));
    }

    fn run<T: Real>(&self, steps: &[Step], file: &mut [T]) {
        for &Step { what, to, a, b } in steps {
            let (to, a, b) = (usize::from(to), usize::from(a), usize::from(b));
            file[to] = match what {
                What::Add => file[a] + file[b],
                What::Subtract => file[a] - file[b],
                What::Multiply => file[a] * file[b],
                What::Divide => file[a] / file[b],
                What::Negate => -file[a],
                What::Two(function) => binary(Op::Call(function), file[a], file[b]),
                What::One(function) => unary(function, file[a]),
                What::Power(exponent) => power(file[a], exponent),
                What::Number(bits) => T::constant(f64::from_bits(bits)),
                What::Line(_) | What::Sheet(_) => self.through_knots(what, &self.operands[a..b], file),
            };
        }
    }

    /// A step whose operands are in these registers.
    fn step(&mut self, what: What, to: usize, mut operands: impl ExactSizeIterator<Item = usize>) -> Step {
        // The limits of formulas keep all of them below a few thousand.
        let short = |number: usize| u16::try_from(number).unwrap_or(u16::MAX);
        let (a, b) = if matches!(what, What::Line(_) | What::Sheet(_)) {
            let first = self.operands.len();
            self.operands.extend(operands);
            (first, self.operands.len())
        } else {
            let a = operands.next().unwrap_or(0);
            (a, operands.next().unwrap_or(a))
        };
        Step { what, to: short(to), a: short(a), b: short(b) }
    }

    /// The value of a line or a sheet.
    #[inline(never)]
    fn through_knots<T: Real>(&self, what: What, operands: &[usize], file: &[T]) -> T {
        let mut arguments = [T::zero(); super::MAX_WAITING];
        for (argument, &register) in arguments.iter_mut().zip(operands) {
            *argument = file[register];
        }
        let arguments = &arguments[..operands.len()];
        match what {
            What::Line(index) => {
                let line = &self.lines[index];
                let interpolate = if line.smooth { interpolation::monotone } else { interpolation::broken };
                interpolate(arguments[0], &line.at, &arguments[1..])
            }
            What::Sheet(index) => self.sheets[index].evaluate(arguments),
            _ => arguments[0],
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::expression::Name;
    use crate::numeric::Dual;
    use crate::units::Dimension;

    /// Two constants, one fixed quantity, two variables, two moving quantities, and answers over all of them.
    struct Formulas {
        fixed: Vec<Expression>,
        moving: Vec<Expression>,
        answers: Vec<Expression>,
    }

    fn formulas() -> Formulas {
        let mut names: Vec<Name> = Vec::new();
        let sheet =
            Arc::new(Sheet::line("s".into(), [Dimension::NONE; 2], vec![-1.0, 0.5, 2.0], vec![1.0, 3.0, 2.0], true));
        let read =
            |text: &str, names: &[Name]| Expression::parse_with(text, names, std::slice::from_ref(&sheet)).unwrap();
        let name = |names: &mut Vec<Name>, name: &str| names.push(Name::new(name, Dimension::NONE));
        ["k", "w"].iter().for_each(|one| name(&mut names, one));
        let fixed = vec![read("k / sqrt(w)", &names)];
        ["f", "x", "y"].iter().for_each(|one| name(&mut names, one));
        let mut moving = Vec::new();
        for (one, text) in [("m", "f * max(x - w, 0) / (1 - w)"), ("n", "m + root(x - y, w)^2")] {
            moving.push(read(text, &names));
            name(&mut names, one);
        }
        let answers = [
            "m * root(x - y, w) + k * (x - y)",
            "n - table(y; 0: k, 1: m, 2: 2 * f) + s(x)",
            "x",
            "f",
            "k^2 + 3",
            "exp(-(x / w)^2) * tanh(y) - abs(n) + step(x - y) * (x - y)^1.5",
            "min(max(x - y, -w / 2), w / 2) + curve(y; 0: 1, 1: k, 2: w)",
        ];
        Formulas { fixed, moving, answers: answers.map(|text| read(text, &names)).to_vec() }
    }

    impl Formulas {
        fn schedule(&self) -> Schedule {
            Schedule::new((2, &self.fixed), (2, &self.moving), self.answers.iter())
        }

        fn one_by_one<T: Real>(&self, constants: &[T], variables: &[T]) -> Vec<T> {
            let mut values = constants.to_vec();
            self.fixed.iter().for_each(|formula| values.push(formula.evaluate(&values)));
            values.extend(variables);
            self.moving.iter().for_each(|formula| values.push(formula.evaluate(&values)));
            self.answers.iter().map(|formula| formula.evaluate(&values)).collect()
        }

        fn scheduled<T: Real>(&self, constants: &[T], variables: &[T]) -> Vec<T> {
            let schedule = self.schedule();
            let mut found = Vec::new();
            let ahead = schedule.ahead(constants);
            schedule.evaluate(&ahead, |file| file.copy_from_slice(variables), |answers| found.extend(answers));
            found
        }
    }

    #[test]
    fn a_schedule_gives_bit_for_bit_what_its_formulas_give() {
        let formulas = formulas();
        for (x, y) in [(0.3, 0.2), (-1.2, 0.7), (2.5, 1.5), (0.0, 0.0), (1e9, -1e-9), (f64::NAN, 1.0)] {
            // What is no number may have either sign.
            let one_nan = |value: f64| if value.is_nan() { f64::NAN } else { value };
            let bits = |values: Vec<f64>| values.into_iter().map(|value| one_nan(value).to_bits()).collect::<Vec<_>>();
            let (constants, variables) = ([1.7, 0.4], [x, y]);
            assert_eq!(
                bits(formulas.scheduled(&constants, &variables)),
                bits(formulas.one_by_one(&constants, &variables)),
                "{x} {y}"
            );
            if x.is_nan() {
                continue;
            }
            let dual = |value: f64, place: usize| Dual::<f64, 4>::variable(value, place);
            let constants = [dual(1.7, 0), dual(0.4, 1)];
            let variables = [dual(x, 2), dual(y, 3)];
            let (own, one) = (formulas.scheduled(&constants, &variables), formulas.one_by_one(&constants, &variables));
            for (own, one) in own.iter().zip(&one) {
                assert_eq!(one_nan(own.re).to_bits(), one_nan(one.re).to_bits(), "{x} {y}");
                // A root of a negative number has no slope either way.
                let alike = |(own, one): (&f64, &f64)| own == one || own.is_nan() && one.is_nan();
                assert!(own.eps.iter().zip(&one.eps).all(alike), "{x} {y}: {own:?} {one:?}");
            }
        }
    }

    #[test]
    fn what_is_common_is_computed_once_and_what_stands_ahead_of_time() {
        let schedule = formulas().schedule();
        let count = |steps: &[Step], what: What| steps.iter().filter(|step| step.what == what).count();
        // `x - y` of four formulas, `x - w`, and the two that take something from an answer.
        assert_eq!(count(&schedule.steps, What::Subtract), 4, "{schedule:?}");
        // `1 - w` and the root of `w` move with nothing.
        assert_eq!(count(&schedule.ahead, What::Subtract), 1);
        assert_eq!(count(&schedule.steps, What::One(Function::Sqrt)), 0);
        assert_eq!(count(&schedule.steps, What::Two(Function::Root)), 1);
    }

    #[test]
    fn what_no_answer_needs_is_left_out() {
        let formulas = formulas();
        let none = Schedule::new((2, &formulas.fixed), (2, &formulas.moving), formulas.answers[2..3].iter());
        assert!(none.steps.is_empty() && none.ahead.is_empty() && none.kept.is_empty(), "{none:?}");
    }
}
