//! The equations of a circuit over one number type, as the integrator sees them.

use std::sync::Arc;

use super::layout::{Layout, Raw};
use super::piece::Piece;
use super::slot::Variable;
use super::wiring::{Sources, Wiring};
use crate::numeric::{Dual, Elimination, Real, Scalar, States, System};
use crate::physics::component::AnyLaw;
use crate::physics::fluid::{self, Fluid};
use crate::physics::ports::{PortFlows, PortVariables, VARIABLES};
use crate::physics::{ATMOSPHERE, GRAVITY};
use crate::rig::Rig;

/// Directions of a component's own derivatives: its variables, and time through its inputs.
pub const LOCAL: usize = VARIABLES + 1;
pub const TIME: usize = VARIABLES;

/// Component-local derivatives of a scalar.
pub type Local<S> = Dual<S, LOCAL>;

/// Inputs that run straight from `from` at `start`, with `slope` per second.
#[derive(Debug, Clone, Default)]
pub struct Inputs {
    pub start: f64,
    pub from: Vec<f64>,
    pub slope: Vec<f64>,
}

impl Inputs {
    /// Those of a piece of a run that began at `begun`, s; the last is the time since then.
    pub fn of(piece: &Piece, begun: f64) -> Self {
        let slope = |(from, to): (&f64, &f64)| (to - from) / (piece.end - piece.start);
        let slope = piece.from.iter().zip(&piece.to).map(slope).chain([1.0]).collect();
        let from = piece.from.iter().copied().chain([piece.start - begun]).collect();
        Self { start: piece.start, from, slope }
    }

    /// How easily a fluid flows at `t` for its temperature and its age, with the derivatives of its parameters.
    pub fn fluidity<T: Real>(&self, fluid: &Fluid<T>, layout: &Layout, t: f64) -> T {
        let warmer = layout.temperature.map_or(0.0, |input| self.at(input, t));
        fluid.fluidity(T::constant(warmer), T::constant(self.at(layout.clock, t)))
    }

    #[inline]
    pub fn at(&self, input: usize, t: f64) -> f64 {
        self.from[input] + self.slope[input] * (t - self.start)
    }
}

/// Level per pressure, m/Pa, of a fluid of this density, kg/m³.
pub fn level_per_pressure<S: Real>(density: S) -> S {
    S::one() / (density * GRAVITY)
}

/// What a component sees: each of its variables that is a state has a direction of its own.
fn seen_at_first<S: Scalar>(sources: &Sources, states: usize) -> PortVariables<Local<S>> {
    let mut seen: PortVariables<Local<S>> = PortVariables::default();
    for (direction, (value, &index)) in seen.z.iter_mut().zip(&sources.variables).enumerate().take(sources.used) {
        if usize::from(index) < states {
            value.eps[direction] = S::one();
        }
    }
    seen
}

/// The equations of one rig for one set of parameters.
pub struct Assembly<'a, S> {
    layout: &'a Layout,
    wiring: &'a Wiring,
    /// What components may see, as [`Wiring`] orders it.
    row: Vec<S>,
    fluid: Fluid<S>,
    laws: Vec<AnyLaw<S>>,
    local_laws: Vec<AnyLaw<Local<S>>>,
    held: Vec<S>,
    /// Level per pressure, m/Pa.
    level_per_pressure: S,
    /// What each component sees; values are written over.
    seen: Vec<PortVariables<S>>,
    answers: Vec<PortFlows<S>>,
    /// What each component sees with its own derivatives, which never change.
    seen_locally: Vec<PortVariables<Local<S>>>,
    local: Vec<PortFlows<Local<S>>>,
    pub inputs: Inputs,
}

