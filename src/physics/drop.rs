//! A component with a further pressure drop in its line, which the rig file writes as a formula over its flow.

use super::ATMOSPHERE;
use super::card::Card;
use super::formula::Formula;
use super::ports::{PortFlows, PortVariables};
use crate::numeric::Real;

/// A law of two hydraulic ports, ahead of which pressure may be lost.
pub trait Throttle<T: Real> {
    /// Answers to what is seen.
    fn evaluate(&self, seen: &PortVariables<T>, answers: &mut PortFlows<T>);
}

/// The law of a component with two hydraulic ports, ahead of which a part of the pressure is lost: `q = law(p_in - d(p_in,
/// p_out, q), p_out)`.
///
/// The formula `d` sees the gauge pressures of both ports, Pa, the flow `q` into the first, m³/s, and its parameters, and
/// gives Pa. One `q` solves this as long as `d` rises with it, as every loss does. Worked: an orifice of 1e-7 m³/s/Pa^½ under
/// 10 bar with `d = K q²`, K = 1e14 Pa s²/m⁶, passes 1e-7 sqrt(1e6)/sqrt(1 + 1e14 1e-14) = 7.071e-5 m³/s.
#[derive(Debug, Clone)]
pub struct Dropped<L, T> {
    own: L,
    drop: Formula<T>,
}

/// Most steps towards the flow; near it each secant gains half as many digits again.
const STEPS: usize = 60;
/// Change of the flow that is rounding (that of pressures among it), as a share of the largest so far, and m³/s.
const ROUNDING: (f64, f64) = (1e-13, 1e-16);
/// What may be left after all steps, as a share of the largest flow.
const LEFT: f64 = 1e-9;
/// Half the width over which the slope at the flow is taken: m³/s, and as a share of it.
const WIDTH: (f64, f64) = (1e-9, 1e-6);
/// Steps with that slope: each brings the derivatives as much nearer as the slope is right.
const FOR_DERIVATIVES: usize = 3;

impl<L: Throttle<T>, T: Real> Dropped<L, T> {
    /// `card` has the formula, and `parameters` are those of it, SI.
    pub fn new(own: L, card: &'static Card, parameters: &[T]) -> Option<Self> {
        Some(Self { own, drop: Formula::new(card, parameters)? })
    }

    #[inline(never)]
    pub fn evaluate(&self, seen: &PortVariables<T>, answers: &mut PortFlows<T>) {
        let mut within = *seen;
        let mut flow_at = |flow: T| {
            let gauge = [seen.z[0] - ATMOSPHERE, seen.z[1] - ATMOSPHERE, flow];
            within.z[0] = seen.z[0] - self.drop.at(&gauge);
            self.own.evaluate(&within, answers);
            answers.through[0]
        };
        let mut over = |flow: f64| flow_at(T::constant(flow)).re() - flow;
        let root = root(&mut over);
        let width = WIDTH.0 + WIDTH.1 * root.abs();
        let slope = (over(root + width) - over(root - width)) / (2.0 * width);
        let mut flow = T::constant(root);
        for _ in 0..FOR_DERIVATIVES {
            flow = flow - (flow_at(flow) - flow) / slope;
        }
        // Its states are as the pressure behind the loss has them.
        flow_at(flow);
        answers.through[0] = flow;
        answers.through[1] = -flow;
    }
}

