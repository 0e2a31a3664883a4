//! Look inside a hydraulic circuit through its records.
//!
//! A rig file describes the circuit, a record holds what a logger wrote of pressures, flows and positions. The model simulates the
//! circuit; a diagnosis fits all faults together with everything else that is uncertain and says what is wrong, how large, and how
//! sure; a suggestion says which physics the model lacks:
//!
//! ```
//! use borescope::{Record, Rig};
//! # use borescope::{SimulationOptions, simulate};
//! # use std::path::PathBuf;
//! # let faulty = Rig::read("fixtures/two_tanks/rig.toml")?.model().with("upper_outlet.diameter", "6.5 mm")?;
//! # let measured = |seed| simulate(&faulty, None, &SimulationOptions { name: PathBuf::from("check"), seed: Some(seed), ..SimulationOptions::default() });
//! # let logged = measured(1)?.record;
//! # let check = measured(2)?.record;
//! # let column = |name: &str| logged.channel(name).map_or_else(Vec::new, |one| one.values.clone());
//! # let (time, u, level_1, level_2) = (logged.time.clone(), column("u"), column("level_1"), column("level_2"));
//!
//! let rig = Rig::read("fixtures/two_tanks/rig.toml")?;
//! let record = Record::from_columns(time, [("u", "V", u), ("level_1", "m", level_1), ("level_2", "m", level_2)])?;
//! let model = rig.model();
//! let run = model.with("upper_outlet.diameter", "6.5 mm")?.simulate(&record.inputs())?;
//! let level = run.sensor("level_1")?.in_unit("mm")?;
//! let diagnosis = model.diagnose(&record)?;
//! for fault in diagnosis.present() {
//!     println!("{fault}");
//! }
//! let missing = borescope::suggest(&rig, &record, Some(&check))?;
//! println!("{missing}");
//!
//! # assert!(level.iter().all(|level| (0.0..2000.0).contains(level)));
//! # let present: Vec<String> = diagnosis.present().map(ToString::to_string).collect();
//! # assert_eq!(present.len(), 1);
//! # assert!(present[0].starts_with("upper_outlet.diameter 6.5"), "{}", present[0]);
//! # assert_eq!(missing.to_string(), "the model explains the record within its tolerance");
//! # Ok::<(), borescope::Complaint>(())
//! ```
//!
//! A [`Context`] that is given to the rig ([`Rig::with_context`]) hears of the progress, may end the work early, and bounds the
//! threads.
//!
//! Beside [`diagnose`] and [`suggest`]: [`check`] says what is in a rig file and a record, [`draft`] begins a rig file, [`calibrate`]
//! takes its values from healthy records, [`compare`] shows where the model misses, [`add`] and [`improve`] give it more physics,
//! [`isolability`] says beforehand which faults can be isolated, and a [`Campaign`] measures how often a diagnosis is right. What
//! they give consists of the types in [`results`].
//!
//! The feature `cli`, on by default, is the command `borescope`; `store` keeps diagnoses, `excel` reads workbooks, and `parquet`, off
//! by default, reads and writes tables in that format.

// With `internals` more is public than is meant to be read.
#![cfg_attr(not(feature = "internals"), deny(missing_docs))]

mod calibration;
mod campaign;
mod check;
#[cfg(feature = "cli")]
mod cli;
mod complaint;
mod context;
#[cfg(feature = "cli")]
mod desk;
mod diagnosis;
mod draft;
mod estimation;
mod expression;
mod files;
#[cfg(feature = "cli")]
mod finding;
#[cfg(feature = "cli")]
mod fleet;
#[cfg(feature = "store")]
mod history;
mod isolability;
mod learn;
mod model;
mod number;
mod numeric;
mod physics;
mod record;
mod report;
mod residual;
mod rig;
mod settings;
#[cfg(feature = "cli")]
mod shards;
mod simulation;
#[cfg(feature = "store")]
mod store;
mod structure;
mod units;
#[cfg_attr(not(feature = "cli"), expect(dead_code, reason = "only the command writes through `Visible`"))]
mod visible;

pub mod results;

#[cfg(feature = "internals")]
#[doc(hidden)]
pub mod internals;

pub use calibration::{Calibrated, CalibrationOptions, calibrate};
pub use campaign::{Campaign, CampaignOptions};
pub use check::{Checked, check};
#[cfg(feature = "cli")]
#[doc(hidden)]
pub use cli::{call, run as command};
pub use complaint::{Complaint, Kind as ComplaintKind, Place};
pub use context::{Context, Interrupted, Progress};
pub use diagnosis::watch::{Watched, Watching};
pub use diagnosis::{Diagnosed, Diagnosis, DiagnosisOptions, Verdict};
pub use draft::{Circuit, Draft, DraftOptions, draft};
#[cfg(feature = "store")]
pub use history::{By, History, history};
pub use isolability::{TakenFault, isolability};
pub use learn::add::{Added, add};
pub use learn::behind::diagnose;
pub use learn::compare::compare;
pub use learn::evaluated::Conclusion;
pub use learn::improve::{Improvement, improve};
pub use learn::suggest::{Suggestion, suggest};
pub use model::{Model, Reading, Simulation, SolverEffort};
pub use record::{Channel, Inputs, Record};
pub use residual::Detection;
pub use rig::Rig;
pub use settings::{Setting, Settings};
pub use simulation::{Method, Simulated, SimulationOptions, simulate};
#[cfg(all(feature = "parquet", feature = "store"))]
pub use store::export_parquet;
#[cfg(feature = "store")]
pub use store::{Moment, NewRun, RigIdentity, Store, StoredRun, export_csv};
pub use units::{Dimension, Quantity, Unit, UnitError};