impl<'a, S: Scalar> Assembly<'a, S> {
    /// `parameters` are all of the rig's, SI.
    pub fn new(rig: &Rig, layout: &'a Layout, parameters: &[S]) -> Self {
        fn build<T: Real>(rig: &Rig, parameters: &[T]) -> Vec<AnyLaw<T>> {
            let fluid = Fluid::new(&parameters[..fluid::CARD.parameters.len()]);
            rig.components.iter().filter_map(|component| component.law(|index| parameters[index], &fluid)).collect()
        }
        let lifted: Vec<Local<S>> = parameters.iter().map(|&value| Local::lift(value)).collect();
        let of_fluid = fluid::CARD.parameters.len();
        let held: Vec<S> = parameters.iter().map(|&value| value + ATMOSPHERE).collect();
        let wiring = &layout.wiring;
        let mut row = vec![S::zero(); wiring.length];
        for (value, &parameter) in row[layout.states..].iter_mut().zip(&wiring.held) {
            *value = held[parameter];
        }
        Self {
            layout,
            wiring,
            row,
            fluid: Fluid::new(&parameters[..of_fluid]),
            laws: build(rig, parameters),
            local_laws: build(rig, &lifted),
            held,
            level_per_pressure: level_per_pressure(parameters[0]),
            seen: vec![PortVariables::default(); rig.components.len()],
            answers: vec![PortFlows::default(); rig.components.len()],
            seen_locally: wiring.sources.iter().map(|sources| seen_at_first(sources, layout.states)).collect(),
            local: vec![PortFlows::default(); rig.components.len()],
            inputs: Inputs::default(),
        }
    }

    /// Evaluates a component at the gathered row.
    #[inline]
    fn answer(&mut self, component: usize, fluidity: S) {
        let (sources, seen) = (&self.wiring.sources[component], &mut self.seen[component]);
        for (value, &index) in seen.z.iter_mut().zip(&sources.variables).take(sources.used) {
            *value = self.row[usize::from(index)];
        }
        for (value, &index) in seen.u.iter_mut().zip(&sources.inputs).take(sources.driven) {
            *value = self.row[usize::from(index)];
        }
        seen.fluidity = fluidity;
        // A law answers the same entries every time, so what it leaves stays zero from the start.
        self.laws[component].evaluate(seen, &mut self.answers[component]);
    }

    /// Evaluates a component with its own derivatives at the gathered row.
    #[inline]
    fn answer_locally(&mut self, component: usize, fluidity: Local<S>) {
        let (sources, seen) = (&self.wiring.sources[component], &mut self.seen_locally[component]);
        for (value, &index) in seen.z.iter_mut().zip(&sources.variables).take(sources.used) {
            value.re = self.row[usize::from(index)];
        }
        for (value, &index) in seen.u.iter_mut().zip(&sources.inputs).take(sources.driven) {
            let index = usize::from(index);
            value.re = self.row[index];
            value.eps[TIME] = S::constant(self.inputs.slope[index - self.wiring.first_input]);
        }
        seen.fluidity = fluidity;
        self.local_laws[component].evaluate(seen, &mut self.local[component]);
    }

    fn fluidity(&self, t: f64) -> S {
        self.inputs.fluidity(&self.fluid, self.layout, t)
    }

    /// With its slope over time.
    fn fluidity_locally(&self, t: f64) -> Local<S> {
        let mut fluidity = Local::lift(self.fluidity(t));
        let warming = self.layout.temperature.map_or(0.0, |input| self.inputs.slope[input]);
        fluidity.eps[TIME] = fluidity.re * self.fluid.thinning(warming);
        fluidity
    }

    /// Fills the row that components read.
    #[inline]
    fn gather(&mut self, t: f64, y: &[S]) {
        let states = self.layout.states;
        self.row[..states].copy_from_slice(&y[..states]);
        let count = self.inputs.from.len();
        for (input, value) in self.row[self.wiring.first_input..].iter_mut().take(count).enumerate() {
            *value = S::constant(self.inputs.at(input, t));
        }
    }

    fn evaluate(&mut self, t: f64, y: &[S]) {
        let fluidity = self.fluidity(t);
        self.gather(t, y);
        (0..self.laws.len()).for_each(|component| self.answer(component, fluidity));
    }

    /// The same for the components of which sensors without a lag read a flow.
    fn evaluate_shown(&mut self, t: f64, y: &[S]) {
        let fluidity = self.fluidity(t);
        self.gather(t, y);
        for &component in &self.layout.shown {
            self.answer(component, fluidity);
        }
    }

    fn evaluate_locally(&mut self, t: f64, y: &[S]) {
        let fluidity = self.fluidity_locally(t);
        self.gather(t, y);
        (0..self.local_laws.len()).for_each(|component| self.answer_locally(component, fluidity));
    }

