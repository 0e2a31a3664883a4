//! Dry friction that differs between the two directions of motion.

use super::{At, Effect, Form, FreeParameter, InitialGuess, Joint};
use crate::numeric::Real;
use crate::physics::card::{Answer, Card, Parameter, Port, Worked};
use crate::physics::component::{Law, PortFlows, PortVariables, cylinder};
use crate::physics::fluid::Fluid;

pub const EFFECT: Effect = Effect {
    name: "friction-by-direction",
    meaning: CARD.meaning,
    law: CARD.law,
    source: CARD.source,
    validity: CARD.validity,
    empirical: false,
    everywhere: false,
    at: At::Component { kind: cylinder::CARD.kind, named: true },
    form: Form::Shunt { card: &CARD, joints: &[Joint::Port("rod")], shared: &[] },
    parameters: &[
        FreeParameter {
            name: "outwards",
            neutral: Some(0.0),
            first: InitialGuess::Value(100.0),
            plausible: (0.0, 20000.0),
        },
        FreeParameter {
            name: "inwards",
            neutral: Some(0.0),
            first: InitialGuess::Value(100.0),
            plausible: (0.0, 20000.0),
        },
        FreeParameter {
            name: "transition_speed",
            neutral: None,
            first: InitialGuess::Value(0.5),
            plausible: (0.01, 5.0),
        },
    ],
};

pub const CARD: Card = Card {
    kind: "friction-by-direction",
    meaning: "Dry friction that is larger in one direction of motion than in the other.",
    law: "F = -((F_o + F_i)/2 + (F_o - F_i)/2 s) s,  s = v / sqrt(v² + v_t²)",
    source: "Janot, Gautier and Brunot (2019), nonlinear benchmarks: the measured friction of a drive is not symmetric; Coulomb's law",
    validity: "No sticking: below the transition speed it acts like viscous friction and a body at rest creeps.",
    parameters: &[
        Parameter::required("outwards", "F_o", "N", "friction while the position rises").or(0.0),
        Parameter::required("inwards", "F_i", "N", "friction while the position falls").or(0.0),
        Parameter::required("transition_speed", "v_t", "mm/s", "speed at which 71 % of the symmetric part act")
            .positive()
            .or(1.0),
    ],
    ports: &[Port::mechanical("body", "what rubs")],
    worked: &[
        Worked {
            text: "30 N outwards and 10 N inwards push a body that moves inwards at 1 m/s with 10 N",
            parameters: &[("outwards", 30.0), ("inwards", 10.0), ("transition_speed", 1e-3)],
            at: &[0.0, -1.0],
            inputs: &[],
            answer: Answer::Through(0),
            expect: 10.0,
        },
        Worked {
            text: "the same hold back a body that moves outwards at 1 m/s with 30 N",
            parameters: &[("outwards", 30.0), ("inwards", 10.0), ("transition_speed", 1e-3)],
            at: &[0.0, 1.0],
            inputs: &[],
            answer: Answer::Through(0),
            expect: -30.0,
        },
    ],
    ..Card::EMPTY
};

#[derive(Debug, Clone, Copy)]
pub struct FrictionByDirection<T> {
    mean: T,
    half_difference: T,
    transition: T,
}

impl<T: Real> Law<T> for FrictionByDirection<T> {
    fn new(p: &[T], _fluid: &Fluid<T>) -> Self {
        Self { mean: (p[0] + p[1]) * 0.5, half_difference: (p[0] - p[1]) * 0.5, transition: p[2] }
    }

    #[inline]
    fn evaluate(&self, seen: &PortVariables<T>, answers: &mut PortFlows<T>) {
        let v = seen.z[1];
        let direction = v / (v * v + self.transition * self.transition).sqrt();
        answers.through[0] = -((self.mean + self.half_difference * direction) * direction);
    }
}
