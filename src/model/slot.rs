//! A component's place among the states, the held pressures, the inputs and the balances.

use crate::physics::ports::{INPUTS, PORTS, VARIABLES};

/// Where a component's variable comes from.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Variable {
    Unused,
    State(usize),
    /// Pressure of a held node, by its index among the parameters.
    Held(usize),
}

/// A component's place in the equations.
#[derive(Debug, Clone, Copy)]
pub struct Slot {
    pub variables: [Variable; VARIABLES],
    pub inputs: [Option<usize>; INPUTS],
    /// Balance that each port takes part in; `None` at a held node.
    pub balances: [Option<usize>; PORTS],
    pub ports: usize,
    pub first_state: usize,
    pub states: usize,
}

impl Slot {
    /// States that the component sees, its own included.
    pub fn states_seen(&self) -> impl Iterator<Item = usize> + '_ {
        self.variables.iter().filter_map(|variable| match variable {
            Variable::State(state) => Some(*state),
            Variable::Unused | Variable::Held(_) => None,
        })
    }
}
