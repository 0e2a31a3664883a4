//! Directional control valve: four ports, three positions.

use super::facts::{Balance, Facts, Residuals, Settles, Symbol};
use super::orifice::TRANSITION;
use crate::numeric::Real;
use crate::physics::card::{Answer, Card, DEAD_TIME, INERTIA_TIME, Input, Parameter, Port, Role, State, Worked};
use crate::physics::fluid::Fluid;
use crate::physics::law::root;
use crate::physics::ports::{Law, PortFlows, PortVariables};

const fn share(name: &'static str, symbol: &'static str, meaning: &'static str) -> Parameter {
    Parameter::required(name, symbol, "-", meaning).or(1.0).within(0.0, 1.5)
}

/// Notches and chamfers open an edge slower or faster than its spool moves; few data sheets say how.
const fn progression(name: &'static str, symbol: &'static str, meaning: &'static str) -> Parameter {
    Parameter::required(name, symbol, "-", meaning).or(1.0).within(0.2, 5.0).is(Role::Edge).uncertain_per_event(0.05)
}

const fn leak(name: &'static str, symbol: &'static str, meaning: &'static str) -> Parameter {
    Parameter::required(name, symbol, "L/min/bar", meaning).is(Role::Laminar).or(0.0)
}

pub const FACTS: Facts = Facts {
    symbol: Symbol::DirectionalValve,
    residuals: Residuals::Directional {
        opening: CARD.place("opening"),
        rated_flow: CARD.place("rated_flow"),
        rated_drop: CARD.place("rated_drop"),
    },
    balance: Balance::Ends,
    settles: Settles::Lag,
};

