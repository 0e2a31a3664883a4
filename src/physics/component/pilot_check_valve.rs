//! Check valve that a pilot pressure opens.

use super::facts::{Balance, Facts, Residuals, Settles, Symbol};
use super::orifice::TRANSITION;
use crate::numeric::Real;
use crate::physics::card::{Answer, Card, Parameter, Port, Worked};
use crate::physics::fluid::Fluid;
use crate::physics::law::root;
use crate::physics::ports::{Law, PortFlows, PortVariables};

pub const FACTS: Facts = Facts {
    symbol: Symbol::PilotCheckValve,
    residuals: Residuals::None,
    balance: Balance::Ends,
    settles: Settles::AtOnce,
};

pub const CARD: Card = Card {
    kind: "pilot-check-valve",
    meaning: "Pilot-operated check valve: free from `in` to `out`; back again while the pilot pressure holds it open.",
    law: "q = phi q_r root(p_in - p_out)/sqrt(dp_r),  phi = (p_in - p_out + r max(p_X - p_in, 0) - p_c)/w within 0 and 1",
    source: "balance of the forces on poppet and pilot piston; orifice law, paper equation (6)",
    validity: "No poppet dynamics, no flow forces, no leakage when shut; the back of the pilot piston is at `in`.",
    parameters: &[
        Parameter::required("rated_flow", "q_r", "L/min", "flow at the rated drop, fully open"),
        Parameter::required("rated_drop", "dp_r", "bar", "rated pressure drop").positive().calibrated(0.1),
        Parameter::required("cracking_pressure", "p_c", "bar", "pressure drop at which it begins to open")
            .or(0.3)
            .calibrated(0.2),
        Parameter::required("pilot_ratio", "r", "-", "area of the pilot piston over that of the seat")
            .or(3.0)
            .within(0.0, 20.0),
        Parameter::required("opening_range", "w", "bar", "pressure from cracking to fully open").positive().or(1.0),
        TRANSITION,
    ],
    ports: &[
        Port::hydraulic("in", "inlet"),
        Port::hydraulic("out", "outlet, held when shut"),
        Port::hydraulic("X", "pilot; takes no flow"),
    ],
    worked: &[
        Worked {
            text: "20 L/min at 5 bar, wide open by 30 bar of pilot pressure: 10 L/min come back under 1.25 bar",
            parameters: &[("rated_flow", 20.0), ("rated_drop", 5.0), ("transition_pressure", 1e-4)],
            at: &[1e5, 2.25e5, 31e5],
            inputs: &[],
            answer: Answer::Through(1),
            expect: 10e-3 / 60.0,
        },
        Worked {
            text: "half open at 0.8 bar, cracking at 0.3 bar over 1 bar, 20 L/min at 0.8 bar: 10 L/min",
            parameters: &[("rated_flow", 20.0), ("rated_drop", 0.8), ("transition_pressure", 1e-4)],
            at: &[1.8e5, 1e5, 1e5],
            inputs: &[],
            answer: Answer::Through(0),
            expect: 10e-3 / 60.0,
        },
    ],
    ..Card::EMPTY
};

#[derive(Debug, Clone, Copy)]
pub struct PilotCheckValve<T> {
    conductance: T,
    cracking_pressure: T,
    pilot_ratio: T,
    opening_range: T,
    transition: T,
}

impl<T: Real> Law<T> for PilotCheckValve<T> {
    fn new(p: &[T], _fluid: &Fluid<T>) -> Self {
        Self {
            conductance: p[0] / p[1].sqrt(),
            cracking_pressure: p[2],
            pilot_ratio: p[3],
            opening_range: p[4],
            transition: p[5],
        }
    }

    #[inline]
    fn evaluate(&self, seen: &PortVariables<T>, answers: &mut PortFlows<T>) {
        let [p_in, p_out, p_pilot, ..] = seen.z;
        let pilot = self.pilot_ratio * (p_pilot - p_in).max(T::zero());
        let lift = (p_in - p_out + pilot - self.cracking_pressure) / self.opening_range;
        let open = lift.max(T::zero()).min(T::one());
        let flow = self.conductance * open * root(p_in - p_out, self.transition);
        answers.through[0] = flow;
        answers.through[1] = -flow;
    }
}