/// The root of `law(q) - q`: secants, kept within what is known to enclose it. Not a number where there is none within reach.
fn root(over: &mut impl FnMut(f64) -> f64) -> f64 {
    let start = over(0.0);
    let (mut low, mut high) = if start < 0.0 { (f64::NEG_INFINITY, 0.0) } else { (0.0, f64::INFINITY) };
    let (mut flow, mut largest) = (start, start.abs());
    let (mut slope, mut before) = (-1.0, (0.0, start));
    for _ in 0..STEPS {
        let height = over(flow);
        if height > 0.0 {
            low = low.max(flow);
        } else if height < 0.0 {
            high = high.min(flow);
        }
        let secant = (height - before.1) / (flow - before.0);
        // A loss that rises with the flow makes it steeper than -1.
        if secant.is_finite() && secant < 0.0 {
            slope = secant.min(-1.0);
        }
        before = (flow, height);
        let mut next = flow - height / slope;
        if !(low..=high).contains(&next) && (high - low).is_finite() {
            next = f64::midpoint(low, high);
        }
        largest = largest.max(next.abs());
        if (next - flow).abs() <= ROUNDING.0 * largest + ROUNDING.1 {
            return next;
        }
        flow = next;
    }
    if before.1.abs() <= LEFT * largest { before.0 } else { f64::NAN }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::expression::{Expression, Name};
    use crate::numeric::Dual;
    use crate::physics::component::{AnyLaw, orifice};
    use crate::physics::fluid::Fluid;
    use crate::units::Dimension;
    use approx::assert_relative_eq;

    type One = Dual<f64, 1>;

    /// An orifice of 1e-7 m³/s/Pa^½ behind a loss `K q |q|`, at a pressure drop and a coefficient with its derivative.
    fn flow(drop: f64, k: One) -> One {
        let flow = Dimension::FLOW;
        let coefficient = crate::units::Unit::parse("bar.min2/L2").unwrap().dimension;
        let names = [("in.p", Dimension::PRESSURE), ("out.p", Dimension::PRESSURE), ("q", flow), ("K", coefficient)];
        through("K * q * abs(q)", &names, (1e5 + drop, 1e5), k, 0.01)
    }

    /// The flow through the orifice, with `transition` in Pa, behind a loss, between two absolute pressures.
    fn through(loss: &str, names: &[(&str, Dimension)], (p_in, p_out): (f64, f64), k: One, transition: f64) -> One {
        let names: Vec<Name> =
            names.iter().map(|(name, dimension)| Name::new((*name).to_owned(), *dimension)).collect();
        let expression = Expression::parse_as(loss, &names, Dimension::PRESSURE).unwrap();
        let card = Card { formula: Some(Box::leak(Box::new(expression))), ..Card::EMPTY };
        let fluid: Vec<One> = [870.0, 0.0455, 1.4e9, 0.0, 0.0, 0.0, 1.0].map(One::constant).to_vec();
        // Cd (pi/4) d² sqrt(2/rho) = 1e-7.
        let diameter = (1e-7 / (0.7 * std::f64::consts::FRAC_PI_4 * (2.0f64 / 870.0).sqrt())).sqrt();
        let hole = [diameter, 0.7, transition].map(One::constant);
        let own = AnyLaw::new(&orifice::CARD, &hole, &Fluid::new(&fluid)).unwrap();
        let law = Dropped::new(own, Box::leak(Box::new(card)), &[k]).unwrap();
        let (mut seen, mut answers) = (PortVariables::default(), PortFlows::default());
        (seen.z[0], seen.z[1]) = (One::variable(p_in, 0), One::constant(p_out));
        seen.z[0].eps[0] = if k.eps[0] == 0.0 { 1.0 } else { 0.0 };
        law.evaluate(&seen, &mut answers);
        assert_eq!(answers.through[0].re(), -answers.through[1].re());
        answers.through[0]
    }

    #[test]
    fn a_loss_of_squares_is_a_smaller_orifice() {
        let expected = |k: f64| 1e-7 * 1e6f64.sqrt() / (1.0 + 1e-14 * k).sqrt();
        for k in [0.0, 1e10, 1e14, 1e18] {
            let found = flow(1e6, One::variable(k, 0));
            assert_relative_eq!(found.re, expected(k), max_relative = 1e-9);
            let slope = -0.5e-14 * expected(k) / (1.0 + 1e-14 * k);
            assert_relative_eq!(found.eps[0], slope, max_relative = 1e-6);
            assert_relative_eq!(flow(-1e6, One::constant(k)).re, -expected(k), max_relative = 1e-9);
        }
        assert_eq!(flow(0.0, One::constant(1e14)).re, 0.0);
    }

    #[test]
    fn a_laminar_loss_has_its_slope_at_rest_too() {
        let flow = Dimension::FLOW;
        let resistance = crate::units::Unit::parse("bar.min/L").unwrap();
        let names =
            [("in.p", Dimension::PRESSURE), ("out.p", Dimension::PRESSURE), ("q", flow), ("R", resistance.dimension)];
        let r = resistance.to_si(1.0);
        for (drop, tank) in [(0.0, 1e5), (1e-2, 90e5), (1.0, 90e5), (10.0, 1e5), (-5.0, 1e5)] {
            let found = through("R * q", &names, (tank + drop, tank), One::constant(r), 5e3);
            // Far below the transition the orifice is a resistance too, sqrt(dp_t)/g.
            let expected = 1.0 / (r + 5e3_f64.sqrt() / 1e-7);
            assert_relative_eq!(found.re, drop * expected, max_relative = 1e-5, epsilon = 1e-17);
            assert_relative_eq!(found.eps[0], expected, max_relative = 1e-5);
        }
    }
}
