//! Dry friction of a body, such as that of seals and guides.

use super::facts::{Balance, Facts, Residuals, Settles, Symbol};
use crate::numeric::Real;
use crate::physics::card::{Answer, Card, Parameter, Port, Worked};
use crate::physics::fluid::Fluid;
use crate::physics::ports::{Law, PortFlows, PortVariables};

pub const FACTS: Facts =
    Facts { symbol: Symbol::Hidden, residuals: Residuals::None, balance: Balance::Ends, settles: Settles::AtOnce };

pub const CARD: Card = Card {
    kind: "coulomb-friction",
    meaning: "Dry friction of a body: a force against the motion that does not depend on its speed.",
    law: "F = -F_c v / sqrt(v² + v_t²)",
    source: "Coulomb's law, its sign made smooth; Armstrong-Hélouvry, Dupont and Canudas de Wit, Automatica 30 (1994)",
    validity: "No sticking: below the transition speed it acts like viscous friction and a body at rest creeps.",
    parameters: &[
        Parameter::required("force", "F_c", "N", "friction force of the moving body"),
        Parameter::required("transition_speed", "v_t", "mm/s", "speed at which 71 % of the force act")
            .positive()
            .or(1.0),
    ],
    ports: &[Port::mechanical("body", "what rubs")],
    worked: &[Worked {
        text: "10 N with 1 mm/s of transition hold back a body at 0.75 mm/s with 6 N",
        parameters: &[("force", 10.0), ("transition_speed", 1.0)],
        at: &[0.0, 0.75e-3],
        inputs: &[],
        answer: Answer::Through(0),
        expect: -6.0,
    }],
    ..Card::EMPTY
};

#[derive(Debug, Clone, Copy)]
pub struct CoulombFriction<T> {
    force: T,
    transition: T,
}

impl<T: Real> Law<T> for CoulombFriction<T> {
    fn new(parameters: &[T], _fluid: &Fluid<T>) -> Self {
        Self { force: parameters[0], transition: parameters[1] }
    }

    #[inline]
    fn evaluate(&self, seen: &PortVariables<T>, answers: &mut PortFlows<T>) {
        let v = seen.z[1];
        answers.through[0] = -(self.force * v) / (v * v + self.transition * self.transition).sqrt();
    }
}
