//! External force on a body, recorded or prescribed.

use super::facts::{Balance, Facts, Residuals, Settles, Symbol};
use crate::numeric::Real;
use crate::physics::card::{ANY, Answer, Card, Input, Parameter, Port, Role, Worked};
use crate::physics::fluid::Fluid;
use crate::physics::ports::{Law, PortFlows, PortVariables};

pub const FACTS: Facts =
    Facts { symbol: Symbol::Force, residuals: Residuals::None, balance: Balance::Ends, settles: Settles::AtOnce };

/// What calibration starts from for the gain: class 0.3 of industrial load cells.
const SPREAD: f64 = 0.003;

pub const CARD: Card = Card {
    kind: "external-force",
    meaning: "Measured force on a body; a positive force pushes against the positive direction of motion.",
    law: "F = -u/g",
    source: "sign convention of the telescopic rig: positive load pushes against the outstroke",
    validity: "As good as the load cell, whose gain a calibration estimates where the input has `noise`.",
    parameters: &[Parameter::required("gain", "g", "-", "what the load cell shows per true force")
        .is(Role::Instrument)
        .positive()
        .or(1.0)
        .calibrated(SPREAD)],
    ports: &[Port::mechanical("body", "where the force acts")],
    inputs: &[Input { name: "force", unit: "N", meaning: "the force", range: ANY, lag: None }],
    worked: &[Worked {
        text: "where a load cell with a gain of 1.01 shows 5454 N, 5400 N push the body back",
        parameters: &[("gain", 1.01)],
        at: &[0.0, 0.0],
        inputs: &[5454.0],
        answer: Answer::Through(0),
        expect: -5400.0,
    }],
    ..Card::EMPTY
};

#[derive(Debug, Clone, Copy)]
pub struct ExternalForce<T> {
    gain: T,
}

impl<T: Real> Law<T> for ExternalForce<T> {
    fn new(parameters: &[T], _fluid: &Fluid<T>) -> Self {
        Self { gain: parameters[0] }
    }

    #[inline]
    fn evaluate(&self, seen: &PortVariables<T>, answers: &mut PortFlows<T>) {
        answers.through[0] = -seen.u[0] / self.gain;
    }
}
