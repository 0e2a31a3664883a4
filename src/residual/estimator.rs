//! Deviation estimators of single components, equations (4), (10), (18) and (20) of the paper.
//!
//! Derived from the mass balance of each component; where the printed equation differs, the printed one has a name with
//! `printed` in it. Flows in m³/s, pressures in Pa (all gauge or all absolute), areas in m².

use crate::numeric::Real;
use crate::physics::card::Card;
use crate::physics::component::cylinder;
use crate::physics::component::directional_valve::{self, DirectionalValve};
use crate::physics::component::flow_control_valve::{self, FlowControlValve};
use crate::physics::fluid::{self, Fluid};
use crate::physics::ports::Law;
use crate::rig::Rig;
use std::f64::consts::PI;

/// Areas of a cylinder on which the pressures act, m².
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Areas {
    /// Big side.
    pub a: f64,
    /// Rod side.
    pub b: f64,
}

impl Areas {
    /// From the diameters of bore and rod, m.
    pub fn of(bore: f64, rod: f64) -> Self {
        let a = PI / 4.0 * bore * bore;
        Self { a, b: a - PI / 4.0 * rod * rod }
    }

    /// Internal leakage from two flow meters in steady motion, (4) corrected: `(A1 q_B - A2 q_A)/(A1 - A2)`.
    ///
    /// From `q_A = A1 v + q_l` and `q_B = A2 v + q_l`, with `q_A` into the big side and `q_B` out of the rod side.
    /// Worked: bore 40, rod 20 mm, 4 q_B - 3 q_A: 5 L/min in and 4 L/min out are 1 L/min of leakage.
    pub fn leakage<T: Real>(&self, q_a: T, q_b: T) -> T {
        (q_b * self.a - q_a * self.b) / (self.a - self.b)
    }

    /// (4) as printed, divided by `A1 + A2`: too small by `(A1 + A2)/(A1 - A2)`, 7 for bore 40 and rod 20 mm.
    pub fn leakage_printed<T: Real>(&self, q_a: T, q_b: T) -> T {
        (q_b * self.a - q_a * self.b) / (self.a + self.b)
    }

    /// Internal leakage from one flow meter and the piston's velocity (m/s) in steady motion: `q_A - A1 v`.
    pub fn leakage_moving<T: Real>(&self, q_a: T, velocity: T) -> T {
        q_a - velocity * self.a
    }
}

/// The components that the paper diagnoses, at their healthy parameters.
#[derive(Debug, Clone, Copy)]
pub struct Healthy {
    pub areas: Areas,
    pub flow_control: FlowControlValve<f64>,
    pub directional: DirectionalValve<f64>,
}

impl Healthy {
    /// The first component of each kind of a rig, with `parameters` (all of the rig's, SI); `None` where the rig lacks one.
    pub fn of(rig: &Rig, parameters: &[f64]) -> Option<Self> {
        let fluid = Fluid::new(parameters.get(..fluid::CARD.parameters.len())?);
        let own = |card: &Card| {
            let component = rig.components.iter().find(|component| component.card.kind == card.kind)?;
            parameters.get(component.first_parameter..)?.get(..component.card.parameters.len())
        };
        let sheet = own(&cylinder::CARD)?;
        let [bore, rod] = ["bore", "rod"].map(|name| sheet[cylinder::CARD.place(name)]);
        Some(Self {
            areas: Areas::of(bore, rod),
            flow_control: FlowControlValve::new(own(&flow_control_valve::CARD)?, &fluid),
            directional: DirectionalValve::new(own(&directional_valve::CARD)?, &fluid),
        })
    }

    /// Lost flow of the flow control valve, (10) with the flow that the healthy valve passes at the measured pressures
    /// in place of a constant: positive where the valve is blocked.
    ///
    /// As printed, with the constant theoretical flow, a valve that does not regulate shows a deviation without a fault.
    pub fn blockage(&self, p_in: f64, p_out: f64, flow: f64) -> f64 {
        self.flow_control.steady_flow(p_in, p_out) - flow
    }

    /// (18): flow from P to A of the healthy valve, fully switched, minus the flow out of A. Sees the leakage from A to
    /// tank and the lost opening, not one from the other.
    pub fn valve_at_a(&self, p_p: f64, p_a: f64, q_a: f64) -> f64 {
        self.directional.path_pa(p_p, p_a) - q_a
    }

    /// (20): the same minus the flow into P. Sees the lost opening less the leakage from P to B.
    pub fn valve_at_p(&self, p_p: f64, p_a: f64, q_p: f64) -> f64 {
        self.directional.path_pa(p_p, p_a) - q_p
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;

    #[test]
    fn leakage_of_the_paper_cylinder() {
        let areas = Areas::of(0.04, 0.02);
        assert_relative_eq!(areas.leakage(5.0, 4.0), 1.0, max_relative = 1e-12);
        assert_relative_eq!(areas.leakage(5.0, 4.0), 7.0 * areas.leakage_printed(5.0, 4.0), max_relative = 1e-12);
        assert_relative_eq!(areas.leakage_moving(1.0 + areas.a * 0.05, 0.05), 1.0, max_relative = 1e-12);
    }
}
