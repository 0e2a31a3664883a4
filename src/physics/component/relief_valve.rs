//! Pressure-relief valve.

use super::facts::{Balance, Facts, Residuals, Settles, Symbol};
use crate::numeric::Real;
use crate::physics::card::{Answer, Card, Parameter, Port, Role, State, Worked};
use crate::physics::fluid::Fluid;
use crate::physics::law::root;
use crate::physics::ports::{Law, PortFlows, PortVariables};

pub const FACTS: Facts = Facts {
    symbol: Symbol::ReliefValve,
    residuals: Residuals::Relief { opens_at: CARD.place("set_pressure") },
    balance: Balance::Ends,
    settles: Settles::Lag,
};

pub const CARD: Card = Card {
    kind: "relief-valve",
    meaning: "Pressure-relief valve whose opening follows the overpressure with a lag.",
    law: "tau e' = (o + sqrt(o² + w²))/2 - e with o = p_P - p_T - p_c;  q = q_r (e/e_r) ((p_c + e_r)/(p_r + e_r))^m sqrt(dp/(p_c + e_r))",
    source: "static gradient of a data sheet; Merritt (1967), section 5-6, for the lag and for m = 1/2",
    validity: "Static line through cracking and rated point; no hysteresis, no flow below the cracking pressure. A poppet whose spring is set otherwise opens as far per overpressure as before, so that the flow goes with the root of the pressure: m = 1/2. Pilot-operated valves have parallel lines in their data sheets: m = 0. By default it is uncertain which.",
    parameters: &[
        Parameter::required("set_pressure", "p_c", "bar", "cracking pressure").calibrated(0.02),
        Parameter::required("rated_flow", "q_r", "L/min", "flow at the rated overpressure"),
        Parameter::required("rated_overpressure", "e_r", "bar", "pressure above cracking at the rated flow")
            .positive()
            .calibrated(0.2),
        Parameter::required("lag", "tau", "ms", "time constant of the opening")
            .is(Role::Lag)
            .positive()
            .or(3.0)
            .uncertain_per_event(0.25),
        Parameter::required("knee", "w", "bar", "width of a soft knee at the cracking pressure").or(0.0),
        Parameter::required("rated_setting", "p_r", "bar", "cracking pressure at which the rated flow was measured")
            .or_as("set_pressure"),
        Parameter::required(
            "setting_exponent",
            "m",
            "-",
            "power with which the flow per overpressure goes with the setting",
        )
        .is(Role::Reference)
        .or(0.0)
        .within(0.0, 1.0)
        .uncertain(0.5),
    ],
    ports: &[Port::hydraulic("P", "pressure side"), Port::hydraulic("T", "tank side")],
    states: &[State {
        name: "overpressure",
        unit: "bar",
        initial: 0.0,
        scale: 1.0,
        meaning: "overpressure that the opening has followed",
    }],
    worked: &[
        Worked {
            text: "2 bar above 100 bar with the opening settled pass the rated 5.5 L/min",
            parameters: &[("set_pressure", 100.0), ("rated_flow", 5.5), ("rated_overpressure", 2.0)],
            at: &[102e5 + 1e5, 1e5, 2e5],
            inputs: &[],
            answer: Answer::Through(0),
            expect: 5.5e-3 / 60.0,
        },
        Worked {
            text: "the same valve with its spring set to 23.5 bar passes half of that at 25.5 bar, a quarter of the pressure",
            parameters: &[
                ("set_pressure", 23.5),
                ("rated_flow", 5.5),
                ("rated_overpressure", 2.0),
                ("rated_setting", 100.0),
                ("setting_exponent", 0.5),
            ],
            at: &[25.5e5, 0.0, 2e5],
            inputs: &[],
            answer: Answer::Through(0),
            expect: 0.5 * 5.5e-3 / 60.0,
        },
    ],
    throttles: true,
    ..Card::EMPTY
};

#[derive(Debug, Clone, Copy)]
pub struct ReliefValve<T> {
    set_pressure: T,
    gradient: T,
    lag: T,
    knee: T,
}

impl<T: Real> Law<T> for ReliefValve<T> {
    fn new(parameters: &[T], _fluid: &Fluid<T>) -> Self {
        let [set_pressure, rated_flow, rated_overpressure, lag] =
            [parameters[0], parameters[1], parameters[2], parameters[3]];
        let [knee, rated_setting, setting_exponent] = [parameters[4], parameters[5], parameters[6]];
        let rated_at = set_pressure + rated_overpressure;
        let of_rated = rated_at / (rated_setting + rated_overpressure);
        let by_setting = (setting_exponent * of_rated.ln()).exp();
        let gradient = rated_flow / (rated_overpressure * rated_at.sqrt()) * by_setting;
        Self { set_pressure, gradient, lag, knee }
    }

    #[inline]
    fn evaluate(&self, seen: &PortVariables<T>, answers: &mut PortFlows<T>) {
        let [p_p, p_t, followed, ..] = seen.z;
        let drop = p_p - p_t;
        // The transition only keeps the root smooth where the valve is shut anyway.
        let flow = self.gradient * followed * root(drop, T::constant(1e3));
        answers.through[0] = flow;
        answers.through[1] = -flow;
        let over = drop - self.set_pressure;
        let wanted = if self.knee.is_zero() {
            over.max(T::zero())
        } else {
            (over + (over * over + self.knee * self.knee).sqrt()) * 0.5
        };
        answers.rate[0] = (wanted - followed) / self.lag;
    }
}
