//! Flow control valve: a reducing valve keeps the pressure drop over a throttle.

use super::facts::{Balance, Facts, Residuals, Settles, Spring, Symbol, Throttle};
use super::orifice::TRANSITION;
use crate::numeric::Real;
use crate::physics::card::{Answer, Card, Parameter, Port, Role, State, Worked};
use crate::physics::fluid::Fluid;
use crate::physics::law::{orifice_conductance, root};
use crate::physics::ports::{Law, PortFlows, PortVariables};

pub const FACTS: Facts = Facts {
    symbol: Symbol::FlowControlValve,
    residuals: Residuals::FlowControl {
        orifice: Throttle {
            diameter: CARD.place("orifice_diameter"),
            discharge_coefficient: CARD.place("discharge_coefficient"),
        },
        spring: Spring {
            rate: CARD.place("spring_rate"),
            compression: CARD.place("spring_compression"),
            spool_area: CARD.place("spool_area"),
        },
    },
    balance: Balance::Through,
    settles: Settles::Lag,
};

pub const CARD: Card = Card {
    kind: "flow-control-valve",
    meaning: "Two-way flow control valve: reducing valve, then throttle; regulating or saturated.",
    law: "(5) q = g_r sqrt(dp_r), g_r = Cd1 W1 x sqrt(2/rho);  (6) q = g_t sqrt(dp_t), g_t = Cd2 (pi d²/4) sqrt(2/rho);\n\
          dp = dp_r + dp_t = p_in - p_out, so q = g_r g_t/sqrt(g_r² + g_t²) root(dp), dp_t = dp g_r²/(g_r² + g_t²);\n\
          root(dp) = dp/(dp² + dp_0²)^(1/4);\n\
          (7) K (x1 - x*) = A dp_t + F0, 0 <= x* <= x_max;  (8) F0 = 2 f Cd1 W1 x dp_r;\n\
          tau x' = x* - x",
    source: "paper, equations (5) to (9), with x1 the spring compression at zero opening and f = Cv cos(theta)",
    validity: "No volume between the two edges, so one flow passes both; the flow force is off at f = 0, which gives the simplification of (9).",
    parameters: &[
        Parameter::required("orifice_diameter", "d", "mm", "diameter of the throttle orifice"),
        Parameter::required("discharge_coefficient", "Cd2", "-", "discharge coefficient of the throttle")
            .or(0.7)
            .within(0.1, 1.0)
            .calibrated(0.03),
        Parameter::required(
            "reducing_discharge_coefficient",
            "Cd1",
            "-",
            "discharge coefficient of the reducing valve",
        )
        .or(0.7)
        .within(0.1, 1.0)
        .calibrated(0.03),
        Parameter::required("area_gradient", "W1", "mm2/mm", "area of the reducing valve per opening"),
        Parameter::required("max_opening", "x_max", "mm", "opening at which the reducing valve is saturated")
            .positive(),
        Parameter::required("spring_rate", "K", "N/m", "spring of the reducing valve").positive(),
        Parameter::required("spring_compression", "x1", "mm", "compression of the spring at zero opening")
            .calibrated(0.03),
        Parameter::required("spool_area", "A", "mm2", "area on which the throttle's pressure drop acts"),
        Parameter::required("flow_force", "f", "-", "Cv cos(theta) of the flow force; 0 switches it off").or(0.0),
        Parameter::required("lag", "tau", "ms", "time constant of the opening")
            .is(Role::Lag)
            .positive()
            .or(4.0)
            .uncertain_per_event(0.25),
        TRANSITION,
    ],
    ports: &[Port::hydraulic("in", "inlet"), Port::hydraulic("out", "outlet")],
    states: &[State {
        name: "opening",
        unit: "mm",
        initial: 0.0,
        scale: 1.0,
        meaning: "opening of the reducing valve",
    }],
    worked: &[
        Worked {
            text: "5 mm throttle, reducing valve saturated at 1.5 mm: g_r = 5.0343e-7, g_t = 6.5900e-7, in series \
                   4.0005e-7 m3/s per Pa^½; 1 bar passes 7.59 L/min",
            parameters: SHEET,
            at: &[2e5, 1e5, 1.5e-3],
            inputs: &[],
            answer: Answer::Through(0),
            expect: 1.265_1e-4,
        },
        Worked {
            text: "2 mm throttle (g_t = 1.0544e-7), opening 0.5 mm (g_r = 1.6781e-7), 10 bar: dp_t = 7.169 bar, so the \
                   spring wants 15 mm - 7.169 bar 101.35 mm2 / 5 N/mm = 0.467 mm and the opening closes at 8.18 mm/s",
            parameters: SHEET_2MM,
            at: &[11e5, 1e5, 0.5e-3],
            inputs: &[],
            answer: Answer::Rate(0),
            expect: -8.18e-3,
        },
    ],
    throttles: true,
    ..Card::EMPTY
};

