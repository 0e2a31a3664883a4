//! What a table of cases says about the diagnosis. Definitions stand at the fields; `docs/how-to/run-a-campaign.md` has
//! them with their sources.

use serde::Serialize;

use super::row::{FaultRow, Outcome, Row};
use super::statistics::{Found, Rate, found_in_most, mean, quantile};
use crate::number::rounded;

/// All scores of a campaign.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(feature = "internals", derive(schemars::JsonSchema))]
pub struct Scores {
    /// How many were run.
    pub cases: usize,
    /// Cases without a diagnosis. In all rates they count as wrong.
    pub failed: usize,
    /// Cases and rigs that were drawn anew because a simulation came to no end.
    pub(crate) redrawn: Redrawn,
    /// Rigs that have no calibrated model, or one that does not explain their healthy records.
    pub inadequate_rigs: Rate,
    /// Every case.
    pub all: Group,
    /// The faulty cases whose faults are identifiable at their size; `None` where this was not worked out.
    pub identifiable: Option<Group>,
    /// The same by the number of injected faults, from 0.
    pub by_count: Vec<Group>,
    /// Cases whose faults began within the record.
    pub midway: Group,
    /// Fault by fault.
    #[doc(hidden)]
    pub faults: Vec<FaultScore>,
    /// Which faults were taken for which.
    #[doc(hidden)]
    pub confusion: Confusion,
    /// Stated probabilities against how often they were right.
    #[doc(hidden)]
    pub reliability: Reliability,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[cfg_attr(feature = "internals", derive(schemars::JsonSchema))]
pub struct Redrawn {
    /// Cases whose rig was drawn again.
    pub cases: usize,
    /// Rigs among those.
    pub rigs: usize,
}

/// Scores of some of the cases.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(feature = "internals", derive(schemars::JsonSchema))]
pub struct Group {
    /// True detection rate: faulty cases with a verdict other than healthy.
    pub detected: Rate,
    /// False alarm rate: healthy cases with a verdict other than healthy.
    pub false_alarms: Rate,
    /// Isolation accuracy: faulty cases whose present faults are exactly the injected ones.
    pub isolated: Rate,
    /// Mean number of sets of faults that reach a probability of 95 %, over all cases.
    pub mean_ambiguity: Option<f64>,
    /// From the onset (of old faults: from the first motion) to the detection, s.
    pub median_delay_s: Option<f64>,
    /// 95 % of the delays are at most so long, s.
    pub delay95_s: Option<f64>,
    /// Mean absolute percentage error of the injected faults that were found, of their distance to the healthy value.
    pub mape_of_deviation: Option<f64>,
    /// Median of the same errors.
    pub median_ape_of_deviation: Option<f64>,
    /// The same of the true value.
    pub mape_of_value: Option<f64>,
    /// Found faults whose closed 95 % interval holds the truth.
    pub coverage_found: Rate,
    /// All faults of the rigs, injected or not, whose interval holds the truth; an open end holds everything.
    pub coverage_all: Rate,
}

/// Scores of one fault, over all cases in which it was injected.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(feature = "internals", derive(schemars::JsonSchema))]
pub struct FaultScore {
    /// The fault.
    pub id: String,
    /// Unit of the numbers beside it.
    pub unit: String,
    /// Injected faults that were called present.
    pub found: Rate,
    /// Cases without this fault in which it was called present.
    pub blamed: Rate,
    /// In percent of the distance to the healthy value.
    pub mape_of_deviation: Option<f64>,
    /// Share of the intervals that hold the truth.
    pub coverage: Rate,
    /// Distance from the healthy value found in 90 % of cases, in `unit`.
    pub found90: Option<Found>,
    /// The same as leakage, L/min.
    pub found90_l_min: Option<Found>,
}

/// Injected single faults by the most probable set.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(feature = "internals", derive(schemars::JsonSchema))]
pub struct Confusion {
    /// Of rows: what was injected, `healthy` first.
    pub injected: Vec<String>,
    /// Of columns: the same, then `several` faults, then `none` where there was no diagnosis.
    pub found: Vec<String>,
    /// How often each was named for each.
    pub counts: Vec<Vec<usize>>,
}

/// How often the most probable set is right, by its probability.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(feature = "internals", derive(schemars::JsonSchema))]
pub struct Reliability {
    /// From the least probability to the greatest.
    pub bins: Vec<Bin>,
    /// Mean distance of probability and share over the bins, weighed by cases (expected calibration error).
    pub expected_calibration_error: Option<f64>,
}

#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(feature = "internals", derive(schemars::JsonSchema))]
pub struct Bin {
    /// Probability from here.
    pub from: f64,
    /// Greatest probability of the bin.
    pub to: f64,
    /// Mean probability that was stated.
    pub mean_probability: Option<f64>,
    /// How many of them were right.
    pub right: Rate,
}

/// Ends of the bins: most cases are sure, so they crowd at 1.
const BINS: [f64; 10] = [0.0, 0.3, 0.5, 0.7, 0.8, 0.9, 0.95, 0.99, 0.999, 1.0];

impl Scores {
    /// Of rows in the order of the cases.
    pub fn of(rows: &[Row]) -> Self {
        let every: Vec<&Row> = rows.iter().collect();
        let told = rows.iter().any(|row| row.identifiable.is_some());
        let identifiable = |row: &&&Row| !row.is_faulty() || row.identifiable == Some(true);
        let largest = rows.iter().map(|row| row.count).max().unwrap_or(0);
        let group =
            |is: &dyn Fn(&Row) -> bool| Group::of(&every.iter().copied().filter(|row| is(row)).collect::<Vec<_>>());
        let mut rigs: Vec<&Row> = rows.iter().collect();
        rigs.sort_by_key(|row| row.rig);
        rigs.dedup_by_key(|row| row.rig);
        Self {
            cases: rows.len(),
            failed: rows.iter().filter(|row| row.outcome == Outcome::Failed).count(),
            redrawn: Redrawn {
                cases: rows.iter().map(|row| row.redrawn).sum(),
                rigs: rigs.iter().map(|row| row.rig_redrawn).sum(),
            },
            inadequate_rigs: Rate::of(&rigs, |row| row.rig_adequate != Some(true)),
            all: Group::of(&every),
            identifiable: told.then(|| Group::of(&every.iter().filter(identifiable).copied().collect::<Vec<_>>())),
            by_count: (0..=largest).map(|count| group(&|row| row.count == count)).collect(),
            midway: group(&|row| row.onset_s.is_some()),
            faults: fault_scores(rows),
            confusion: Confusion::of(rows),
            reliability: Reliability::of(rows),
        }
    }
}

/// Percentage error of an injected fault that was found.
fn percentage(fault: &FaultRow, of: f64) -> Option<f64> {
    let error = (fault.value? - fault.truth).abs();
    (fault.injected && fault.present && of != 0.0).then(|| 100.0 * error / of.abs())
}

impl Group {
    fn of(rows: &[&Row]) -> Self {
        let faulty = || rows.iter().copied().filter(|row| row.is_faulty());
        let healthy = || rows.iter().copied().filter(|row| !row.is_faulty());
        let delays: Vec<f64> =
            faulty().filter(|row| row.alarmed()).filter_map(|row| Some(row.detected_at_s? - row.begin_s())).collect();
        let ambiguity: Vec<f64> = rows.iter().filter_map(|row| row.ambiguity).map(|count| count as f64).collect();
        let faults = || rows.iter().flat_map(|row| &row.faults).filter(|fault| fault.value.is_some());
        let of_deviation: Vec<f64> = faults().filter_map(|fault| percentage(fault, fault.size())).collect();
        let of_value: Vec<f64> = faults().filter_map(|fault| percentage(fault, fault.truth)).collect();
        Self {
            detected: Rate::of(faulty(), |row| row.alarmed()),
            false_alarms: Rate::of(healthy(), |row| row.outcome != Outcome::Healthy),
            isolated: Rate::of(faulty(), |row| row.isolated()),
            mean_ambiguity: mean(&ambiguity),
            median_delay_s: quantile(&delays, 0.5),
            delay95_s: quantile(&delays, 0.95),
            mape_of_deviation: mean(&of_deviation),
            median_ape_of_deviation: quantile(&of_deviation, 0.5),
            mape_of_value: mean(&of_value),
            coverage_found: Rate::of(
                faults().filter(|fault| fault.injected && fault.present && fault.closed()),
                |fault| fault.covered(),
            ),
            coverage_all: Rate::of(faults(), |fault| fault.covered()),
        }
    }
}

fn fault_scores(rows: &[Row]) -> Vec<FaultScore> {
    let Some(first) = rows.first() else { return Vec::new() };
    let score = |(index, fault): (usize, &FaultRow)| {
        let own = || rows.iter().filter_map(move |row| row.faults.get(index));
        let injected = || own().filter(|fault| fault.injected);
        let errors: Vec<f64> = injected().filter_map(|fault| percentage(fault, fault.size())).collect();
        let sizes: Vec<(f64, bool)> = injected().map(|fault| (fault.size(), fault.present)).collect();
        let flows: Vec<(f64, bool)> = injected().filter_map(|fault| Some((fault.flow_l_min?, fault.present))).collect();
        FaultScore {
            id: fault.id.clone(),
            unit: fault.unit.clone(),
            found: Rate::of(injected(), |fault| fault.present),
            blamed: Rate::of(own().filter(|fault| !fault.injected), |fault| fault.present),
            mape_of_deviation: mean(&errors),
            coverage: Rate::of(injected().filter(|fault| fault.present && fault.closed()), |fault| fault.covered()),
            found90: found_in_most(&sizes),
            found90_l_min: found_in_most(&flows),
        }
    };
    first.faults.iter().enumerate().map(score).collect()
}

impl Confusion {
    fn of(rows: &[Row]) -> Self {
        let ids = rows.first().map_or(&[][..], |row| &row.faults).iter().map(|fault| fault.id.clone());
        let injected: Vec<String> = std::iter::once("healthy".to_owned()).chain(ids).collect();
        let several = injected.len();
        let mut counts = vec![vec![0; several + 2]; several];
        let place = |set: &[&str]| match set {
            [] => Some(0),
            [id] => injected.iter().position(|other| other == id),
            _ => None,
        };
        for row in rows.iter().filter(|row| row.injected().len() == row.count) {
            let top: Vec<&str> = row.top.iter().map(String::as_str).collect();
            let column = if row.outcome == Outcome::Failed { several + 1 } else { place(&top).unwrap_or(several) };
            if let Some(line) = place(&row.injected()) {
                counts[line][column] += 1;
            }
        }
        let mut found = injected.clone();
        found.extend(["several", "none"].map(str::to_owned));
        Self { injected, found, counts }
    }
}

impl Reliability {
    fn of(rows: &[Row]) -> Self {
        let told: Vec<(f64, bool)> =
            rows.iter().filter_map(|row| Some((row.top_probability?, row.top_is_right()))).collect();
        let mut distance = 0.0;
        let mut bins = Vec::new();
        for ends in BINS.windows(2) {
            let (from, to) = (ends[0], ends[1]);
            let last = to == 1.0;
            let within = told.iter().filter(|(p, _)| *p >= from && (*p < to || last));
            let (probabilities, right): (Vec<f64>, Vec<bool>) = within.copied().unzip();
            let right = Rate::of(right, |right| *right);
            let sum: f64 = probabilities.iter().sum();
            distance += (sum - right.count as f64).abs();
            bins.push(Bin { from, to, mean_probability: mean(&probabilities), right });
        }
        let error = (!told.is_empty()).then(|| rounded(distance / told.len() as f64, 6));
        Self { bins, expected_calibration_error: error }
    }
}