    /// Sum of through and of capacity at a balance.
    #[inline]
    fn sums(&self, index: usize, through: impl Fn(usize, usize) -> (S, S)) -> (S, S) {
        let (mut flow, mut capacity) = (S::zero(), S::zero());
        for (component, slot) in self.layout.slots.iter().enumerate() {
            for port in 0..slot.ports {
                if slot.balances[port] == Some(index) {
                    let (q, c) = through(component, port);
                    flow += q;
                    capacity += c;
                }
            }
        }
        (flow, capacity)
    }

    /// Net force in N on the body with this velocity state.
    pub fn force(&mut self, velocity: usize, t: f64, y: &[S]) -> S {
        self.evaluate(t, y);
        let index = self.layout.balances.iter().position(|balance| balance.state == velocity).unwrap_or(0);
        self.sums(index, |component, port| {
            (self.answers[component].through[port], self.answers[component].capacity[port])
        })
        .0
    }

    /// Rate of a component's state and its slope by that state, for the search of a state that rests.
    pub fn own_rate(&mut self, component: usize, state: usize, t: f64, y: &[S]) -> (S, S) {
        let (slot, fluidity) = (&self.layout.slots[component], self.fluidity_locally(t));
        self.gather(t, y);
        self.answer_locally(component, fluidity);
        let rate = self.local[component].rate[state];
        let own = slot.variables.iter().position(|v| *v == Variable::State(slot.first_state + state)).unwrap_or(0);
        (rate.re, rate.eps[own])
    }

    /// The raw value of a sensor, SI, from the answers of the last evaluation.
    #[inline]
    fn raw(&self, sensor: usize, y: &[S]) -> S {
        match self.layout.raw[sensor] {
            Raw::Pressure(state) => y[state] - ATMOSPHERE,
            Raw::HeldPressure(parameter) => self.held[parameter] - ATMOSPHERE,
            Raw::Level(state) => (y[state] - ATMOSPHERE) * self.level_per_pressure,
            Raw::State(state) => y[state],
            Raw::Through(sign) => {
                let flows = self.layout.flows[sensor].iter();
                flows.fold(S::zero(), |sum, &(component, port)| sum + self.answers[component].through[port]) * sign
            }
        }
    }

    /// Raw values of the sensors at `t`, SI, into `raw`.
    pub fn raw_values(&mut self, t: f64, y: &[S], raw: &mut [S]) {
        if !self.layout.shown.is_empty() {
            self.evaluate_shown(t, y);
        }
        for (sensor, value) in raw.iter_mut().enumerate() {
            *value = match self.layout.filtered[sensor] {
                Some(state) => y[state],
                None => self.raw(sensor, y),
            };
        }
    }

    /// Sets the states of the sensors' lags to what they read at rest.
    pub fn settle_filters(&mut self, t: f64, y: &mut [S]) {
        self.evaluate(t, y);
        for filter in &self.layout.filters {
            y[filter.state] = self.raw(filter.sensor, y);
        }
    }
}

