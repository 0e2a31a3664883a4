//! Derivatives of a circuit's equations by its states and parameters, as sensitivities need them.

use std::sync::Arc;

use super::assembly::{Inputs, level_per_pressure};
use super::layout::{Balance, Layout, Raw};
use super::slot::Variable;
use crate::numeric::{Curved, Dual, Elimination, Entry, Real};
use crate::physics::ATMOSPHERE;
use crate::physics::component::AnyLaw;
use crate::physics::fluid::{self, Fluid};
use crate::physics::ports::{PortFlows, PortVariables, VARIABLES};
use crate::rig::Rig;

/// Variables and parameters by which a component is derived at once.
pub const LANES: usize = 8;

/// A number with its derivatives by variables and parameters of one component.
pub type First = Dual<f64, LANES>;

/// What a lane of a component stands for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Lane {
    State(usize),
    /// By its place among those asked for.
    Parameter(usize),
}

/// A component, derived by as many variables and parameters as there are lanes.
#[derive(Debug, Clone)]
struct Pass {
    component: usize,
    /// Whether it is the one that counts where values are summed: further ones hold further parameters.
    first: bool,
    fluid: Fluid<First>,
    law: AnyLaw<First>,
    lanes: Vec<Lane>,
    /// Lane of each variable.
    of_variable: [Option<usize>; VARIABLES],
    answers: PortFlows<First>,
}

/// Sums over the components at a balance, at one point.
#[derive(Debug, Clone, Copy, Default)]
struct Sum {
    through: f64,
    capacity: f64,
}

impl Sum {
    fn rate(&self, balance: Balance) -> f64 {
        self.through * balance.sign / self.capacity
    }
}

/// The equations of one rig around one set of parameters.
#[derive(Debug, Clone)]
pub struct Slopes<'a> {
    layout: &'a Layout,
    passes: Vec<Pass>,
    held: Vec<f64>,
    /// Level per pressure, m/Pa, and by which of the parameters asked for it changes how much.
    level_per_pressure: f64,
    by_density: Option<(usize, f64)>,
    /// Which of the parameters asked for each of the rig's is.
    columns: Vec<Option<usize>>,
    pub inputs: Inputs,
}

/// All parameters of the rig, each of `lanes` a variable.
pub fn seeded(parameters: &[f64], lanes: &[usize]) -> Vec<First> {
    let mut seeded: Vec<First> = parameters.iter().map(|&value| First::constant(value)).collect();
    for (lane, &parameter) in lanes.iter().enumerate().take(LANES) {
        seeded[parameter].eps[lane] = 1.0;
    }
    seeded
}

impl<'a> Slopes<'a> {
    /// Around `parameters` (all of the rig's, SI), by those whose entry in `columns` says which of the parameters asked for
    /// they are.
    pub fn new(rig: &Rig, layout: &'a Layout, parameters: &[f64], columns: Vec<Option<usize>>) -> Self {
        let mut passes = Vec::new();
        for component in 0..rig.components.len() {
            passes_of(rig, layout, parameters, &columns, component, &mut passes);
        }
        let level = level_per_pressure(First::variable(parameters[0], 0));
        Self {
            layout,
            passes,
            held: parameters.iter().map(|&value| value + ATMOSPHERE).collect(),
            level_per_pressure: level.re,
            by_density: columns[0].map(|column| (column, level.eps[0])),
            columns,
            inputs: Inputs::default(),
        }
    }

    fn evaluate(&mut self, t: f64, y: &[f64], wanted: impl Fn(usize) -> bool) {
        for pass in self.passes.iter_mut().filter(|pass| wanted(pass.component)) {
            let slot = &self.layout.slots[pass.component];
            let fluidity = self.inputs.fluidity(&pass.fluid, self.layout, t);
            let mut seen = PortVariables { fluidity, ..PortVariables::default() };
            for (index, variable) in slot.variables.iter().enumerate() {
                seen.z[index] = pass.variable(index, *variable, y, &self.held);
            }
            for (value, input) in seen.u.iter_mut().zip(slot.inputs) {
                *value = input.map_or(First::zero(), |input| First::constant(self.inputs.at(input, t)));
            }
            pass.law.evaluate(&seen, &mut pass.answers);
        }
    }

