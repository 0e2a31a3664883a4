//! How well each fault could be sized at an operating point, and what it would be
//! mistaken for.

use serde::Serialize;

use crate::complaint::{Complaint, Kind, Place};
use crate::diagnosis::expected::{self, Expected};
use crate::estimation::profile::QUANTILE;
use crate::model::InputSignals;
use crate::number::rounded;
use crate::record::Record;
use crate::rig::Rig;

/// What a record at the operating point would say.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(feature = "internals", derive(schemars::JsonSchema))]
pub struct Expectation {
    /// The faults that are taken as present.
    pub with: Vec<AssumedFault>,
    /// Independent combinations of the faults of which the record would say more than their ranges do.
    pub rank: usize,
    /// Of how many faults.
    pub of: usize,
    /// Every fault of the rig, in its order.
    pub widths: Vec<ExpectedWidth>,
    /// The set most easily mistaken for the one that is present.
    pub rival: Vec<String>,
    /// Probability of that mistake.
    pub mistaken: f64,
}

/// A fault that is taken as present.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(feature = "internals", derive(schemars::JsonSchema))]
pub struct AssumedFault {
    /// Its id.
    pub id: String,
    /// In `unit`.
    pub value: f64,
    /// As the rig file has it.
    pub unit: String,
    /// Whether every set without it would lose.
    pub identifiable: bool,
}

/// How well one fault could be sized, the present ones unknown too.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(feature = "internals", derive(schemars::JsonSchema))]
pub struct ExpectedWidth {
    /// Id of the fault.
    pub id: String,
    /// As the rig file has it.
    pub unit: String,
    /// Half the expected 95 % interval; `None` where the record would say nothing.
    pub half_width: Option<f64>,
}

/// A fault that is taken as present at the operating point.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TakenFault {
    /// Index among the faults of the rig.
    pub fault: usize,
    /// SI.
    pub value: f64,
}

impl TakenFault {
    /// The fault `id`, such as `cylinder.clearance`, at a value with its unit, such as `0.2 mm`.
    ///
    /// # Errors
    /// What is no parameter or no fault of the rig; a value without unit or out of its bounds.
    pub fn new(rig: &Rig, id: &str, value: &str) -> Result<Self, Complaint> {
        let value = rig.clone().set(id, value)?.value;
        let id = id.trim();
        let fault = (0..rig.faults.len()).find(|&fault| rig.fault_id(fault) == id);
        let fault = fault.ok_or_else(|| {
            Complaint::new(Kind::UnknownName, format!("`{id}` is no fault of the rig"))
                .at(Place::file(&rig.path))
                .help("name a parameter that `[faults]` lists")
        })?;
        Ok(Self { fault, value })
    }
}

/// What a record at the operating point of `record` would say with these faults present.
///
/// # Errors
/// An operating point that cannot be simulated.
pub(super) fn expectation(
    rig: &Rig,
    drive: &InputSignals,
    record: &Record,
    with: &[TakenFault],
) -> Result<Expectation, Complaint> {
    let faults: Vec<(usize, f64)> = with.iter().map(|taken| (taken.fault, taken.value)).collect();
    let Expected { sigma, rank, identifiable, rival } = expected::expected(&rig.model(), record, drive, &faults)
        .map_err(|error| {
            Complaint::new(Kind::Computation, format!("the operating point could not be simulated: {error}"))
                .in_file(&rig.path)
                .help("take smaller faults, or another record")
        })?;
    let parameter = |fault: usize| &rig.parameters[rig.faults[fault].parameter];
    let width = |(fault, sigma): (usize, &Option<f64>)| ExpectedWidth {
        id: parameter(fault).id.clone(),
        unit: parameter(fault).unit.symbol.clone(),
        half_width: sigma.map(|sigma| rounded(parameter(fault).unit.difference_from_si(QUANTILE * sigma), 3)),
    };
    let present = |(&(fault, value), identifiable): (&(usize, f64), bool)| AssumedFault {
        id: parameter(fault).id.clone(),
        value: rounded(parameter(fault).unit.from_si(value), 7),
        unit: parameter(fault).unit.symbol.clone(),
        identifiable,
    };
    Ok(Expectation {
        with: faults.iter().zip(identifiable).map(present).collect(),
        rank,
        of: rig.faults.len(),
        widths: sigma.iter().enumerate().map(width).collect(),
        mistaken: rival.as_ref().map_or(0.0, |rival| rounded(rival.mistaken, 3)),
        rival: rival
            .map_or_else(Vec::new, |rival| rival.faults.iter().map(|&fault| parameter(fault).id.clone()).collect()),
    })
}
