//! A component as measured channels show it: its law evaluated at readings instead of states.

use super::known::{Laws, Parameters};
use super::reading::{Readings, Source};
use crate::numeric::{Dual, Real};
use crate::physics::ATMOSPHERE;
use crate::physics::card::PortKind;
use crate::physics::component::AnyLaw;
use crate::physics::ports::{INPUTS, PortFlows, PortVariables, VARIABLES};
use crate::rig::{NodeKind, Quantity, Rig};

/// Where a variable of a component's law comes from.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Variable {
    Unused,
    /// Gauge pressure shown by a reading.
    Pressure(usize),
    /// Gauge pressure kept by a parameter.
    Held(usize),
    /// Position, velocity or state of the component shown by a reading.
    Motion(usize),
    /// A state of the component that nobody measures, taken at rest: lags are short against a window.
    Settled,
}

/// A component whose every variable is measured, held or at rest.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct View {
    pub component: usize,
    z: [Variable; VARIABLES],
    u: [Option<usize>; INPUTS],
}

/// Steps of the search for a state at rest; bisection alone would reach rounding in as many.
const SEARCH: usize = 60;

impl View {
    /// The view of a component, or `None` where a variable is neither measured nor held.
    pub fn of(rig: &Rig, component: usize, readings: &mut Readings) -> Option<Self> {
        let this = &rig.components[component];
        let mut z = Vec::new();
        for (port, &node) in this.card.ports.iter().zip(&this.ports) {
            match (port.kind, &rig.nodes[node].kind) {
                (PortKind::Hydraulic, NodeKind::Held { parameter }) => z.push(Variable::Held(*parameter)),
                (PortKind::Hydraulic, _) => {
                    z.push(Variable::Pressure(readings.node(rig, node, Quantity::Pressure, 0)?));
                }
                (PortKind::Mechanical, _) => {
                    let position = readings.node(rig, node, Quantity::Position, 0)?;
                    let velocity = match readings.node(rig, node, Quantity::Velocity, 0) {
                        Some(measured) => measured,
                        None => readings.node(rig, node, Quantity::Position, 1)?,
                    };
                    z.extend([Variable::Motion(position), Variable::Motion(velocity)]);
                }
            }
        }
        // No residual knows when the record began, nor how warm the fluid is.
        let unknown = this.card.sees_time || (this.card.sees_viscosity && rig.viscosity_varies());
        // The search below is for one state that falls to where it rests.
        let unsettled = this.card.own.is_some_and(|own| !own.settles);
        let states = 0..this.card.states.len();
        let states: Vec<Variable> = states
            .map(|state| readings.state(rig, component, state).map_or(Variable::Settled, Variable::Motion))
            .collect();
        let searched = states.iter().filter(|state| **state == Variable::Settled).count();
        if searched > 1 || unknown || (unsettled && searched > 0) {
            return None;
        }
        z.extend(states);
        z.resize(VARIABLES, Variable::Unused);
        let mut u = [None; INPUTS];
        for (slot, &input) in u.iter_mut().zip(&this.inputs) {
            *slot = Some(readings.take(Source::Input(input), 0));
        }
        Some(Self { component, z: z.try_into().ok()?, u })
    }

    /// Gauge pressure at the variable with this index, Pa.
    pub fn pressure<T: Real>(&self, variable: usize, p: &Parameters<T>, x: &[T]) -> T {
        match self.z[variable] {
            Variable::Pressure(reading) | Variable::Motion(reading) => x[reading],
            Variable::Held(parameter) => p.values[parameter],
            Variable::Unused | Variable::Settled => T::zero(),
        }
    }

    /// Index of the reading behind a variable.
    pub fn reading(&self, variable: usize) -> Option<usize> {
        match self.z[variable] {
            Variable::Pressure(reading) | Variable::Motion(reading) => Some(reading),
            _ => None,
        }
    }

    /// The command that drives the component.
    pub fn command<T: Real>(&self, x: &[T]) -> T {
        self.u[0].map_or(T::zero(), |reading| x[reading])
    }

