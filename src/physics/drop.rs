//! A component with a further pressure drop in its line, which the rig file writes as a formula over its flow.

use super::ATMOSPHERE;
use super::card::Card;
use super::component::{Answers, AnyLaw, Seen};
use super::formula::Formula;
use crate::numeric::Real;

/// The law of a component with two hydraulic ports, ahead of which a part of the pressure is lost: `q = law(p_in - d(p_in,
/// p_out, q), p_out)`.
///
/// The formula `d` sees the gauge pressures of both ports, Pa, the flow `q` into the first, m³/s, and its parameters, and
/// gives Pa. One `q` solves this as long as `d` rises with it, as every loss does. Worked: an orifice of 1e-7 m³/s/Pa^½ under
/// 10 bar with `d = K q²`, K = 1e14 Pa s²/m⁶, passes 1e-7 sqrt(1e6)/sqrt(1 + 1e14 1e-14) = 7.071e-5 m³/s.
#[derive(Debug, Clone)]
pub struct Dropped<T> {
    own: AnyLaw<T>,
    drop: Formula<T>,
}

/// Most steps towards the flow; near it each secant gains half as many digits again.
const STEPS: usize = 60;
/// Change of the flow, as a share of the largest so far, that is rounding.
const ROUNDING: f64 = 1e-14;
/// Steps taken when the flow stays: each brings its derivatives as much nearer as the ones before brought the flow.
const FOR_DERIVATIVES: usize = 2;

impl<T: Real> Dropped<T> {
    /// `card` has the formula, and `parameters` are those of it, SI.
    pub fn new(own: AnyLaw<T>, card: &'static Card, parameters: &[T]) -> Option<Self> {
        Some(Self { own, drop: Formula::new(card, parameters)? })
    }

    #[inline(never)]
    pub fn evaluate(&self, seen: &Seen<T>, answers: &mut Answers<T>) {
        let mut within = *seen;
        let mut flow_at = |flow: T| {
            let gauge = [seen.z[0] - ATMOSPHERE, seen.z[1] - ATMOSPHERE, flow];
            within.z[0] = seen.z[0] - self.drop.at(&gauge);
            self.own.evaluate(&within, answers);
            answers.through[0]
        };
        // The root of h(q) = law(q) - q: secants, kept within what is known to enclose it.
        let mut flow = flow_at(T::zero());
        let mut largest = flow.re().abs();
        let start = flow.re();
        let (mut low, mut high) = if start < 0.0 { (f64::NEG_INFINITY, 0.0) } else { (0.0, f64::INFINITY) };
        let (mut slope, mut before) = (-1.0, Some((0.0, start)));
        let mut left = FOR_DERIVATIVES;
        for _ in 0..STEPS {
            let over = flow_at(flow) - flow;
            let (at, height) = (flow.re(), over.re());
            if height > 0.0 {
                low = low.max(at);
            } else if height < 0.0 {
                high = high.min(at);
            }
            if let Some((then, was)) = before.filter(|(then, _)| at != *then) {
                let secant: f64 = (height - was) / (at - then);
                // A loss only makes it steeper than -1.
                slope = if secant.is_finite() { secant.min(-f64::EPSILON) } else { slope };
            }
            before = Some((at, height));
            let mut next = flow - over / slope;
            if !(low..=high).contains(&next.re()) && (high - low).is_finite() {
                next = next + (f64::midpoint(low, high) - next.re());
            }
            largest = largest.max(next.re().abs());
            let still = (next.re() - at).abs() <= ROUNDING * largest;
            flow = next;
            if still {
                left -= 1;
                if left == 0 {
                    break;
                }
            }
        }
        flow_at(flow);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::expression::{Expression, Name};
    use crate::numeric::Dual;
    use crate::physics::component::orifice;
    use crate::physics::fluid::Fluid;
    use crate::units::Dimension;
    use approx::assert_relative_eq;

    type One = Dual<f64, 1>;

    /// An orifice of 1e-7 m³/s/Pa^½ behind a loss `K q |q|`, at a pressure drop and a coefficient with its derivative.
    fn flow(drop: f64, k: One) -> One {
        let flow = Dimension::FLOW;
        let coefficient = crate::units::Unit::parse("bar.min2/L2").unwrap().dimension;
        let names = [("in.p", Dimension::PRESSURE), ("out.p", Dimension::PRESSURE), ("q", flow), ("K", coefficient)];
        let names = names.map(|(name, dimension)| Name::new(name.to_owned(), dimension));
        let expression = Expression::parse_as("K * q * abs(q)", &names, Dimension::PRESSURE).unwrap();
        let card = Card { formula: Some(Box::leak(Box::new(expression))), ..Card::EMPTY };
        let fluid: Vec<One> = [870.0, 0.0455, 1.4e9, 0.0, 0.0, 0.0].map(One::constant).to_vec();
        // Cd (pi/4) d² sqrt(2/rho) = 1e-7.
        let diameter = (1e-7 / (0.7 * std::f64::consts::FRAC_PI_4 * (2.0f64 / 870.0).sqrt())).sqrt();
        let hole = [diameter, 0.7, 0.01].map(One::constant);
        let own = AnyLaw::new(&orifice::CARD, &hole, &Fluid::new(&fluid)).unwrap();
        let law = Dropped::new(own, Box::leak(Box::new(card)), &[k]).unwrap();
        let (mut seen, mut answers) = (Seen::default(), Answers::default());
        (seen.z[0], seen.z[1]) = (One::constant(1e5 + drop), One::constant(1e5));
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
}
