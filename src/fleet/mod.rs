//! Many records of many machines: a manifest of records that is worked off in shards, and how a whole fleet stands.

#[cfg(feature = "cli")]
pub mod manifest;
#[cfg(feature = "cli")]
pub mod rows;
mod standing;

use std::collections::BTreeMap;

use serde::Serialize;

use crate::history::newest;
use crate::store::StoredRun;
pub use standing::{Next, Present, Standing, State};

/// Name and version of the JSON schema.
pub const SCHEMA: &str = "borescope.fleet/1";

/// How the rigs of a store stand.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(feature = "internals", derive(schemars::JsonSchema))]
pub struct Fleet {
    /// Name and version of the JSON schema: `borescope.fleet/1`.
    pub schema: &'static str,
    /// The store or table, as the user named it.
    pub source: String,
    /// Runs that count: of several diagnoses of one record, the last.
    pub runs: usize,
    /// How many rigs there are in each state, every state named.
    pub states: BTreeMap<State, usize>,
    /// Every rig, the worst first.
    pub rigs: Vec<Standing>,
}

/// How the rigs of these runs stand, by their last run and by the trends of their faults.
pub fn fleet(source: &str, runs: &[StoredRun]) -> Fleet {
    let mut of_rig: BTreeMap<&str, Vec<&StoredRun>> = BTreeMap::new();
    for run in runs {
        of_rig.entry(Standing::name(run)).or_default().push(run);
    }
    // Machines that are alike may well give the same record, so that repetitions are of one rig.
    of_rig.values_mut().for_each(|runs| *runs = newest(runs));
    let counted = of_rig.values().map(Vec::len).sum();
    let mut rigs: Vec<Standing> = of_rig.into_values().filter_map(|runs| Standing::of(&runs)).collect();
    rigs.sort_by(Standing::worse_first);
    let mut states: BTreeMap<State, usize> = State::ALL.map(|state| (state, 0)).into();
    for rig in &rigs {
        *states.entry(rig.state).or_default() += 1;
    }
    Fleet { schema: SCHEMA, source: source.to_owned(), runs: counted, states, rigs }
}