    /// Adds what a raw reading changes by per parameter: `states` holds the derivatives of the states, each by all
    /// parameters.
    pub fn raw(&mut self, sensor: usize, t: f64, y: &[f64], states: &[Vec<f64>], out: &mut [f64]) {
        let mut add = |factor: f64, state: usize| {
            out.iter_mut().zip(&states[state]).for_each(|(out, value)| *out += factor * value);
        };
        match (self.layout.filtered[sensor], self.layout.raw[sensor]) {
            (Some(state), _) | (None, Raw::Pressure(state) | Raw::State(state)) => add(1.0, state),
            (None, Raw::HeldPressure(parameter)) => {
                if let Some(column) = self.columns[parameter] {
                    out[column] += 1.0;
                }
            }
            (None, Raw::Level(state)) => {
                add(self.level_per_pressure, state);
                if let Some((column, slope)) = self.by_density {
                    out[column] += slope * (y[state] - ATMOSPHERE);
                }
            }
            (None, Raw::Through(sign)) => {
                let flows = &self.layout.flows[sensor];
                self.evaluate(t, y, |one| flows.iter().any(|(component, _)| *component == one));
                for (pass, port) in metered(flows, &self.passes) {
                    for (lane, value) in pass.lanes.iter().zip(&pass.answers.through[port].eps) {
                        match lane {
                            Lane::State(state) => {
                                out.iter_mut()
                                    .zip(&states[*state])
                                    .for_each(|(out, slope)| *out += sign * value * slope);
                            }
                            Lane::Parameter(column) => out[*column] += sign * value,
                        }
                    }
                }
            }
        }
    }
}

/// The passes over the components whose flows a meter reads, each with the port that it reads there.
fn metered<'a>(flows: &'a [(usize, usize)], passes: &'a [Pass]) -> impl Iterator<Item = (&'a Pass, usize)> {
    flows.iter().flat_map(move |&(component, port)| {
        passes.iter().filter(move |pass| pass.component == component).map(move |pass| (pass, port))
    })
}

/// Derives a component by its variables and by every parameter asked for that can reach it.
fn passes_of(
    rig: &Rig,
    layout: &Layout,
    parameters: &[f64],
    columns: &[Option<usize>],
    component: usize,
    passes: &mut Vec<Pass>,
) {
    let own = &rig.components[component];
    let slot = &layout.slots[component];
    let of_fluid = 0..fluid::CARD.parameters.len();
    let held = slot.variables.iter().filter_map(|variable| match variable {
        Variable::Held(parameter) => Some(*parameter),
        _ => None,
    });
    let mut reach: Vec<usize> = of_fluid
        .clone()
        .chain(own.parameters())
        .chain(held)
        .filter(|&parameter| columns[parameter].is_some())
        .collect();
    reach.sort_unstable();
    reach.dedup();
    let states = slot.variables.iter().filter(|variable| matches!(variable, Variable::State(_))).count();
    let mut rest = reach.as_slice();
    let mut first = true;
    while first || !rest.is_empty() {
        let states = if first { states } else { 0 };
        let (now, later) = rest.split_at(rest.len().min(LANES - states));
        rest = later;
        let mut lanes = Vec::new();
        let mut of_variable = [None; VARIABLES];
        for (index, variable) in slot.variables.iter().enumerate() {
            if let (true, Variable::State(state)) = (first, variable) {
                of_variable[index] = Some(lanes.len());
                lanes.push(Lane::State(*state));
            }
        }
        let lane_of = |parameter: usize| now.iter().position(|one| *one == parameter).map(|at| states + at);
        for (index, variable) in slot.variables.iter().enumerate() {
            if let Variable::Held(parameter) = variable {
                of_variable[index] = lane_of(*parameter);
            }
        }
        lanes.extend(now.iter().filter_map(|&parameter| columns[parameter]).map(Lane::Parameter));
        let seed = |parameter: usize| -> First {
            let mut value = First::constant(parameters[parameter]);
            if let Some(lane) = lane_of(parameter) {
                value.eps[lane] = 1.0;
            }
            value
        };
        let fluid: Vec<First> = of_fluid.clone().map(seed).collect();
        let fluid = Fluid::new(&fluid);
        if let Some(law) = own.law(seed, &fluid) {
            passes.push(Pass { component, first, fluid, law, lanes, of_variable, answers: PortFlows::default() });
        }
        first = false;
    }
}