pub const CARD: Card = Card {
    kind: "directional-valve",
    meaning: "4/3 directional control valve, closed centre, with internal leaks.",
    law: "q_edge = alpha alpha_edge |s|^n_edge q_r/sqrt(dp_r) root(dp);  s > 0: P-A, B-T;  s < 0: P-B, A-T;\n\
          leaks G_AT (p_A - p_T), G_PB (p_P - p_B), G_PA (p_P - p_A), G_BT (p_B - p_T), and of every edge G_0 dp r/(r + s_c (1 - r)), s_c = max(-s, 0) of P-A and B-T, \
          max(s, 0) of the others;\n\
          T² s'' + tau s' + s = u(t - t_d);\n\
          with hysteresis tau s' = e - min(max(e, -h/2), h/2),  e = u - s",
    source: "paper, equations (11) to (19); (13) with the bracket under the root",
    validity: "Zero lap, equal edges; leaks laminar. The opening coefficient is common or per path.",
    parameters: &[
        Parameter::required("rated_flow", "q_r", "L/min", "flow of one path, fully open, at the rated drop"),
        Parameter::required("rated_drop", "dp_r", "bar", "rated pressure drop of one path").positive().calibrated(0.05),
        share("opening", "alpha", "opening coefficient common to all paths"),
        share("opening_PA", "alpha_PA", "further opening coefficient of the path P to A").calibrated(0.02),
        share("opening_PB", "alpha_PB", "further opening coefficient of the path P to B").calibrated(0.02),
        share("opening_AT", "alpha_AT", "further opening coefficient of the path A to T").calibrated(0.02),
        share("opening_BT", "alpha_BT", "further opening coefficient of the path B to T").calibrated(0.02),
        leak("leak_AT", "G_AT", "internal leakage from A to T"),
        leak("leak_PB", "G_PB", "internal leakage from P to B"),
        Parameter::required("lag", "tau", "ms", "time constant with which the spool follows the command")
            .is(Role::Lag)
            .positive()
            .or(8.0)
            .uncertain_per_event(0.25),
        TRANSITION,
        progression("progression_PA", "n_PA", "exponent of the opening area of P to A over the spool position"),
        progression("progression_PB", "n_PB", "exponent of the opening area of P to B over the spool position"),
        progression("progression_AT", "n_AT", "exponent of the opening area of A to T over the spool position"),
        progression("progression_BT", "n_BT", "exponent of the opening area of B to T over the spool position"),
        Parameter::required("dead_band", "d", "-", "share of its way that the spool moves before an edge opens")
            .or(0.0)
            .within(0.0, 0.9),
        INERTIA_TIME,
        DEAD_TIME,
        Parameter::required("hysteresis", "h", "-", "width of the command within which the spool does not follow it")
            .or(0.0)
            .within(0.0, 0.5),
        leak(
            "null_leakage",
            "G_0",
            "leakage of one edge at spool position 0; with A and B shut that of the valve from P to T",
        ),
        Parameter::required(
            "closed_share",
            "r",
            "-",
            "share of its leakage that an edge has left once the spool has closed it fully",
        )
        .or(0.1)
        .within(0.001, 1.0),
        leak("leak_PA", "G_PA", "internal leakage from P to A"),
        leak("leak_BT", "G_BT", "internal leakage from B to T"),
    ],
    ports: &[
        Port::hydraulic("P", "pressure"),
        Port::hydraulic("T", "tank"),
        Port::hydraulic("A", "consumer port A"),
        Port::hydraulic("B", "consumer port B"),
    ],
    states: &[State { name: "spool", unit: "-", initial: 0.0, scale: 1.0, meaning: "spool position, -1 to 1" }],
    inputs: &[Input {
        name: "command",
        unit: "-",
        meaning: "+1 connects P-A and B-T, -1 P-B and A-T, 0 closes all",
        range: (-1.0, 1.0),
        lag: Some("lag"),
    }],
    worked: &[
        Worked {
            text: "half open, a quarter of the rated drop: a quarter of 8 L/min into P",
            parameters: &[("rated_flow", 8.0), ("rated_drop", 18.5), ("opening", 0.5), ("transition_pressure", 1e-4)],
            at: &[1e5 + 4.625e5, 1e5, 1e5, 1e5, 1.0],
            inputs: &[1.0],
            answer: Answer::Through(0),
            expect: 2e-3 / 60.0,
        },
        Worked {
            text: "closed, 0.01 L/min/bar from A to T under 50 bar: 0.5 L/min into A",
            parameters: &[("rated_flow", 8.0), ("rated_drop", 18.5), ("leak_AT", 0.01)],
            at: &[1e5, 1e5, 51e5, 1e5, 0.0],
            inputs: &[0.0],
            answer: Answer::Through(2),
            expect: 0.5e-3 / 60.0,
        },
        Worked {
            text: "closed, 0.02 L/min/bar from P to A under 50 bar: 1 L/min into P",
            parameters: &[("rated_flow", 8.0), ("rated_drop", 18.5), ("leak_PA", 0.02)],
            at: &[51e5, 1e5, 1e5, 1e5, 0.0],
            inputs: &[0.0],
            answer: Answer::Through(0),
            expect: 1e-3 / 60.0,
        },
        Worked {
            text: "closed, 0.01 L/min/bar from B to T under 40 bar: 0.4 L/min into B",
            parameters: &[("rated_flow", 8.0), ("rated_drop", 18.5), ("leak_BT", 0.01)],
            at: &[1e5, 1e5, 1e5, 41e5, 0.0],
            inputs: &[0.0],
            answer: Answer::Through(3),
            expect: 0.4e-3 / 60.0,
        },
        Worked {
            text: "A and B shut at half of 100 bar in the middle, 0.008 L/min/bar: both lands of P leak, 0.8 L/min from P to T",
            parameters: &[("rated_flow", 8.0), ("rated_drop", 18.5), ("null_leakage", 0.008)],
            at: &[101e5, 1e5, 51e5, 51e5, 0.0],
            inputs: &[0.0],
            answer: Answer::Through(0),
            expect: 0.8e-3 / 60.0,
        },
        Worked {
            text: "half open to A, a fifth left where fully closed: P to B under 100 bar leaks 0.2/(0.2 + 0.5 0.8) of 0.9 L/min",
            parameters: &[
                ("rated_flow", 8.0),
                ("rated_drop", 18.5),
                ("opening", 0.0),
                ("null_leakage", 0.009),
                ("closed_share", 0.2),
            ],
            at: &[101e5, 1e5, 101e5, 1e5, 0.5],
            inputs: &[0.5],
            answer: Answer::Through(0),
            expect: 0.3e-3 / 60.0,
        },
    ],
    ..Card::EMPTY
};

#[derive(Debug, Clone, Copy)]
pub struct DirectionalValve<T> {
    edge_pa: T,
    edge_pb: T,
    edge_at: T,
    edge_bt: T,
    leak_at: T,
    leak_pb: T,
    lag: T,
    transition: T,
    /// Of the edges PA, PB, AT, BT.
    progression: [T; 4],
    dead_band: T,
    hysteresis: T,
    null_leakage: T,
    closed_share: T,
    leak_pa: T,
    leak_bt: T,
}

/// Spool position below which an edge opens straight, a billionth of a molecule: a spool that lags never quite arrives, and the
/// slope of the logarithm of a position that is next to nothing is infinite.
const SHUT: f64 = 1e-20;

/// Share of an edge's area that is open at a spool position, `s^n`; `s` where the exponent is 1 and stays so.
#[inline]
fn opened<T: Real>(spool: T, progression: T) -> T {
    let extra = progression - T::one();
    if extra.is_zero() {
        return spool;
    }
    let logarithm = if spool.re() > SHUT { spool.ln() } else { T::constant(SHUT.ln()) };
    spool * (extra * logarithm).exp()
}

