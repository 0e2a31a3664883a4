//! Look inside a hydraulic circuit through its records.
//!
//! A rig file describes the circuit, a record holds what a logger wrote of pressures, flows and positions. The model simulates the
//! circuit; a diagnosis fits all faults together with everything else that is uncertain and says what is wrong, how large, and how
//! sure; a suggestion says which physics the model lacks:
//!
//! ```
//! use borescope::{Record, Rig};
//! # use borescope::simulation::{Options, simulate};
//! # use std::path::PathBuf;
//! # let faulty = Rig::read("fixtures/two_tanks/rig.toml")?.model().with("upper_outlet.diameter", "6.5 mm")?;
//! # let measured = |seed| simulate(&faulty, None, &Options { name: PathBuf::from("check"), seed: Some(seed), ..Options::default() });
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
//! Data flows one way, and nothing lower knows anything higher:
//! [`record`] and [`rig`], then [`model`] (from [`physics`], solved by [`numeric`]), [`residual`] and [`estimation`], [`diagnosis`],
//! [`report`]. [`store`] keeps diagnoses and [`history`] reads its trends. [`structure`] says beforehand what can be told
//! apart, [`campaign`] measures how well it goes.

#![deny(missing_docs)]

#[allow(missing_docs, reason = "most fields have none yet")]
pub mod calibration;
#[allow(missing_docs, reason = "most fields have none yet")]
pub mod campaign;
pub mod check;
pub mod complaint;
pub mod context;
#[allow(missing_docs, reason = "most fields have none yet")]
pub mod diagnosis;
pub mod draft;
#[cfg(feature = "store")]
#[allow(missing_docs, reason = "most fields have none yet")]
pub mod history;
pub mod isolability;
#[allow(missing_docs, reason = "most fields have none yet")]
pub mod learn;
pub mod model;
pub mod record;
#[allow(missing_docs, reason = "most fields have none yet")]
pub mod rig;
pub mod simulation;
#[cfg(feature = "store")]
pub mod store;
pub mod units;
#[cfg_attr(not(feature = "cli"), expect(dead_code, reason = "only the command writes through `Visible`"))]
mod visible;

// No part of what the library promises: public for the command, tests, benches and fuzz targets.
#[cfg(test)]
mod added_component;
#[cfg(feature = "cli")]
#[doc(hidden)]
pub mod cli;
#[doc(hidden)]
#[allow(missing_docs, reason = "most fields have none yet")]
pub mod estimation;
#[doc(hidden)]
pub mod expression;
#[doc(hidden)]
pub mod files;
#[doc(hidden)]
pub mod number;
#[doc(hidden)]
pub mod numeric;
#[doc(hidden)]
pub mod physics;
#[doc(hidden)]
pub mod report;
#[doc(hidden)]
pub mod residual;
#[doc(hidden)]
pub mod structure;

pub use calibration::calibrate;
pub use complaint::Complaint;
pub use context::Context;
pub use diagnosis::{Diagnosis, Verdict, diagnose};
pub use learn::improve::improve;
pub use learn::suggest::{Suggestion, suggest};
pub use model::{Model, Simulation};
pub use record::Record;
pub use rig::Rig;
pub use simulation::simulate;
pub use units::{Quantity, Unit};
