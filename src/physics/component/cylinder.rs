//! Double-acting cylinder with one rod.

use super::facts::{Balance, Facts, Residuals, Settles, Symbol};
use crate::numeric::Real;
use crate::physics::ATMOSPHERE;
use crate::physics::card::{Answer, Card, Parameter, Port, Role, Worked};
use crate::physics::fluid::Fluid;
use crate::physics::law::annular_gap_conductance;
use crate::physics::ports::{Law, PortFlows, PortVariables};
use std::f64::consts::PI;

pub const FACTS: Facts = Facts {
    symbol: Symbol::Cylinder,
    residuals: Residuals::Cylinder { bore: CARD.place("bore"), rod: CARD.place("rod"), stroke: CARD.place("stroke") },
    balance: Balance::Chamber,
    settles: Settles::AtOnce,
};

pub const CARD: Card = Card {
    kind: "cylinder",
    meaning: "Double-acting cylinder with a rod on the B side and leakage through the piston's annular gap.",
    law: "q_A = A1 v + q_l,  q_B = -A2 v - q_l,  C_A = (V_A0 + A1 x)/beta,  C_B = (V_B0 + A2 (s - x))/beta;\n\
          q_l = pi D h³ (1 + 1.5 e²) (p_A - p_B)/(12 mu L) - pi D h v/2,  h = c/2;\n\
          F = A1 p_A - A2 p_B - b v - end stops",
    source: "paper, equations (1) and (2) with the sign of the leakage corrected; gap: Merritt (1967), eq. 2-53",
    validity: "Laminar leakage, h << D; areas those of the bore; end stops elastic with damping on the way in.",
    parameters: &[
        Parameter::required("bore", "D", "mm", "piston diameter").positive().usually(3.0, 3000.0),
        Parameter::required("rod", "D_r", "mm", "rod diameter").at_most("bore"),
        Parameter::required("stroke", "s", "mm", "way between the end stops").positive().usually(1.0, 30_000.0),
        Parameter::required("dead_volume_A", "V_A0", "cm3", "volume at A, hose included, at x = 0")
            .is(Role::Volume)
            .uncertain_per_event(0.05)
            .calibrated(0.1),
        Parameter::required("dead_volume_B", "V_B0", "cm3", "volume at B, hose included, at x = s")
            .is(Role::Volume)
            .uncertain_per_event(0.05)
            .calibrated(0.1),
        Parameter::required("mass", "m", "kg", "moving mass").is(Role::Mass).positive().calibrated(0.05),
        Parameter::required("viscous_friction", "b", "N.s/m", "friction force per speed")
            .is(Role::Viscous)
            .or(0.0)
            .calibrated(0.5),
        Parameter::required("clearance", "c", "mm", "diametral clearance of the piston")
            .is(Role::Clearance)
            .or(0.0)
            .at_most("bore"),
        Parameter::required("land_length", "L", "mm", "length of the gap").positive().or(20.0),
        Parameter::required("eccentricity", "e", "-", "relative eccentricity of the piston").or(0.0).within(0.0, 1.0),
        Parameter::required("stop_stiffness", "k_s", "N/um", "stiffness of the end stops").or(50.0),
        Parameter::required("stop_damping", "b_s", "kN.s/m", "damping of the end stops on the way in").or(80.0),
    ],
    ports: &[
        Port::hydraulic("A", "cap side"),
        Port::hydraulic("B", "rod side"),
        Port::mechanical("rod", "piston and rod: position 0 fully in, positive outwards"),
    ],
    worked: &[
        Worked {
            text: "0.25 mm of clearance at rest under 36.8 bar leak 2.65 L/min from A",
            parameters: &[("clearance", 0.25), ("bore", 40.0), ("rod", 20.0), ("stroke", 170.0), ("land_length", 37.4)],
            at: &[37.8e5, 1e5, 0.05, 0.0],
            inputs: &[],
            answer: Answer::Through(0),
            expect: 4.423e-5,
        },
        Worked {
            text: "10 bar on the cap side alone push with 1256.6 N",
            parameters: &[("bore", 40.0), ("rod", 20.0), ("stroke", 170.0)],
            at: &[ATMOSPHERE + 1e6, ATMOSPHERE, 0.05, 0.0],
            inputs: &[],
            answer: Answer::Through(2),
            expect: 1256.637,
        },
    ],
    sees_viscosity: true,
    ..Card::EMPTY
};

/// Depth in m over which the damping of an end stop comes in, so that contact is not a jump of the force.
const CONTACT: f64 = 2e-5;

#[derive(Debug, Clone, Copy)]
pub struct Cylinder<T> {
    area_a: T,
    area_b: T,
    stroke: T,
    dead_a: T,
    dead_b: T,
    mass: T,
    friction: T,
    /// At the temperature of reference.
    leak_conductance: T,
    /// Half the cross-section of the gap, m²: what the moving wall drags along per speed.
    drag_area: T,
    stop_stiffness: T,
    stop_damping: T,
    fluid: Fluid<T>,
}

impl<T: Real> Law<T> for Cylinder<T> {
    fn new(p: &[T], fluid: &Fluid<T>) -> Self {
        let area = |diameter: T| diameter * diameter * (PI / 4.0);
        let (bore, rod) = (p[0], p[1]);
        let gap = p[7] * 0.5;
        Self {
            area_a: area(bore),
            area_b: area(bore) - area(rod),
            stroke: p[2],
            dead_a: p[3],
            dead_b: p[4],
            mass: p[5],
            friction: p[6],
            leak_conductance: annular_gap_conductance(bore, gap, p[8], fluid.viscosity(), p[9]),
            drag_area: bore * gap * (PI / 2.0),
            stop_stiffness: p[10],
            stop_damping: p[11],
            fluid: *fluid,
        }
    }

    #[inline]
    fn evaluate(&self, seen: &PortVariables<T>, answers: &mut PortFlows<T>) {
        let [p_a, p_b, x, v, ..] = seen.z;
        let leak = self.leak_conductance * seen.fluidity * (p_a - p_b) - self.drag_area * v;
        answers.through[0] = self.area_a * v + leak;
        answers.through[1] = -(self.area_b * v) - leak;
        let zero = T::zero();
        // Outside the stroke the chambers keep the volume of its ends; the stops give by micrometres only.
        let inside = x.max(zero).min(self.stroke);
        answers.capacity[0] = (self.dead_a + self.area_a * inside) / self.fluid.bulk_modulus(p_a);
        answers.capacity[1] = (self.dead_b + self.area_b * (self.stroke - inside)) / self.fluid.bulk_modulus(p_b);
        let mut force = self.area_a * (p_a - ATMOSPHERE) - self.area_b * (p_b - ATMOSPHERE) - self.friction * v;
        if x.re() > self.stroke.re() {
            force -= self.stop(x - self.stroke, v);
        } else if x.re() < 0.0 {
            force += self.stop(-x, -v);
        }
        answers.through[2] = force;
        answers.capacity[2] = self.mass;
    }
}

impl<T: Real> Cylinder<T> {
    /// Force in N of an end stop against a piston `depth` m inside it that goes deeper with `speed` m/s.
    #[inline]
    fn stop(&self, depth: T, speed: T) -> T {
        let contact = (depth / CONTACT).min(T::constant(1.0));
        self.stop_stiffness * depth + self.stop_damping * contact * speed.max(T::zero())
    }
}
