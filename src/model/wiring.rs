//! The layout as indices into one row of numbers, so that the innermost loop asks nothing.

use super::slot::{Slot, Variable};
use crate::physics::ports::{INPUTS, VARIABLES};

/// Where a component's values stand in the row: its variables, then its inputs.
#[derive(Debug, Clone, Copy)]
pub struct Sources {
    pub variables: [u16; VARIABLES],
    pub inputs: [u16; INPUTS],
    /// How many of the variables it has, from the first on.
    pub used: usize,
    /// How many inputs it has.
    pub driven: usize,
}

/// An answer of a component that a sum or a state takes.
#[derive(Debug, Clone, Copy)]
pub struct Link {
    pub component: u16,
    /// Port or own state of the component.
    pub from: u16,
    /// Index of the balance or of the state.
    pub to: u16,
}

/// The row holds the states, the pressures of held nodes, the inputs, and a zero for what a component does not have.
#[derive(Debug, Clone, Default)]
pub struct Wiring {
    /// One per component.
    pub sources: Vec<Sources>,
    /// Index among the parameters of each held pressure.
    pub held: Vec<usize>,
    /// Where the inputs begin in the row.
    pub first_input: usize,
    /// Length of the row.
    pub length: usize,
    /// Ports that take part in a balance.
    pub flows: Vec<Link>,
    /// Rates of the components' own states.
    pub rates: Vec<Link>,
}

impl Wiring {
    /// Of components in their places, with so many states; the clock is the last of the inputs.
    pub fn of(slots: &[Slot], states: usize, clock: usize) -> Self {
        let mut held: Vec<usize> = slots.iter().flat_map(|slot| slot.variables).filter_map(parameter).collect();
        held.sort_unstable();
        held.dedup();
        let first_input = states + held.len();
        let zero = first_input + clock + 1;
        let variable = |variable: Variable| match variable {
            Variable::Unused => zero,
            Variable::State(state) => state,
            Variable::Held(parameter) => states + held.partition_point(|&other| other < parameter),
        };
        let sources = |slot: &Slot| Sources {
            variables: slot.variables.map(|one| variable(one) as u16),
            inputs: slot.inputs.map(|input| input.map_or(zero, |input| first_input + input) as u16),
            used: slot.variables.iter().take_while(|variable| **variable != Variable::Unused).count(),
            driven: slot.inputs.iter().take_while(|input| input.is_some()).count(),
        };
        let sources = slots.iter().map(sources).collect();
        let (mut flows, mut rates) = (Vec::new(), Vec::new());
        for (component, slot) in slots.iter().enumerate() {
            let link = |from: usize, to: usize| Link { component: component as u16, from: from as u16, to: to as u16 };
            let balances = slot.balances.iter().take(slot.ports).enumerate();
            flows.extend(balances.filter_map(|(port, balance)| Some(link(port, (*balance)?))));
            rates.extend((0..slot.states).map(|state| link(state, slot.first_state + state)));
        }
        Self { sources, held, first_input, length: zero + 1, flows, rates }
    }
}

fn parameter(variable: Variable) -> Option<usize> {
    match variable {
        Variable::Held(parameter) => Some(parameter),
        Variable::Unused | Variable::State(_) => None,
    }
}