impl<T: Real> Law<T> for DirectionalValve<T> {
    fn new(p: &[T], _fluid: &Fluid<T>) -> Self {
        let common = p[2] * p[0] / p[1].sqrt();
        Self {
            edge_pa: common * p[3],
            edge_pb: common * p[4],
            edge_at: common * p[5],
            edge_bt: common * p[6],
            leak_at: p[7],
            leak_pb: p[8],
            lag: p[9],
            transition: p[10],
            progression: [p[11], p[12], p[13], p[14]],
            dead_band: p[15],
            hysteresis: p[18],
            null_leakage: p[19],
            closed_share: p[20],
            leak_pa: p[21],
            leak_bt: p[22],
        }
    }

    #[inline]
    fn evaluate(&self, seen: &PortVariables<T>, answers: &mut PortFlows<T>) {
        let [p_p, p_t, p_a, p_b, position, ..] = seen.z;
        let spool = self.past_dead_band(position);
        let leak_at = self.leak_at * (p_a - p_t);
        let leak_pb = self.leak_pb * (p_p - p_b);
        let (mut into_p, mut into_t) = (leak_pb, -leak_at);
        let (mut into_a, mut into_b) = (leak_at, -leak_pb);
        let [n_pa, n_pb, n_at, n_bt] = self.progression;
        if spool.re() > 0.0 {
            let pa = self.path_pa(p_p, p_a) * opened(spool, n_pa);
            let bt = self.edge_bt * opened(spool, n_bt) * root(p_b - p_t, self.transition);
            into_p += pa;
            into_a -= pa;
            into_b += bt;
            into_t -= bt;
        } else {
            let pb = self.edge_pb * opened(-spool, n_pb) * root(p_p - p_b, self.transition);
            let at = self.edge_at * opened(-spool, n_at) * root(p_a - p_t, self.transition);
            into_p += pb;
            into_b -= pb;
            into_a += at;
            into_t -= at;
        }
        if !(self.leak_pa.is_zero() && self.leak_bt.is_zero()) {
            let (pa, bt) = (self.leak_pa * (p_p - p_a), self.leak_bt * (p_b - p_t));
            into_p += pa;
            into_a -= pa;
            into_b += bt;
            into_t -= bt;
        }
        if !self.null_leakage.is_zero() {
            let (of_first, of_second) = (self.land(-position), self.land(position));
            let (pa, bt) = (of_first * (p_p - p_a), of_first * (p_b - p_t));
            let (pb, at) = (of_second * (p_p - p_b), of_second * (p_a - p_t));
            into_p += pa + pb;
            into_t -= at + bt;
            into_a += at - pa;
            into_b += bt - pb;
        }
        answers.through = [into_p, into_t, into_a, into_b];
        answers.rate[0] = self.past_hysteresis(seen.u[0] - position) / self.lag;
    }
}

impl<T: Real> DirectionalValve<T> {
    /// What of a distance from the command moves the spool, with its sign: none within the hysteresis.
    #[inline]
    fn past_hysteresis(&self, distance: T) -> T {
        if self.hysteresis.is_zero() {
            return distance;
        }
        let half = self.hysteresis * 0.5;
        let beyond = (distance.abs() - half).max(T::zero());
        if distance.re() < 0.0 { -beyond } else { beyond }
    }

    /// What of the spool's way opens an edge, with its sign.
    #[inline]
    fn past_dead_band(&self, position: T) -> T {
        if self.dead_band.is_zero() {
            return position;
        }
        let open = (position.abs() - self.dead_band).max(T::zero()) / (T::one() - self.dead_band);
        if position.re() < 0.0 { -open } else { open }
    }

    /// What an edge leaks per pressure, closed by a way of the spool; as much as in the middle where it is open.
    #[inline]
    fn land(&self, closed: T) -> T {
        let share = self.closed_share;
        self.null_leakage * share / (share + closed.max(T::zero()) * (T::one() - share))
    }

    /// Flow in m³/s through the path from P to A, fully switched, between two pressures (Pa).
    #[inline]
    pub fn path_pa(&self, p_p: T, p_a: T) -> T {
        self.edge_pa * root(p_p - p_a, self.transition)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numeric::Dual as Of;

    type Dual = Of<f64, 2>;

    #[test]
    fn a_shut_edge_has_finite_slopes() {
        for position in [0.0, 5e-324, 1e-310, 1e-30, 1e-20, 1e-3, 1.0] {
            let open = opened(Dual::variable(position, 0), Dual::variable(1.0, 1));
            assert!(open.is_finite(), "{position}: {open:?}");
            assert_eq!((open.re, open.eps[0]), (position, 1.0));
        }
        // s ln s, the slope by the exponent.
        let open = opened(Dual::variable(0.5, 0), Dual::variable(1.0, 1));
        approx::assert_relative_eq!(open.eps[1], 0.5 * 0.5_f64.ln(), max_relative = 1e-12);
    }
}
