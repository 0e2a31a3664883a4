//! Which further sensors make faults detectable and isolable.
//!
//! In a part with as many equations as unknowns, a sensor makes testable what its unknown is computed from. So each
//! fault that is not detectable, or not without the equation of another fault, names the sensors of which one is
//! needed; what is sought is the smallest set of sensors that meets all those demands. The demands are worked out again
//! after each sensor that is added, because a sensor can have a fault of its own.
//!
//! Source: M. Krysander, E. Frisk, "Sensor placement for fault diagnosis", IEEE Trans. SMC A 38(6), 2008; the tree of
//! hitting sets is R. Reiter's (Artificial Intelligence 32, 1987).

use std::collections::BTreeSet;

use super::Structure;
use super::matching::decompose;

/// Sensors that would do.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Placement {
    /// Alternatives, each a sorted list of unknowns to measure, where one may stand twice; no part of one is another,
    /// and smaller ones come first. One empty alternative where no sensor is missing.
    pub sensors: Vec<Vec<usize>>,
    /// Whether no alternative was left out by `most` or by the effort.
    pub complete: bool,
}

/// How many sets of sensors are looked at before the search gives up.
const EFFORT: usize = 20_000;

/// How far to search.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Extent {
    /// Only alternatives with the fewest sensors.
    Fewest,
    /// Every minimal alternative.
    #[cfg(feature = "internals")]
    All,
}

/// The sensors that make every fault detectable, and isolable from every other, as far as sensors on measurable
/// unknowns can do it. `faulty` are the unknowns whose new sensor would bring a fault of its own, to be isolated like
/// the others; `most` is the largest number of new sensors. The structure without the new sensors must have no
/// underdetermined part.
pub fn place(structure: &Structure, faulty: &[usize], extent: Extent, most: usize) -> Placement {
    let structure = structure.one_equation_per_fault();
    let mut placement = Placement { sensors: Vec::new(), complete: true };
    let mut level: BTreeSet<Vec<usize>> = BTreeSet::from([Vec::new()]);
    let mut effort = 0;
    while !level.is_empty() {
        let mut next = BTreeSet::new();
        for sensors in level {
            if placement.sensors.iter().any(|known| is_part(known, &sensors)) {
                continue;
            }
            effort += 1;
            if effort > EFFORT {
                placement.complete = false;
                return placement;
            }
            let with = sensors
                .iter()
                .fold(structure.clone(), |with, &sensor| with.with_sensor(sensor, faulty.contains(&sensor)));
            let Some(demand) = demand(&with) else {
                placement.sensors.push(sensors);
                continue;
            };
            if sensors.len() == most {
                placement.complete = false;
                continue;
            }
            for sensor in demand {
                let mut more = sensors.clone();
                more.push(sensor);
                more.sort_unstable();
                next.insert(more);
            }
        }
        if extent == Extent::Fewest && !placement.sensors.is_empty() {
            break;
        }
        level = next;
    }
    placement
}

/// Whether `part` can be had from `whole` by leaving out members; both sorted, where one unknown may be measured twice.
fn is_part(part: &[usize], whole: &[usize]) -> bool {
    let mut whole = whole.iter();
    part.iter().all(|sensor| whole.any(|other| other == sensor))
}

/// The shortest list of unknowns of which one has to be measured; `None` where nothing is missing that a sensor could
/// give.
fn demand(structure: &Structure) -> Option<Vec<usize>> {
    let rows = structure.rows();
    let equation = structure.equation_of_fault();
    let all = shortest(structure, &rows, None, &equation);
    // Isolation only once all is detectable: leaving out an equation outside the overdetermined part would open the
    // rest.
    all.or_else(|| {
        let each = equation
            .iter()
            .enumerate()
            .filter(|(fault, left_out)| left_out.is_some() && !equation[..*fault].contains(left_out));
        each.filter_map(|(_, left_out)| shortest(structure, &rows, *left_out, &equation)).min_by_key(Vec::len)
    })
}

/// Per fault outside the overdetermined part, when one equation is left out: the measurable unknowns computed from its
/// equation. The shortest such list that is not empty.
fn shortest(
    structure: &Structure,
    rows: &[&[usize]],
    left_out: Option<usize>,
    faults: &[Option<usize>],
) -> Option<Vec<usize>> {
    let keep: Vec<usize> = (0..rows.len()).filter(|&row| Some(row) != left_out).collect();
    let parts = decompose(rows, &keep, structure.unknowns.len());
    let just: BTreeSet<usize> = parts.just.iter().flat_map(|block| block.equations.iter().copied()).collect();
    let mut best: Option<Vec<usize>> = None;
    for start in faults.iter().flatten().filter(|equation| just.contains(equation)) {
        let mut reached = BTreeSet::from([*start]);
        let mut found = Vec::new();
        let mut open = vec![*start];
        while let Some(row) = open.pop() {
            let Some(unknown) = parts.matching.unknown_of[row] else { continue };
            found.push(unknown);
            open.extend(just.iter().copied().filter(|&other| rows[other].contains(&unknown) && reached.insert(other)));
        }
        found.retain(|&unknown| structure.unknowns[unknown].measurable);
        found.sort_unstable();
        if !found.is_empty() && best.as_ref().is_none_or(|best| found.len() < best.len()) {
            best = Some(found);
        }
    }
    best
}
