//! Formulas as values that need each other, and how these become steps.

use std::collections::HashMap;
use std::sync::Arc;

use super::{Schedule, What};
use crate::expression::program::{Line, Op};
use crate::expression::{Expression, Sheet};

/// A value in the making: where it comes from, and which others it needs.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub(super) enum Node {
    Constant(usize),
    Variable(usize),
    Step(What, Vec<usize>),
}

/// All values that formulas ask for, each once.
#[derive(Default)]
pub(super) struct Graph {
    nodes: Vec<Node>,
    known: HashMap<Node, usize>,
    lines: Vec<Line>,
    sheets: Vec<Arc<Sheet>>,
}

impl Graph {
    pub fn node(&mut self, node: Node) -> usize {
        if let Some(&known) = self.known.get(&node) {
            return known;
        }
        self.nodes.push(node.clone());
        self.known.insert(node, self.nodes.len() - 1);
        self.nodes.len() - 1
    }

    /// The value of a formula over values that are known.
    pub fn formula(&mut self, formula: &Expression, values: &[usize]) -> usize {
        let program = &formula.program;
        let mut waiting: Vec<usize> = Vec::new();
        for op in program.ops() {
            let (what, operands) = match *op {
                Op::Value(index) => {
                    waiting.push(values[index]);
                    continue;
                }
                Op::Constant(number) => (What::Number(number.to_bits()), 0),
                Op::Negate => (What::Negate, 1),
                Op::Add => (What::Add, 2),
                Op::Subtract => (What::Subtract, 2),
                Op::Multiply => (What::Multiply, 2),
                Op::Divide => (What::Divide, 2),
                Op::Power(exponent) => (What::Power(exponent), 1),
                Op::Call(function) if function.arguments() == 1 => (What::One(function), 1),
                Op::Call(function) => (What::Two(function), 2),
                Op::Line(index) => {
                    let line = &program.lines[index];
                    (What::Line(place(&mut self.lines, line)), 1 + line.at.len())
                }
                Op::Sheet(index) => {
                    let sheet = &program.sheets[index];
                    (What::Sheet(place(&mut self.sheets, sheet)), sheet.arguments.len())
                }
            };
            let operands = waiting.split_off(waiting.len() - operands);
            let node = self.node(Node::Step(what, operands));
            waiting.push(node);
        }
        waiting[0]
    }

    /// The values that a value needs; they always come ahead of it.
    fn needs(&self, node: usize) -> &[usize] {
        match &self.nodes[node] {
            Node::Step(_, operands) => operands,
            _ => &[],
        }
    }

    /// What of each value matters to the answers.
    fn uses(&self, answers: &[usize]) -> Uses {
        let count = self.nodes.len();
        let mut uses = Uses {
            needed: vec![false; count],
            moves: vec![false; count],
            kept: vec![false; count],
            last: vec![0; count],
        };
        answers.iter().for_each(|&answer| uses.needed[answer] = true);
        for node in (0..count).rev() {
            if uses.needed[node] {
                self.needs(node).iter().for_each(|&operand| uses.needed[operand] = true);
            }
        }
        for node in 0..count {
            let moved = self.needs(node).iter().any(|&operand| uses.moves[operand]);
            uses.moves[node] = moved || matches!(self.nodes[node], Node::Variable(_));
            if uses.needed[node] && moved {
                for &operand in self.needs(node) {
                    (uses.last[operand], uses.kept[operand]) = (node, !uses.moves[operand]);
                }
            }
        }
        for &answer in answers {
            (uses.last[answer], uses.kept[answer]) = (count, !uses.moves[answer]);
        }
        uses
    }

    /// As steps over registers.
    pub fn lowered(self, constants: usize, variables: usize, answers: &[usize]) -> Schedule {
        let uses = self.uses(answers);
        let mut schedule = Schedule { constants, variables, ..Schedule::default() };
        let mut register = vec![0; self.nodes.len()];
        let mut next = constants;
        for node in (0..self.nodes.len()).filter(|&node| uses.needed[node] && !uses.moves[node]) {
            match &self.nodes[node] {
                Node::Constant(index) | Node::Variable(index) => register[node] = *index,
                Node::Step(what, operands) => {
                    let step = schedule.step(*what, next, operands.iter().map(|&operand| register[operand]));
                    schedule.ahead.push(step);
                    register[node] = next;
                    next += 1;
                }
            }
        }
        for node in (0..self.nodes.len()).filter(|&node| uses.kept[node]) {
            schedule.kept.push(register[node]);
            register[node] = schedule.kept.len() - 1;
        }
        let first = schedule.kept.len();
        schedule.registers = first + variables;
        let mut free = Vec::new();
        for node in (0..self.nodes.len()).filter(|&node| uses.needed[node] && uses.moves[node]) {
            match &self.nodes[node] {
                Node::Constant(index) | Node::Variable(index) => register[node] = first + index,
                Node::Step(what, operands) => {
                    let to = free.pop().unwrap_or(schedule.registers);
                    schedule.registers = schedule.registers.max(to + 1);
                    let step = schedule.step(*what, to, operands.iter().map(|&operand| register[operand]));
                    schedule.steps.push(step);
                    register[node] = to;
                    let mut over: Vec<usize> =
                        operands.iter().copied().filter(|&operand| uses.last[operand] == node).collect();
                    over.sort_unstable();
                    over.dedup();
                    let in_between =
                        |operand: &usize| uses.moves[*operand] && matches!(self.nodes[*operand], Node::Step(..));
                    free.extend(over.into_iter().filter(in_between).map(|operand| register[operand]));
                }
            }
        }
        schedule.answers = answers.iter().map(|&answer| register[answer]).collect();
        (schedule.lines, schedule.sheets) = (self.lines, self.sheets);
        schedule
    }
}

/// Of each value in the making.
struct Uses {
    /// Whether an answer needs it.
    needed: Vec<bool>,
    /// Whether a variable changes it.
    moves: Vec<bool>,
    /// Whether it does not move, and what moves needs it.
    kept: Vec<bool>,
    /// The last value that moves and needs it.
    last: Vec<usize>,
}

/// Where `one` stands in the list, which gets it if it has none like it.
fn place<T: PartialEq + Clone>(list: &mut Vec<T>, one: &T) -> usize {
    list.iter().position(|known| known == one).unwrap_or_else(|| {
        list.push(one.clone());
        list.len() - 1
    })
}
