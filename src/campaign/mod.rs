//! How good the diagnosis is, measured on synthetic faults.
//!
//! A campaign draws rigs that are near the data sheet but not on it ([`disturb`]), lets each make two healthy records from
//! which the data sheet is calibrated, as a user would, draws faults ([`draw`]), writes records with coloured noise
//! (`measured`), diagnoses them with the calibrated rig, and compares ([`score`]). Every number has a stream of
//! random numbers of its own ([`random`]), so that results depend on the options only.

pub(crate) mod case;
pub mod disturb;
pub mod draw;
pub(crate) mod measured;
pub mod random;
pub(crate) mod row;
pub mod score;
pub mod statistics;
#[cfg(feature = "cli")]
pub mod store;

use std::sync::OnceLock;

use serde::{Deserialize, Serialize};

use crate::complaint::{Complaint, Kind, Place};
use crate::context::work_off;
use crate::rig::{Cycle, InitialPressure, NodeKind, Rig};
use case::Prepared;
#[cfg(feature = "cli")]
use case::Replay;
pub use row::{FaultRow, Outcome, Row};

/// What the user may choose. Two campaigns with the same options and rig file give the same rows.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "internals", derive(schemars::JsonSchema))]
pub struct CampaignOptions {
    /// How many cases, above 0.
    pub cases: usize,
    /// Of the random numbers.
    pub seed: u64,
    /// Share of healthy cases, 0 to 1.
    pub healthy: f64,
    /// How much rigs are disturbed: 1 as parts scatter around their data sheets, 0 not at all, 5 at most.
    pub disturbance: f64,
    /// How many disturbed rigs, above 0.
    pub rigs: usize,
}

/// Share of healthy cases where nothing else is asked for.
pub const HEALTHY: f64 = 0.32;
/// Beyond this, strayed parameters pile up at their bounds.
pub const MOST_DISTURBANCE: f64 = 5.0;
/// Most cases of a campaign. A case takes seconds of computing, so more would take a machine years; and what is laid out
/// beforehand for so many, about a kilobyte each, still fits the memory of a small one.
pub const MOST_CASES: usize = 1_000_000;
/// Cases that share a rig where nothing else is asked for.
const PER_RIG: usize = 25;

impl CampaignOptions {
    /// Defaults for so many cases.
    pub fn new(cases: usize) -> Self {
        Self { cases, seed: 1, healthy: HEALTHY, disturbance: 1.0, rigs: (cases / PER_RIG).max(1) }
    }
}

/// What a thread takes next.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Work {
    /// This rig is drawn and calibrated.
    Rig(usize),
    Case(usize),
}

/// A campaign that is laid out.
pub struct Campaign {
    /// As its data sheet has it.
    pub rig: Rig,
    /// With which it was laid out.
    pub options: CampaignOptions,
    cycle: Cycle,
    /// How many faults each case has.
    plan: Vec<usize>,
    rigs: Vec<OnceLock<Result<Prepared, String>>>,
}

