//! The whole structural analysis of a rig, as one result.

use serde::Serialize;

use super::isolability::{isolation, signatures};
use super::matching::decompose;
use super::mso::count_mso;
use super::mtes::{lacking, mtes_sets, smallest_test};
use super::placement::{Extent, place};
use super::selection::select;
use super::{Structure, from_rig};
use crate::rig::Rig;

/// Redundant sets are counted up to here.
const MSO_LIMIT: usize = 100_000;
const MTES_LIMIT: usize = 20_000;
/// How many sets are looked at for the smallest test of one support.
const TEST_LIMIT: usize = 20_000;
/// Larger additions are not suggested.
const MOST_SENSORS: usize = 4;

/// How many there are.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[cfg_attr(feature = "internals", derive(schemars::JsonSchema))]
pub struct Count {
    /// How many were counted.
    pub count: usize,
    /// `false` where there are more.
    pub complete: bool,
}

/// A group of equations worth a residual.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
#[cfg_attr(feature = "internals", derive(schemars::JsonSchema))]
pub struct StructuralTest {
    /// Faults that it answers to.
    pub faults: Vec<String>,
    /// Sensors and inputs that it can use.
    pub signals: Vec<String>,
    /// Names of the equations.
    pub equations: Vec<String>,
}

/// Two faults of which the second explains all that the first does.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
#[cfg_attr(feature = "internals", derive(schemars::JsonSchema))]
pub struct FaultPair {
    /// Id of the first.
    pub fault: String,
    /// Id of the second.
    pub explained_by: String,
}

/// What the structure of a rig lets its sensors say about its faults.
///
/// Structural means: for almost all numbers. What cannot be isolated here can be isolated by no method that lets a
/// fault vary in time at will; what can be isolated here may still need more excitation or less noise than a record
/// has.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
#[cfg_attr(feature = "internals", derive(schemars::JsonSchema))]
pub struct Isolability {
    /// How many the structure has.
    pub equations: usize,
    /// How many the structure has.
    pub unknowns: usize,
    /// Equations more than unknowns, in the part that can be tested.
    pub redundancy: usize,
    /// Ids, in the order of the rig.
    pub faults: Vec<String>,
    /// Per fault.
    pub detectable: Vec<bool>,
    /// Faults by faults: whether the fault of the column explains whatever the fault of the row does.
    pub explained_by: Vec<Vec<bool>>,
    /// Detectable faults that explain each other, two or more in a group.
    pub ambiguity_groups: Vec<Vec<String>>,
    /// Minimal structurally overdetermined sets.
    #[doc(hidden)]
    pub mso_sets: Count,
    /// Minimal test equation supports.
    #[doc(hidden)]
    pub mtes_sets: Count,
    /// Few tests that together isolate what can be isolated.
    pub tests: Vec<StructuralTest>,
    /// The fewest further sensors that make detectable and isolable whatever sensors can, as alternatives. One empty
    /// alternative: none is missing. No alternative: more than four would be needed.
    pub sensors: Vec<Vec<String>>,
    /// Pairs that stay, whatever is measured besides.
    pub inseparable: Vec<FaultPair>,
}

/// Analyses the circuit, sensors and faults of a rig.
pub fn analyse(rig: &Rig) -> Isolability {
    analyse_structure(&from_rig(rig))
}

fn analyse_structure(original: &Structure) -> Isolability {
    let structure = original.one_equation_per_fault();
    let rows = structure.rows();
    let all: Vec<usize> = (0..rows.len()).collect();
    let over = decompose(&rows, &all, structure.unknowns.len()).over;
    let found = isolation(&structure);
    let names = |faults: &[usize]| faults.iter().map(|&fault| structure.faults[fault].clone()).collect::<Vec<_>>();
    let groups = found.groups().iter().filter(|group| group.len() > 1).map(|group| names(group)).collect();
    let (mso, mso_complete) = count_mso(&structure, MSO_LIMIT);
    let mut mtes = mtes_sets(&structure, MTES_LIMIT);
    if !mtes.complete {
        let lacking = lacking(&structure, &mtes.sets, &found);
        mtes.sets.extend(lacking);
    }
    let tests = signatures(&structure, &mtes.sets);
    let chosen = select(&tests).into_iter().map(|test| {
        let support = &mtes.sets[test];
        let small = smallest_test(&structure, support, TEST_LIMIT);
        describe(&structure, small.as_ref().unwrap_or(support), &tests[test])
    });
    let chosen = chosen.collect();
    let placement = place(&structure, &[], Extent::Fewest, MOST_SENSORS);
    let best = placement.sensors.first().cloned().unwrap_or_default();
    let with = best.iter().fold(structure.clone(), |with, &sensor| with.with_sensor(sensor, false));
    let sensor_names = |sensors: &Vec<usize>| sensors.iter().map(|&s| structure.unknowns[s].name.clone()).collect();
    Isolability {
        equations: original.equations.len(),
        unknowns: original.unknowns.len(),
        redundancy: over.equations.len() - over.unknowns.len(),
        faults: structure.faults.clone(),
        ambiguity_groups: groups,
        mso_sets: Count { count: mso, complete: mso_complete },
        mtes_sets: Count { count: mtes.sets.len(), complete: mtes.complete },
        tests: chosen,
        sensors: placement.sensors.iter().map(sensor_names).collect(),
        inseparable: if placement.sensors.is_empty() { Vec::new() } else { pairs(&with) },
        detectable: found.detectable,
        explained_by: found.explained_by,
    }
}

fn describe(structure: &Structure, set: &[usize], answers_to: &[bool]) -> StructuralTest {
    let equations = || set.iter().map(|&equation| &structure.equations[equation]);
    let mut signals: Vec<usize> = equations().flat_map(|equation| equation.knowns.iter().copied()).collect();
    signals.sort_unstable();
    signals.dedup();
    let faults = structure.faults.iter().zip(answers_to).filter(|(_, answers)| **answers);
    StructuralTest {
        faults: faults.map(|(fault, _)| fault.clone()).collect(),
        signals: signals.iter().map(|&signal| structure.knowns[signal].clone()).collect(),
        equations: equations().map(|equation| equation.name.clone()).collect(),
    }
}

fn pairs(structure: &Structure) -> Vec<FaultPair> {
    let found = isolation(structure);
    let mut pairs = Vec::new();
    for (fault, row) in structure.faults.iter().zip(&found.explained_by) {
        for (other, _) in structure.faults.iter().zip(row).filter(|(other, explains)| **explains && *other != fault) {
            pairs.push(FaultPair { fault: fault.clone(), explained_by: other.clone() });
        }
    }
    pairs
}
