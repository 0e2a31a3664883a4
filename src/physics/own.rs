//! What a component is made of that a rig file or the catalogue writes as formulas.

use super::component::facts::Facts;
use crate::expression::{Expression, Schedule};

/// Most parameters of one component.
pub const MOST_PARAMETERS: usize = 20;
/// Most values that the formulas of one component see together, quantities between them included.
pub const MOST_VALUES: usize = 64;
/// Numbers, names and operators of all formulas of one component together: a law of this size takes about as long as all laws of
/// the telescopic rig together.
pub const MOST_SIZE: usize = 2000;

/// Oil that passes from one port to another.
#[derive(Debug)]
pub struct Flow {
    /// Index of the port that it leaves the node of.
    pub from: usize,
    pub to: usize,
    /// m³/s.
    pub formula: Expression,
}

/// A surface through which the pressure at one port acts on the body at another. What the body gives way, oil follows.
#[derive(Debug)]
pub struct Piston {
    pub port: usize,
    pub body: usize,
    /// Index of the speed of the body among the variables of the ports.
    pub speed: usize,
    /// m²; positive where pressure pushes in the direction of the position.
    pub area: Expression,
}

/// What a component is made of. All formulas are over the same values: parameters, density of the fluid, [`fixed`](Self::fixed)
/// quantities, variables of the ports, states, inputs (the time among them), viscosity, [`moving`](Self::moving) quantities; SI,
/// pressures gauge.
#[derive(Debug)]
pub struct Own {
    pub facts: Facts,
    /// Whether all states are lags, which come to rest while nothing else moves.
    pub settles: bool,
    /// Quantities that parameters and density alone determine, in the order in which they build on each other.
    pub fixed: Vec<Expression>,
    /// Quantities that change.
    pub moving: Vec<Expression>,
    pub flows: Vec<Flow>,
    /// Port and force on its body, N.
    pub forces: Vec<(usize, Expression)>,
    pub pistons: Vec<Piston>,
    /// Port and volume of the oil there, m³.
    pub volumes: Vec<(usize, Expression)>,
    /// Port and mass that moves with its body, kg.
    pub masses: Vec<(usize, Expression)>,
    /// Of each state.
    pub rates: Vec<Expression>,
    /// [`Self::scheduled`], made once.
    pub schedule: Schedule,
}

impl Own {
    /// All formulas as one line of steps for components with so many parameters, and so many variables, states, inputs and viscosity
    /// together; its answers are those at the ports and of the states.
    pub fn scheduled(&self, parameters: usize, variables: usize) -> Schedule {
        let answers = self.formulas().skip(self.fixed.len() + self.moving.len());
        // Behind the parameters comes the density.
        Schedule::new((parameters + 1, &self.fixed), (variables, &self.moving), answers)
    }

    /// Whether a hydraulic port takes oil: by a flow, behind a piston, or to store it.
    pub fn passes(&self, port: usize) -> bool {
        self.flows.iter().any(|flow| flow.from == port || flow.to == port)
            || self.pistons.iter().any(|piston| piston.port == port)
            || self.volumes.iter().any(|(at, _)| *at == port)
    }

    /// Every formula, in the order of the fields.
    pub fn formulas(&self) -> impl Iterator<Item = &Expression> {
        let flows = self.flows.iter().map(|flow| &flow.formula);
        let areas = self.pistons.iter().map(|piston| &piston.area);
        let at_ports = self.forces.iter().map(|(_, formula)| formula);
        let stored = self.volumes.iter().chain(&self.masses).map(|(_, formula)| formula);
        self.fixed.iter().chain(&self.moving).chain(flows).chain(at_ports).chain(areas).chain(stored).chain(&self.rates)
    }
}