impl Campaign {
    /// Lays out a campaign on a rig.
    ///
    /// # Errors
    /// CampaignOptions outside their limits; a rig without cycle, faults or sensors, or one that starts from a record.
    pub fn new(rig: Rig, options: CampaignOptions) -> Result<Self, Complaint> {
        let option = |what: &str, help: &str| Err(Complaint::new(Kind::Bounds, what).help(help));
        if options.cases == 0 {
            return option("a campaign of no cases", "ask for one or more with `--cases`");
        }
        if options.cases > MOST_CASES {
            let help = format!("ask for {MOST_CASES} or fewer; a few hundred settle rates to some percent");
            return option(&format!("a campaign of {} cases", options.cases), &help);
        }
        if !(0.0..=1.0).contains(&options.healthy) {
            return option(
                "the fraction of healthy cases is not between 0 and 1",
                "write a fraction such as `--healthy 0.32`",
            );
        }
        if !(0.0..=MOST_DISTURBANCE).contains(&options.disturbance) {
            let help = format!("write a number from 0 (none) to {MOST_DISTURBANCE}, such as `--disturbance 1`");
            return option("the disturbance is out of range", &help);
        }
        if options.rigs == 0 || options.rigs > options.cases {
            let help = format!("write a number from 1 to {}, one rig for each case", options.cases);
            return option("the number of rigs does not fit that of the cases", &help);
        }
        let missing = |what: &str, help: &str| {
            Err(Complaint::new(Kind::MissingEntry, what).at(Place::file(&rig.path)).help(help))
        };
        let Some(cycle) = rig.cycle.clone() else {
            return missing("the rig file has no `[cycle]` to simulate", "add `[cycle]` with `interval` and `phases`");
        };
        if rig.sensors.is_empty() {
            return missing("the rig has no sensors", "add `[sensors]`, one line per measured column");
        }
        if rig.faults.is_empty() {
            return missing("the rig has no faults to draw", "add `[faults]`, one line per fault");
        }
        let from_record = |kind: &NodeKind| {
            matches!(
                kind,
                NodeKind::Volume { initial: InitialPressure::Record } | NodeKind::Body { position: None, .. }
            )
        };
        let help = "write the pressure or position that it starts with, such as `initial = \"0 bar\"`";
        if let Some(unknown) = rig.starts_unknown(from_record, help) {
            return Err(unknown);
        }
        let plan = draw::plan(options.cases, options.healthy, rig.faults.len(), options.seed);
        let rigs = (0..options.rigs).map(|_| OnceLock::new()).collect();
        Ok(Self { rig, options, cycle, plan, rigs })
    }

    /// The disturbed rig of a case: neighbours share one.
    pub fn rig_of(&self, case: usize) -> usize {
        case * self.options.rigs / self.options.cases
    }

    /// Runs one case alone.
    ///
    /// # Errors
    /// A number that the campaign does not have, or a context that was cancelled.
    #[cfg(feature = "cli")]
    pub(crate) fn replay(&self, case: usize) -> Result<Replay, Complaint> {
        let Some(&count) = self.plan.get(case) else {
            let last = self.options.cases - 1;
            return Err(Complaint::new(Kind::Bounds, format!("there is no case {case}"))
                .help(format!("cases count from 0 to {last}")));
        };
        let replay = self.case(case, count);
        self.rig.context().check()?;
        Ok(replay)
    }

    /// Cases in their order, and in front of those of each rig the calibration of the one that comes so many rigs later: a
    /// thread that met a rig that another calibrates would wait.
    fn work(&self, cases: &[usize], ahead: usize) -> Vec<Work> {
        let of_one_rig = || cases.chunk_by(|a, b| self.rig_of(*a) == self.rig_of(*b));
        let mut later = of_one_rig().map(|cases| Work::Rig(self.rig_of(cases[0])));
        let mut work: Vec<Work> = later.by_ref().take(ahead).collect();
        for cases in of_one_rig() {
            work.extend(later.next());
            work.extend(cases.iter().map(|&case| Work::Case(case)));
        }
        work
    }

    /// Runs cases on so many threads; `done` gets each row as it comes, and may end the campaign by an error.
    ///
    /// # Errors
    /// What `done` gave, or a context that was cancelled; rows that came before are whole.
    pub fn run(
        &self,
        cases: &[usize],
        threads: usize,
        done: impl FnMut(Row) -> Result<(), Complaint>,
    ) -> Result<(), Complaint> {
        let work = self.work(cases, threads.clamp(1, cases.len().max(1)));
        let each = |work: &Work| match *work {
            Work::Rig(rig) => {
                // What went wrong is told by its cases.
                let _ = self.prepared(rig);
                None
            }
            Work::Case(case) => self.plan.get(case).map(|&count| self.case(case, count).row),
        };
        work_off(&work, threads, self.rig.context(), each, done)
    }
}