const SHEET: &[(&str, f64)] = &[
    ("orifice_diameter", 5.0),
    ("area_gradient", 10.0),
    ("max_opening", 1.5),
    ("spring_rate", 5000.0),
    ("spring_compression", 15.0),
    ("spool_area", 101.35),
    ("transition_pressure", 1e-4),
];
const SHEET_2MM: &[(&str, f64)] = &[
    ("orifice_diameter", 2.0),
    ("area_gradient", 10.0),
    ("max_opening", 1.5),
    ("spring_rate", 5000.0),
    ("spring_compression", 15.0),
    ("spool_area", 101.35),
    ("transition_pressure", 1e-4),
];

#[derive(Debug, Clone, Copy)]
pub struct FlowControlValve<T> {
    throttle: T,
    reducing_gradient: T,
    max_opening: T,
    compression: T,
    area_per_rate: T,
    /// Opening lost per opening and pressure drop over the reducing valve, 1/Pa.
    flow_force: T,
    lag: T,
    transition: T,
}

impl<T: Real> Law<T> for FlowControlValve<T> {
    fn new(p: &[T], fluid: &Fluid<T>) -> Self {
        let (discharge, gradient, spring_rate) = (p[2], p[3], p[5]);
        Self {
            throttle: orifice_conductance(p[1], p[0], fluid.density()),
            reducing_gradient: discharge * gradient * (T::constant(2.0) / fluid.density()).sqrt(),
            max_opening: p[4],
            compression: p[6],
            area_per_rate: p[7] / spring_rate,
            flow_force: p[8] * discharge * gradient * 2.0 / spring_rate,
            lag: p[9],
            transition: p[10],
        }
    }

    #[inline]
    fn evaluate(&self, seen: &PortVariables<T>, answers: &mut PortFlows<T>) {
        let [p_in, p_out, opening, ..] = seen.z;
        let (flow, throttle_drop) = self.in_series(self.reducing_gradient * opening, p_in - p_out);
        let drop = p_in - p_out;
        answers.through[0] = flow;
        answers.through[1] = -flow;
        let wanted =
            self.compression - self.area_per_rate * throttle_drop - self.flow_force * opening * (drop - throttle_drop);
        answers.rate[0] = (wanted.max(T::zero()).min(self.max_opening) - opening) / self.lag;
    }
}

impl<T: Real> FlowControlValve<T> {
    /// Flow in m³/s through reducing edge and throttle under a common pressure drop, and the drop over the throttle in Pa.
    ///
    /// One flow passes both, so drops are as the inverse squares of the conductances; the laminar start is that of the two
    /// as one orifice.
    #[inline]
    fn in_series(&self, reducing: T, drop: T) -> (T, T) {
        let square = reducing * reducing;
        let both = square + self.throttle * self.throttle;
        if both.re() <= 0.0 {
            return (T::zero(), drop);
        }
        let flow = reducing * self.throttle / both.sqrt() * root(drop, self.transition);
        (flow, drop * square / both)
    }
}

impl FlowControlValve<f64> {
    /// Flow in m³/s that the valve settles at between two pressures (Pa): the opening at which its spool is at rest.
    ///
    /// Worked: 2 mm throttle of the data sheet over 10 bar: opening 0.498 mm, 5.35 L/min.
    pub fn steady_flow(&self, p_in: f64, p_out: f64) -> f64 {
        let at = |opening: f64| {
            let mut answers = PortFlows::default();
            let mut seen = PortVariables::default();
            (seen.z[0], seen.z[1], seen.z[2]) = (p_in, p_out, opening);
            self.evaluate(&seen, &mut answers);
            (answers.through[0], answers.rate[0])
        };
        // Further open, the throttle's drop grows and closes the spool harder: one opening is at rest, halving finds it.
        let (mut low, mut high) = (0.0, self.max_opening);
        for _ in 0..60 {
            let middle = f64::midpoint(low, high);
            if at(middle).1 > 0.0 { low = middle } else { high = middle }
        }
        at(high).0
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;

    fn valve(sheet: &[(&str, f64)]) -> FlowControlValve<f64> {
        let value = |parameter: &Parameter| {
            let given = sheet.iter().find(|(name, _)| *name == parameter.name).map(|(_, value)| *value);
            let unit = crate::units::Unit::parse(parameter.unit).unwrap();
            unit.to_si(given.or(parameter.default).unwrap())
        };
        FlowControlValve::new(
            &CARD.parameters.iter().map(value).collect::<Vec<_>>(),
            &Fluid::new(&[870.0, 0.0455, 1.4e9, 0.0, 0.0, 0.0, 1.0]),
        )
    }

    #[test]
    fn the_spool_rests_where_the_spring_balances_the_throttle() {
        assert_relative_eq!(valve(SHEET_2MM).steady_flow(11e5, 1e5) * 6e4, 5.350, max_relative = 1e-3);
        // Too little pressure to move the spool: saturated, as the first worked number.
        assert_relative_eq!(valve(SHEET).steady_flow(2e5, 1e5), 1.265_1e-4, max_relative = 1e-3);
        assert_eq!(valve(SHEET).steady_flow(1e5, 1e5), 0.0);
    }
}
