//! From a rig to equations: assembly, simulation, sensitivities.
//!
//! Every node balances what its components answer: `C p' = -sum of flows into ports` for a volume,
//! `m v' = sum of forces` for a body. The states are the pressures of the volumes, position and velocity of the bodies,
//! the components' own states, and one per sensor with a lag.

mod assembly;
mod drive;
mod layout;
mod outcome;
mod piece;
mod readings;
mod recording;
mod reshaped;
mod rows;
mod run;
mod simulate;
mod slopes;
mod slot;
mod start;
mod stretch;
mod vacuum;
mod wiring;

pub(crate) use assembly::level_per_pressure;
pub use drive::{Before, InputSignals, Late, Onset};
pub use outcome::{Outputs, Sensitivities, SimulationError, SolverEffort, Tolerance};
pub use piece::Piece;
pub use readings::Shown;
pub use recording::{decimals_of, input_columns, recording};
pub(crate) use reshaped::Following;
pub use rows::cycle_times;
pub use run::{Reading, Simulation};
pub use simulate::Model;
pub(crate) use stretch::is_measured_to_jump;
pub use vacuum::BelowVacuum;
