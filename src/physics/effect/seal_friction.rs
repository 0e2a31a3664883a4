//! Dry friction of seals.

use super::{At, Effect, Form, FreeParameter, InitialGuess, Joint};
use crate::numeric::Real;
use crate::physics::card::{Answer, Card, Parameter, Port, Worked};
use crate::physics::component::facts::Symbol;
use crate::physics::fluid::Fluid;
use crate::physics::ports::{Law, PortFlows, PortVariables};

pub const EFFECT: Effect = Effect {
    name: "seal-friction",
    meaning: CARD.meaning,
    law: CARD.law,
    source: CARD.source,
    validity: CARD.validity,
    empirical: false,
    everywhere: true,
    at: At::Like { symbol: Symbol::Cylinder, named: true },
    form: Form::Shunt { card: &CARD, joints: &[Joint::Body], shared: &[] },
    parameters: &[
        FreeParameter {
            name: "coulomb",
            neutral: Some(0.0),
            first: InitialGuess::Value(150.0),
            plausible: (0.0, 20000.0),
        },
        FreeParameter {
            name: "breakaway",
            neutral: Some(0.0),
            first: InitialGuess::Value(100.0),
            plausible: (0.0, 20000.0),
        },
        FreeParameter {
            name: "stribeck_velocity",
            neutral: None,
            first: InitialGuess::Value(8.0),
            plausible: (2.0, 200.0),
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
    kind: "seal-friction",
    meaning: "Friction of seals and guides: Coulomb friction, more of it from rest (Stribeck).",
    law: "F = -(F_c + F_s exp(-(v/v_s)^2)) v / sqrt(v^2 + v_t^2)",
    source: "Armstrong-Helouvry, Dupont and Canudas de Wit, Automatica 30 (1994), 1083",
    validity: "No memory: below the transition speed it acts like viscous friction, a body at rest creeps.",
    parameters: &[
        Parameter::required("coulomb", "F_c", "N", "friction of the moving body").or(0.0),
        Parameter::required("breakaway", "F_s", "N", "further friction from rest").or(0.0),
        Parameter::required("stribeck_velocity", "v_s", "mm/s", "speed over which the breakaway friction fades")
            .positive()
            .or(8.0),
        Parameter::required("transition_speed", "v_t", "mm/s", "speed at which 71 % of the friction act")
            .positive()
            .or(1.0),
    ],
    ports: &[Port::mechanical("body", "what rubs")],
    worked: &[Worked {
        text: "10 N with 1 mm/s of transition hold back a body at 0.75 mm/s with 6 N",
        parameters: &[("coulomb", 10.0), ("transition_speed", 1.0)],
        at: &[0.0, 0.75e-3],
        inputs: &[],
        answer: Answer::Through(0),
        expect: -6.0,
    }],
    ..Card::EMPTY
};

#[derive(Debug, Clone, Copy)]
pub struct SealFriction<T> {
    coulomb: T,
    breakaway: T,
    stribeck: T,
    transition: T,
}

impl<T: Real> Law<T> for SealFriction<T> {
    fn new(p: &[T], _fluid: &Fluid<T>) -> Self {
        Self { coulomb: p[0], breakaway: p[1], stribeck: p[2], transition: p[3] }
    }

    #[inline]
    fn evaluate(&self, seen: &PortVariables<T>, answers: &mut PortFlows<T>) {
        let v = seen.z[1];
        let share = v / self.stribeck;
        let size = self.coulomb + self.breakaway * (-(share * share)).exp();
        answers.through[0] = -(size * v) / (v * v + self.transition * self.transition).sqrt();
    }
}
