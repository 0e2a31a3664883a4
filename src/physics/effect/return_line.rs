//! Resistance of the line into which directional valves drain.

use super::line_resistance::{self, LineResistance};
use super::{At, Effect, Form, FreeParameter, InitialGuess};
use crate::physics::card::{Answer, Card, Parameter, Port, Role, Worked};

pub const EFFECT: Effect = Effect {
    name: "return-line",
    meaning: CARD.meaning,
    law: CARD.law,
    source: CARD.source,
    validity: CARD.validity,
    empirical: false,
    everywhere: false,
    at: At::Return,
    form: Form::Series { card: &CARD },
    parameters: &[
        FreeParameter {
            name: "turbulent",
            neutral: Some(0.0),
            first: InitialGuess::Value(0.01),
            plausible: (0.0, 10.0),
        },
        FreeParameter { name: "laminar", neutral: Some(0.0), first: InitialGuess::Value(0.05), plausible: (0.0, 50.0) },
    ],
};

pub const CARD: Card = Card {
    kind: "return-line",
    meaning: "Pressure drop of the line, filter and cooler between the ports T of directional valves and the tank.",
    law: "dp = (R + R_0) q + K q |q|;  C = V/beta at the valves",
    parameters: &[
        line_resistance::CARD.parameters[0],
        line_resistance::CARD.parameters[1],
        Parameter::required("volume", "V", "cm3", "oil between the valves and the resistance")
            .is(Role::Volume)
            .positive()
            .or(50.0),
    ],
    ports: &[Port::hydraulic("near", "where the valves drain"), Port::hydraulic("far", "the tank")],
    worked: &[Worked {
        text: "0.0056 bar/(L/min)2 takes 0.0056 1600 + 0.01 40 = 9.36 bar for 40 L/min",
        parameters: &[("turbulent", 0.0056)],
        at: &[10.36e5, 1e5],
        inputs: &[],
        answer: Answer::Through(0),
        expect: 40e-3 / 60.0,
    }],
    ..line_resistance::CARD
};

/// The law is that of the line to a cylinder.
pub type ReturnLine<T> = LineResistance<T>;
