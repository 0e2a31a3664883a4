//! Leakage past the piston through a hole.

use super::{At, Effect, Form, FreeParameter, InitialGuess, Joint};
use crate::numeric::Real;
use crate::physics::card::{Answer, Card, Parameter, Port, Worked};
use crate::physics::component::facts::Symbol;
use crate::physics::fluid::Fluid;
use crate::physics::ports::{Law, PortFlows, PortVariables};

use crate::physics::law::root;

pub const EFFECT: Effect = Effect {
    name: "orifice-leakage",
    meaning: CARD.meaning,
    law: CARD.law,
    source: CARD.source,
    validity: CARD.validity,
    empirical: false,
    everywhere: true,
    at: At::Like { symbol: Symbol::Cylinder, named: true },
    form: Form::Shunt { card: &CARD, joints: &[Joint::Hydraulic(0), Joint::Hydraulic(1)], shared: &[] },
    parameters: &[FreeParameter {
        name: "area",
        neutral: Some(0.0),
        first: InitialGuess::Value(0.05),
        plausible: (0.0, 5.0),
    }],
};

pub const CARD: Card = Card {
    kind: "orifice-leakage",
    meaning: "Leakage from A to B that follows the law of a hole, not that of a gap: a scratch, a test throttle, a broken seal.",
    law: "q = Cd A sqrt(2 dp/rho)",
    source: "orifice law, paper equation (6); paper-notes: the paper's rig leaks through a throttle",
    validity: "Turbulent; smooth below 0.05 bar.",
    parameters: &[
        Parameter::required("area", "A", "mm2", "cross-section of the hole").or(0.0),
        Parameter::required("discharge_coefficient", "Cd", "-", "discharge coefficient").or(0.7).within(0.1, 1.0),
    ],
    ports: &[Port::hydraulic("A", "cap side"), Port::hydraulic("B", "rod side")],
    worked: &[Worked {
        text: "0.1 mm2 under 50 bar leak 7.505e-6 m3/s from A to B",
        parameters: &[("area", 0.1)],
        at: &[51e5, 1e5],
        inputs: &[],
        answer: Answer::Through(0),
        expect: 7.505e-6,
    }],
    ..Card::EMPTY
};

/// Pressure drop in Pa below which the flow is laminar.
const TRANSITION: f64 = 5e3;

#[derive(Debug, Clone, Copy)]
pub struct OrificeLeakage<T> {
    conductance: T,
}

impl<T: Real> Law<T> for OrificeLeakage<T> {
    fn new(p: &[T], fluid: &Fluid<T>) -> Self {
        Self { conductance: p[1] * p[0] * (T::constant(2.0) / fluid.density()).sqrt() }
    }

    #[inline]
    fn evaluate(&self, seen: &PortVariables<T>, answers: &mut PortFlows<T>) {
        let flow = self.conductance * root(seen.z[0] - seen.z[1], T::constant(TRANSITION));
        answers.through[0] = flow;
        answers.through[1] = -flow;
    }
}
