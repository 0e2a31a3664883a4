//! Look inside a hydraulic circuit through its records.
//!
//! A rig file describes the circuit, a record holds what a logger wrote of pressures, flows and positions. [`diagnosis`]
//! fits all faults together with everything else that is uncertain and says what is wrong, how large, and how sure:
//!
//! ```
//! use borescope::diagnosis::{Options, Verdict, diagnose};
//! use borescope::model::Model;
//! use borescope::record::Record;
//! use borescope::rig::Rig;
//!
//! let model = Model::new(Rig::read("fixtures/telescopic/rig.toml")?);
//! let record = Record::read("fixtures/telescopic/leak_020.csv")?;
//! let diagnosis = diagnose(&model, &record, &Options::default())?.diagnosis;
//!
//! assert_eq!(diagnosis.verdict, Verdict::Faulty);
//! let present: Vec<&str> = diagnosis.present().map(|fault| fault.id.as_str()).collect();
//! assert_eq!(present, ["cylinder.clearance"]);
//! let clearance = &diagnosis.faults[0];
//! assert!((clearance.value - 0.2).abs() < 0.004, "{} {}", clearance.value, clearance.unit);
//! # Ok::<(), borescope::complaint::Complaint>(())
//! ```
//!
//! Data flows one way, and nothing lower knows anything higher:
//! [`record`] and [`rig`], then [`model`] (from [`physics`], solved by [`numeric`]), [`residual`] and [`fit`], [`diagnosis`],
//! [`report`]. [`store`] keeps diagnoses and [`history`] reads its trends. [`structure`] says beforehand what can be told
//! apart, [`campaign`] measures how well it goes.

pub mod calibration;
pub mod campaign;
pub mod cli;
pub mod complaint;
pub mod context;
pub mod diagnosis;
pub mod expression;
pub mod files;
pub mod fit;
pub mod history;
pub mod learn;
pub mod model;
pub mod numeric;
pub mod physics;
pub mod record;
pub mod report;
pub mod residual;
pub mod rig;
pub mod store;
pub mod structure;
pub mod units;