impl Pass {
    #[inline]
    fn variable(&self, index: usize, variable: Variable, y: &[f64], held: &[f64]) -> First {
        let value = match variable {
            Variable::Unused => 0.0,
            Variable::State(state) => y[state],
            Variable::Held(parameter) => held[parameter],
        };
        match self.of_variable[index] {
            Some(lane) => First::variable(value, lane),
            None => First::constant(value),
        }
    }

    /// Hands each lane's entry of a row to the matrix or to the parameters.
    #[inline]
    fn give<const N: usize>(
        &self,
        row: usize,
        j: &mut [[f64; N]; N],
        by: &mut Vec<Entry>,
        entry: impl Fn(usize) -> f64,
    ) {
        for (lane, of) in self.lanes.iter().enumerate() {
            let value = entry(lane);
            match of {
                Lane::State(column) => j[row][*column] += value,
                Lane::Parameter(parameter) if value != 0.0 => by.push(Entry { row, parameter: *parameter, value }),
                Lane::Parameter(_) => {}
            }
        }
    }
}

impl<const N: usize> Curved<N> for Slopes<'_> {
    fn states(&self) -> usize {
        self.layout.states
    }

    fn elimination(&self) -> Option<&Arc<Elimination>> {
        self.layout.elimination.as_ref()
    }

    fn slopes(&mut self, t: f64, y: &[f64; N], j: &mut [[f64; N]; N], by: &mut Vec<Entry>) {
        self.evaluate(t, y, |_| true);
        let mut sums = [Sum::default(); N];
        for pass in self.passes.iter().filter(|pass| pass.first) {
            let slot = &self.layout.slots[pass.component];
            for (port, balance) in slot.balances.iter().enumerate().take(slot.ports) {
                let Some(balance) = *balance else { continue };
                sums[balance].through += pass.answers.through[port].re;
                sums[balance].capacity += pass.answers.capacity[port].re;
            }
        }
        for pass in &self.passes {
            let slot = &self.layout.slots[pass.component];
            for (port, index) in slot.balances.iter().enumerate().take(slot.ports) {
                let Some(index) = *index else { continue };
                let (balance, sum) = (self.layout.balances[index], &sums[index]);
                let (through, capacity) = (&pass.answers.through[port], &pass.answers.capacity[port]);
                let (rate, per_capacity) = (sum.rate(balance), 1.0 / sum.capacity);
                pass.give(balance.state, j, by, |lane| {
                    (through.eps[lane] * balance.sign - rate * capacity.eps[lane]) * per_capacity
                });
            }
            for state in 0..slot.states {
                pass.give(slot.first_state + state, j, by, |lane| pass.answers.rate[state].eps[lane]);
            }
        }
        for &(position, velocity) in &self.layout.bodies {
            j[position][velocity] = 1.0;
        }
        for filter in &self.layout.filters {
            let (row, per_lag) = (filter.state, 1.0 / filter.lag);
            match self.layout.raw[filter.sensor] {
                Raw::Pressure(state) | Raw::State(state) => j[row][state] += per_lag,
                Raw::HeldPressure(parameter) => {
                    let column = self.columns[parameter];
                    by.extend(column.map(|parameter| Entry { row, parameter, value: per_lag }));
                }
                Raw::Level(state) => {
                    j[row][state] += self.level_per_pressure * per_lag;
                    let level = |(parameter, slope): (usize, f64)| Entry {
                        row,
                        parameter,
                        value: slope * (y[state] - ATMOSPHERE) * per_lag,
                    };
                    by.extend(self.by_density.map(level));
                }
                Raw::Through(sign) => {
                    for (pass, port) in metered(&self.layout.flows[filter.sensor], &self.passes) {
                        pass.give(row, j, by, |lane| pass.answers.through[port].eps[lane] * (sign * per_lag));
                    }
                }
            }
            j[row][row] -= per_lag;
        }
    }
}
