//! Friction that grows with the pressure on the seals.

use super::{At, Effect, Form, FreeParameter, InitialGuess, Joint};
use crate::numeric::Real;
use crate::physics::card::{Answer, Card, Parameter, Port, Worked};
use crate::physics::component::facts::Symbol;
use crate::physics::fluid::Fluid;
use crate::physics::ports::{Law, PortFlows, PortVariables};

use crate::physics::ATMOSPHERE;

pub const EFFECT: Effect = Effect {
    name: "pressure-friction",
    meaning: CARD.meaning,
    law: CARD.law,
    source: CARD.source,
    validity: CARD.validity,
    empirical: false,
    everywhere: false,
    at: At::Like { symbol: Symbol::Cylinder, named: true },
    form: Form::Shunt { card: &CARD, joints: &[Joint::Hydraulic(0), Joint::Hydraulic(1), Joint::Body], shared: &[] },
    parameters: &[FreeParameter {
        name: "coefficient",
        neutral: Some(0.0),
        first: InitialGuess::Value(3.0),
        plausible: (0.0, 200.0),
    }],
};

pub const CARD: Card = Card {
    kind: "pressure-friction",
    meaning: "Friction of lip seals, which the pressure presses onto the wall.",
    law: "F = -c (p_A + p_B) v / sqrt(v^2 + v_t^2)",
    source: "ISO 5597 lip seals; friction proportional to the sealed pressure",
    validity: "Gauge pressures of both chambers with one coefficient; no Stribeck branch.",
    parameters: &[
        Parameter::required("coefficient", "c", "N/bar", "friction per pressure").or(0.0),
        Parameter::required("transition_speed", "v_t", "mm/s", "speed at which 71 % of the friction act")
            .positive()
            .or(1.0),
    ],
    ports: &[Port::hydraulic("A", "cap side"), Port::hydraulic("B", "rod side"), Port::mechanical("body", "what rubs")],
    worked: &[Worked {
        text: "1 N/bar under 6 and 4 bar gauge at 0.75 of a transition of 1 mm/s: 6 N",
        parameters: &[("coefficient", 1.0), ("transition_speed", 1.0)],
        at: &[ATMOSPHERE + 6e5, ATMOSPHERE + 4e5, 0.0, 0.75e-3],
        inputs: &[],
        answer: Answer::Through(2),
        expect: -6.0,
    }],
    ..Card::EMPTY
};

#[derive(Debug, Clone, Copy)]
pub struct PressureFriction<T> {
    coefficient: T,
    transition: T,
}

impl<T: Real> Law<T> for PressureFriction<T> {
    fn new(p: &[T], _fluid: &Fluid<T>) -> Self {
        Self { coefficient: p[0], transition: p[1] }
    }

    #[inline]
    fn evaluate(&self, seen: &PortVariables<T>, answers: &mut PortFlows<T>) {
        let [p_a, p_b, _, v, ..] = seen.z;
        let size = self.coefficient * (p_a + p_b - 2.0 * ATMOSPHERE);
        answers.through[2] = -(size * v) / (v * v + self.transition * self.transition).sqrt();
    }
}
