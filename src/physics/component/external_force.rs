//! External force on a body, recorded or prescribed.

use super::facts::{Balance, Facts, Residuals, Settles, Symbol};
use super::{PortFlows, Law, PortVariables};
use crate::numeric::Real;
use crate::physics::card::{ANY, Answer, Card, Input, Port, Worked};
use crate::physics::fluid::Fluid;

pub const FACTS: Facts = Facts { symbol: Symbol::Force, residuals: Residuals::None, balance: Balance::Ends, settles: Settles::AtOnce };

pub const CARD: Card = Card {
    kind: "external-force",
    meaning: "Measured force on a body; a positive force pushes against the positive direction of motion.",
    law: "F = -u",
    source: "sign convention of the telescopic rig: positive load pushes against the outstroke",
    validity: "As good as the load cell.",
    ports: &[Port::mechanical("body", "where the force acts")],
    inputs: &[Input { name: "force", unit: "N", meaning: "the force", range: ANY, lag: None }],
    worked: &[Worked {
        text: "a load of 5400 N pushes the body back with 5400 N",
        parameters: &[],
        at: &[0.0, 0.0],
        inputs: &[5400.0],
        answer: Answer::Through(0),
        expect: -5400.0,
    }],
    ..Card::EMPTY
};

/// Has no parameters.
#[derive(Debug, Clone, Copy)]
pub struct ExternalForce<T> {
    nothing: std::marker::PhantomData<T>,
}

impl<T: Real> Law<T> for ExternalForce<T> {
    fn new(_parameters: &[T], _fluid: &Fluid<T>) -> Self {
        Self { nothing: std::marker::PhantomData }
    }

    #[inline]
    fn evaluate(&self, seen: &PortVariables<T>, answers: &mut PortFlows<T>) {
        answers.through[0] = -seen.u[0];
    }
}
