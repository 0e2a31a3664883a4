//! Pump that turns both ways at a recorded speed.

use super::facts::{Balance, Facts, Residuals, Settles, Symbol};
use crate::numeric::Real;
use crate::physics::card::{ANY, Answer, Card, Input, Parameter, Port, Role, Worked};
use crate::physics::fluid::Fluid;
use crate::physics::ports::{Law, PortFlows, PortVariables};

pub const FACTS: Facts = Facts {
    symbol: Symbol::ReversiblePump,
    residuals: Residuals::None,
    balance: Balance::Through,
    settles: Settles::AtOnce,
};

pub const CARD: Card = Card {
    kind: "reversible-pump",
    meaning: "Fixed-displacement pump or motor that turns both ways, at a recorded speed.",
    law: "q_A = -D n + G (p_A - p_B) with k D for D where n < 0,  q_B = -q_A",
    source: "Wilson (1948): ideal displacement and laminar slip",
    validity: "Slip laminar and independent of the speed; no leakage to a case, no ripple, no cavitation.",
    parameters: &[
        Parameter::required("displacement", "D", "cc/rev", "volume per revolution").calibrated(0.1),
        Parameter::required("leakage", "G", "L/min/bar", "slip from the port of higher pressure to the other")
            .is(Role::Laminar)
            .or(0.0),
        Parameter::required(
            "reverse",
            "k",
            "-",
            "displacement at negative speed, as a share of that at positive speed",
        )
        .or(1.0)
        .within(0.1, 3.0),
    ],
    ports: &[Port::hydraulic("A", "outlet at positive speed"), Port::hydraulic("B", "inlet at positive speed")],
    inputs: &[Input {
        name: "speed",
        unit: "rev/min",
        meaning: "shaft speed, positive from B to A",
        range: ANY,
        lag: None,
    }],
    sees_viscosity: true,
    worked: &[
        Worked {
            text: "1.2 cc/rev at 1000 rev/min against 50 bar, 0.002 L/min/bar: 1.2 L/min less 0.1 L/min of slip out of A",
            parameters: &[("displacement", 1.2), ("leakage", 0.002)],
            at: &[51e5, 1e5],
            inputs: &[1000.0 / 60.0],
            answer: Answer::Through(0),
            expect: -1.1e-3 / 60.0,
        },
        Worked {
            text: "1.2 cc/rev, backwards 10 % more, at -1000 rev/min: 1.32 L/min into A",
            parameters: &[("displacement", 1.2), ("reverse", 1.1)],
            at: &[1e5, 1e5],
            inputs: &[-1000.0 / 60.0],
            answer: Answer::Through(0),
            expect: 1.32e-3 / 60.0,
        },
    ],
    ..Card::EMPTY
};

#[derive(Debug, Clone, Copy)]
pub struct ReversiblePump<T> {
    displacement: T,
    leakage: T,
    reverse: T,
}

impl<T: Real> Law<T> for ReversiblePump<T> {
    fn new(parameters: &[T], _fluid: &Fluid<T>) -> Self {
        Self { displacement: parameters[0], leakage: parameters[1], reverse: parameters[2] }
    }

    #[inline]
    fn evaluate(&self, seen: &PortVariables<T>, answers: &mut PortFlows<T>) {
        let [p_a, p_b, ..] = seen.z;
        let speed = seen.u[0];
        let swept = if speed.re() < 0.0 { self.displacement * self.reverse * speed } else { self.displacement * speed };
        let flow = self.leakage * seen.fluidity * (p_a - p_b) - swept;
        answers.through[0] = flow;
        answers.through[1] = -flow;
    }
}
