//! End cushioning.

use super::{At, Effect, Form, FreeParameter, InitialGuess, Joint};
use crate::numeric::Real;
use crate::physics::card::{Answer, Card, Parameter, Port, Worked};
use crate::physics::component::facts::Symbol;
use crate::physics::fluid::Fluid;
use crate::physics::ports::{Law, PortFlows, PortVariables};

pub const EFFECT: Effect = Effect {
    name: "end-cushioning",
    meaning: CARD.meaning,
    law: CARD.law,
    source: CARD.source,
    validity: CARD.validity,
    empirical: false,
    everywhere: false,
    at: At::Like { symbol: Symbol::Cylinder, named: true },
    form: Form::Shunt { card: &CARD, joints: &[Joint::Body], shared: &[("stroke", "stroke")] },
    parameters: &[
        FreeParameter {
            name: "coefficient",
            neutral: Some(0.0),
            first: InitialGuess::Value(50000.0),
            plausible: (0.0, 1e8),
        },
        FreeParameter { name: "length", neutral: None, first: InitialGuess::Value(20.0), plausible: (1.0, 100.0) },
    ],
};

pub const CARD: Card = Card {
    kind: "end-cushioning",
    meaning: "A cushion that throttles the outflow near both ends and so brakes the piston on its way in.",
    law: "F = -k v |v| d/l on the way into an end, d the depth inside the cushion of length l",
    source: "Merritt (1967), orifice in series with the annulus; force of its pressure drop on the piston",
    validity: "Turbulent, growing straight with the depth; the pressure sensors sit outside the cushion.",
    parameters: &[
        Parameter::required("coefficient", "k", "kg/m", "force per square of the speed at the end").or(0.0),
        Parameter::required("length", "l", "mm", "length of the cushion").positive().or(20.0),
        Parameter::required("stroke", "s", "mm", "way between the end stops").positive().or(100.0),
    ],
    ports: &[Port::mechanical("body", "what is braked")],
    worked: &[Worked {
        text: "100 t/m, half way into a cushion of 20 mm at 0.1 m/s: 500 N",
        parameters: &[("coefficient", 1e5), ("length", 20.0), ("stroke", 170.0)],
        at: &[0.16, 0.1],
        inputs: &[],
        answer: Answer::Through(0),
        expect: -500.0,
    }],
    ..Card::EMPTY
};

#[derive(Debug, Clone, Copy)]
pub struct EndCushioning<T> {
    coefficient: T,
    length: T,
    stroke: T,
}

impl<T: Real> Law<T> for EndCushioning<T> {
    fn new(p: &[T], _fluid: &Fluid<T>) -> Self {
        Self { coefficient: p[0], length: p[1], stroke: p[2] }
    }

    #[inline]
    fn evaluate(&self, seen: &PortVariables<T>, answers: &mut PortFlows<T>) {
        let [x, v, ..] = seen.z;
        let depth = if v.re() > 0.0 { x - self.stroke + self.length } else { self.length - x };
        let share = (depth / self.length).max(T::zero()).min(T::constant(1.0));
        answers.through[0] = -(self.coefficient * share * v * v.abs());
    }
}