    /// A parameter of the component by its place in the card, SI.
    pub fn parameter<T: Real>(&self, rig: &Rig, index: usize, p: &Parameters<T>) -> T {
        p.values[rig.components[self.component].first_parameter + index]
    }

    /// What the law answers at the readings `x` with the rig's parameters `p`, all SI.
    pub fn answers<T: Real>(&self, p: &Parameters<T>, x: &[T]) -> PortFlows<T> {
        let mut answers = PortFlows::default();
        let Some(laws) = p.laws.get(self.component).and_then(Option::as_ref) else { return answers };
        let mut seen = PortVariables::default();
        let mut settled = None;
        for (index, variable) in self.z.iter().enumerate() {
            seen.z[index] = match *variable {
                Variable::Pressure(_) | Variable::Held(_) => self.pressure(index, p, x) + ATMOSPHERE,
                Variable::Motion(reading) => x[reading],
                Variable::Unused => T::zero(),
                Variable::Settled => {
                    settled = Some(index);
                    T::zero()
                }
            };
        }
        for (value, reading) in seen.u.iter_mut().zip(self.u) {
            *value = reading.map_or(T::zero(), |reading| x[reading]);
        }
        if let Some(index) = settled {
            seen.z[index] = settle(laws, &seen, index);
        }
        laws.own.evaluate(&seen, &mut answers);
        answers
    }
}

/// The value of the state at which its rate is zero, with the derivatives that follow from it implicitly.
fn settle<T: Real>(laws: &Laws<T>, seen: &PortVariables<T>, index: usize) -> T {
    // The search needs no derivatives but the one by the state.
    let plain = PortVariables {
        z: seen.z.map(|value| value.re()),
        u: seen.u.map(|value| value.re()),
        ..PortVariables::default()
    };
    let state = search(&Rate::of(&laws.plain, &plain, index));
    // Two steps more carry first and second derivatives of everything else into the state.
    let rate = Rate::of(&laws.lifted, seen, index);
    rate.newton(rate.newton(T::constant(state)))
}

/// Rate of a component's state over the state, everything else given.
struct Rate<'a, N> {
    law: &'a AnyLaw<Dual<N, 1>>,
    seen: PortVariables<Dual<N, 1>>,
    index: usize,
}

impl<'a, N: Real> Rate<'a, N> {
    fn of(law: &'a AnyLaw<Dual<N, 1>>, seen: &PortVariables<N>, index: usize) -> Self {
        let seen = PortVariables { z: seen.z.map(Dual::lift), u: seen.u.map(Dual::lift), ..PortVariables::default() };
        Self { law, seen, index }
    }

    /// Rate and its slope.
    fn at(&self, state: N) -> (N, N) {
        let mut seen = self.seen;
        seen.z[self.index] = Dual::variable(state, 0);
        let mut answers = PortFlows::default();
        self.law.evaluate(&seen, &mut answers);
        (answers.rate[0].re, answers.rate[0].eps[0])
    }

    fn newton(&self, state: N) -> N {
        let (value, slope) = self.at(state);
        if slope.re() == 0.0 { state } else { state - value / slope }
    }
}

/// The zero of a rate.
fn search(rate: &Rate<'_, f64>) -> f64 {
    // The rates fall with their state, so a sign tells the side; Newton alone may hop between an end and the slope.
    let (mut low, mut high) = (f64::NEG_INFINITY, f64::INFINITY);
    let mut state = 0.0;
    for _ in 0..SEARCH {
        let (value, slope) = rate.at(state);
        if value >= 0.0 {
            low = state;
        }
        if value <= 0.0 {
            high = state;
        }
        let next = if slope == 0.0 { state } else { state - value / slope };
        if !next.is_finite() || (next - state).abs() <= 1e-14 * state.abs() {
            break;
        }
        state = if next <= low || next >= high { f64::midpoint(low, high) } else { next };
    }
    state
}
