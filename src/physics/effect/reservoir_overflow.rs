//! An open reservoir that overflows.

use super::{At, Effect, Form, FreeParameter, InitialGuess, Joint};
use crate::numeric::Real;
use crate::physics::card::{Answer, Card, Parameter, Port, Worked};
use crate::physics::component::reservoir;
use crate::physics::fluid::Fluid;
use crate::physics::ports::{Law, PortFlows, PortVariables};

use crate::physics::{ATMOSPHERE, GRAVITY};

pub const EFFECT: Effect = Effect {
    name: "reservoir-overflow",
    meaning: CARD.meaning,
    law: CARD.law,
    source: CARD.source,
    validity: CARD.validity,
    empirical: false,
    everywhere: false,
    at: At::Component { card: &reservoir::CARD, named: true },
    form: Form::Shunt {
        card: &CARD,
        joints: &[Joint::Hydraulic(0), Joint::Next, Joint::Tank],
        shared: &[("area", "area")],
    },
    parameters: &[
        FreeParameter { name: "height", neutral: None, first: InitialGuess::Range(0.85), plausible: (0.0, 1e4) },
        FreeParameter { name: "share", neutral: None, first: InitialGuess::Value(0.3), plausible: (0.0, 1.0) },
    ],
};

pub const CARD: Card = Card {
    kind: "reservoir-overflow",
    meaning: "What rises above the rim leaves the reservoir; a share of it reaches the next one.",
    law: "q = A max(h - h_r, 0)/tau;  share of it into the next reservoir",
    source: "Schoukens and Noel, cascaded tanks with overflow (2016)",
    validity: "The rim is wide: what stands above it leaves within tau.",
    parameters: &[
        Parameter::required("height", "h_r", "cm", "level at which it overflows"),
        Parameter::required("share", "s", "-", "share of the overflow that reaches the next reservoir")
            .or(0.0)
            .within(0.0, 1.0),
        Parameter::required("area", "A", "cm2", "horizontal cross-section").positive().or(100.0),
        Parameter::required("time", "tau", "s", "time in which what stands above the rim leaves").positive().or(1.0),
    ],
    ports: &[
        Port::hydraulic("P", "what overflows"),
        Port::hydraulic("N", "next reservoir"),
        Port::hydraulic("T", "tank"),
    ],
    worked: &[Worked {
        text: "1 cm above the rim of 100 cm2 leave within 1 s: 1e-4 m3/s",
        parameters: &[("height", 9.0), ("area", 100.0)],
        at: &[ATMOSPHERE + 870.0 * GRAVITY * 0.1, 1e5, 1e5],
        inputs: &[],
        answer: Answer::Through(0),
        expect: 1e-4,
    }],
    ..Card::EMPTY
};

#[derive(Debug, Clone, Copy)]
pub struct ReservoirOverflow<T> {
    height: T,
    share: T,
    per_level: T,
    level_per_pressure: T,
}

impl<T: Real> Law<T> for ReservoirOverflow<T> {
    fn new(p: &[T], fluid: &Fluid<T>) -> Self {
        Self {
            height: p[0],
            share: p[1],
            per_level: p[2] / p[3],
            level_per_pressure: T::one() / (fluid.density() * GRAVITY),
        }
    }

    #[inline]
    fn evaluate(&self, seen: &PortVariables<T>, answers: &mut PortFlows<T>) {
        let level = (seen.z[0] - ATMOSPHERE) * self.level_per_pressure;
        let flow = self.per_level * (level - self.height).max(T::zero());
        answers.through[0] = flow;
        answers.through[1] = -(self.share * flow);
        answers.through[2] = self.share * flow - flow;
    }
}