impl<S: Scalar, const N: usize> System<S, N> for Assembly<'_, S> {
    fn states(&self) -> States {
        // Sensors that lag come last, and nothing depends on what they read.
        States { all: self.layout.states, coupled: self.layout.states - self.layout.filters.len() }
    }

    fn elimination(&self) -> Option<&Arc<Elimination>> {
        self.layout.elimination.as_ref()
    }

    fn derivative(&mut self, t: f64, y: &[S; N], dydt: &mut [S; N]) {
        self.evaluate(t, y);
        let mut through = [S::zero(); N];
        let mut capacity = [S::zero(); N];
        for link in &self.wiring.flows {
            let (answers, port) = (&self.answers[usize::from(link.component)], usize::from(link.from));
            through[usize::from(link.to)] += answers.through[port];
            capacity[usize::from(link.to)] += answers.capacity[port];
        }
        for link in &self.wiring.rates {
            dydt[usize::from(link.to)] = self.answers[usize::from(link.component)].rate[usize::from(link.from)];
        }
        for (index, balance) in self.layout.balances.iter().enumerate() {
            dydt[balance.state] = through[index] * balance.sign / capacity[index];
        }
        for &(position, velocity) in &self.layout.bodies {
            dydt[position] = y[velocity];
        }
        for filter in &self.layout.filters {
            dydt[filter.state] = (self.raw(filter.sensor, y) - y[filter.state]) / filter.lag;
        }
        for rate in dydt.iter_mut().skip(self.layout.states) {
            *rate = S::zero();
        }
    }

    fn jacobian(&mut self, t: f64, y: &[S; N], j: &mut [[S; N]; N], dfdt: &mut [S; N]) {
        let mut dydt = [S::zero(); N];
        self.linearise(t, y, &mut dydt, j, dfdt);
    }

    fn linearise(&mut self, t: f64, y: &[S; N], dydt: &mut [S; N], j: &mut [[S; N]; N], dfdt: &mut [S; N]) {
        self.evaluate_locally(t, y);
        let mut through = [S::zero(); N];
        let mut capacity = [S::zero(); N];
        for (slot, answers) in self.layout.slots.iter().zip(&self.local) {
            for port in 0..slot.ports {
                if let Some(balance) = slot.balances[port] {
                    through[balance] += answers.through[port].re;
                    capacity[balance] += answers.capacity[port].re;
                }
            }
        }
        let mut per_capacity = [S::zero(); N];
        let mut rate = [S::zero(); N];
        for (index, balance) in self.layout.balances.iter().enumerate() {
            per_capacity[index] = S::one() / capacity[index];
            rate[index] = through[index] * balance.sign * per_capacity[index];
            dydt[balance.state] = rate[index];
        }
        for (slot, answers) in self.layout.slots.iter().zip(&self.local) {
            for port in 0..slot.ports {
                let Some(index) = slot.balances[port] else { continue };
                let balance = self.layout.balances[index];
                let (q, c) = (&answers.through[port], &answers.capacity[port]);
                let by = |direction: usize| {
                    (q.eps[direction] * balance.sign - rate[index] * c.eps[direction]) * per_capacity[index]
                };
                for (direction, variable) in slot.variables.iter().enumerate() {
                    if let Variable::State(column) = variable {
                        j[balance.state][*column] += by(direction);
                    }
                }
                dfdt[balance.state] += by(TIME);
            }
            for state in 0..slot.states {
                let row = slot.first_state + state;
                dydt[row] = answers.rate[state].re;
                for (direction, variable) in slot.variables.iter().enumerate() {
                    if let Variable::State(column) = variable {
                        j[row][*column] += answers.rate[state].eps[direction];
                    }
                }
                dfdt[row] += answers.rate[state].eps[TIME];
            }
        }
        for &(position, velocity) in &self.layout.bodies {
            dydt[position] = y[velocity];
            j[position][velocity] = S::one();
        }
        for filter in &self.layout.filters {
            let per_lag = 1.0 / filter.lag;
            let raw = match self.layout.raw[filter.sensor] {
                Raw::Through(sign) => {
                    let mut sum = S::zero();
                    for &(component, port) in &self.layout.flows[filter.sensor] {
                        let flow = &self.local[component].through[port];
                        let slot = &self.layout.slots[component];
                        for (direction, variable) in slot.variables.iter().enumerate() {
                            if let Variable::State(column) = variable {
                                j[filter.state][*column] += flow.eps[direction] * (sign * per_lag);
                            }
                        }
                        dfdt[filter.state] += flow.eps[TIME] * (sign * per_lag);
                        sum += flow.re;
                    }
                    sum * sign
                }
                Raw::Pressure(state) | Raw::State(state) => {
                    j[filter.state][state] += S::constant(per_lag);
                    self.raw(filter.sensor, y)
                }
                Raw::Level(state) => {
                    j[filter.state][state] += self.level_per_pressure * per_lag;
                    self.raw(filter.sensor, y)
                }
                Raw::HeldPressure(_) => self.raw(filter.sensor, y),
            };
            j[filter.state][filter.state] -= S::constant(per_lag);
            dydt[filter.state] = (raw - y[filter.state]) * per_lag;
        }
        for rate in dydt.iter_mut().skip(self.layout.states) {
            *rate = S::zero();
        }
    }
}
