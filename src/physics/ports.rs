//! What a component sees at its ports and answers there, and the law between the two.

use super::fluid::Fluid;
use crate::numeric::Real;

/// The largest number of port variables and states that one component may have.
pub const VARIABLES: usize = 7;
/// The largest number of ports.
pub const PORTS: usize = 4;
/// The largest number of states of one component.
pub const STATES: usize = 2;
/// The largest number of inputs of one component, the time among them.
pub const INPUTS: usize = 2;

/// What a component sees: port variables in the order of its card, then its states; its inputs; and how easily the fluid flows,
/// as [`Fluid::fluidity`] says.
#[derive(Debug, Clone, Copy)]
pub struct PortVariables<T> {
    pub z: [T; VARIABLES],
    pub u: [T; INPUTS],
    pub fluidity: T,
}

impl<T: Real> Default for PortVariables<T> {
    /// Zeros, and the fluid as it is at its temperature of reference.
    fn default() -> Self {
        Self { z: [T::zero(); VARIABLES], u: [T::zero(); INPUTS], fluidity: T::one() }
    }
}

/// What a component answers.
#[derive(Debug, Clone, Copy)]
pub struct PortFlows<T> {
    /// Per port: flow into it (m³/s), or force on the body (N).
    pub through: [T; PORTS],
    /// Per port: what the component adds to the node's capacity, m³/Pa or kg.
    pub capacity: [T; PORTS],
    /// Per state: its rate, per second.
    pub rate: [T; STATES],
}

impl<T: Real> Default for PortFlows<T> {
    fn default() -> Self {
        let zero = T::zero();
        Self { through: [zero; PORTS], capacity: [zero; PORTS], rate: [zero; STATES] }
    }
}

/// The law of a component for one number type.
pub trait Law<T: Real>: Sized {
    /// From the parameters in the order of the card, SI.
    fn new(parameters: &[T], fluid: &Fluid<T>) -> Self;

    /// Answers to what is seen. Called in the innermost loop: no allocation, no branching on time. What a law does not
    /// answer arrives as zero and must be left so at every call: the entries are not cleared in between.
    fn evaluate(&self, seen: &PortVariables<T>, answers: &mut PortFlows<T>);
}
