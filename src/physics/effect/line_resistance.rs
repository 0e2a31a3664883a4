//! Resistance of the line between a valve and its cylinder or motor.

use super::{At, Effect, Form, FreeParameter, InitialGuess};
use crate::numeric::Real;
use crate::physics::card::{Answer, Card, Parameter, Port, Role, Worked};
use crate::physics::fluid::Fluid;
use crate::physics::ports::{Law, PortFlows, PortVariables};

pub const EFFECT: Effect = Effect {
    name: "line-resistance",
    meaning: CARD.meaning,
    law: CARD.law,
    source: CARD.source,
    validity: CARD.validity,
    empirical: false,
    everywhere: false,
    at: At::Actuator,
    form: Form::Series { card: &CARD },
    parameters: &[
        FreeParameter {
            name: "turbulent",
            neutral: Some(0.0),
            first: InitialGuess::Value(0.03),
            plausible: (0.0, 10.0),
        },
        FreeParameter { name: "laminar", neutral: Some(0.0), first: InitialGuess::Value(0.1), plausible: (0.0, 50.0) },
    ],
};

pub const CARD: Card = Card {
    kind: "line-resistance",
    meaning: "Pressure drop of the line between a node and its cylinder or motor; sensors stay where they are.",
    law: "dp = (R + R_0) q + K q |q|;  C = V/beta at the near side, of a motor at the motor",
    source: "Hagen-Poiseuille and Darcy-Weisbach; Merritt (1967), section 3-2",
    validity: "No inertia of the oil in the line; R_0 = 0.01 bar/(L/min) keeps a line without resistance solvable.",
    parameters: &[
        Parameter::required("turbulent", "K", "bar.min2/L2", "pressure drop per square of the flow").or(0.0),
        Parameter::required("laminar", "R", "bar.min/L", "pressure drop per flow").or(0.0),
        Parameter::required("volume", "V", "cm3", "oil at the near end of the line; of a motor at the motor")
            .is(Role::Volume)
            .positive()
            .or(5.0),
    ],
    ports: &[
        Port::hydraulic("near", "where valves and sensors are; of a motor the motor"),
        Port::hydraulic("far", "where the cylinder is; of a motor valves and sensors"),
    ],
    worked: &[Worked {
        text: "0.04 bar/(L/min)2 and 0.09 bar/(L/min) with R_0 take 0.04 25 + 0.1 5 = 1.5 bar for 5 L/min",
        parameters: &[("turbulent", 0.04), ("laminar", 0.09)],
        at: &[2.5e5, 1e5],
        inputs: &[],
        answer: Answer::Through(0),
        expect: 8.333_3e-5,
    }],
    ..Card::EMPTY
};

/// Resistance that every line has here, Pa per m³/s: 0.01 bar/(L/min).
const LEAST: f64 = 1e3 * 6e4;

#[derive(Debug, Clone, Copy)]
pub struct LineResistance<T> {
    turbulent: T,
    laminar: T,
    volume: T,
    fluid: Fluid<T>,
}

impl<T: Real> Law<T> for LineResistance<T> {
    fn new(p: &[T], fluid: &Fluid<T>) -> Self {
        Self { turbulent: p[0], laminar: p[1] + LEAST, volume: p[2], fluid: *fluid }
    }

    #[inline]
    fn evaluate(&self, seen: &PortVariables<T>, answers: &mut PortFlows<T>) {
        let drop = seen.z[0] - seen.z[1];
        // The positive root of K q² + R q = |dp|, in the form that stays exact for K = 0.
        let root = (self.laminar * self.laminar + self.turbulent * drop.abs() * 4.0).sqrt();
        let flow = drop * 2.0 / (self.laminar + root);
        answers.through[0] = flow;
        answers.through[1] = -flow;
        answers.capacity[0] = self.volume / self.fluid.bulk_modulus(seen.z[0]);
    }
}
