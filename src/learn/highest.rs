//! How high a level or a pressure rises at a component over a record: levels and beginnings of effects are tried below that.

use crate::diagnosis::estimate::Estimate;
use crate::model::{InputSignals, Model};
use crate::rig::{Location, NodeKind, Quantity, Rig, Target};

/// The highest level, m, or pressure, Pa, at the node of the first port of a component, in the fitted model.
pub(super) fn highest(estimate: &Estimate<'_>, spot: Location, quantity: Quantity) -> f64 {
    let Location::Component(component) = spot else { return 0.0 };
    let full = &estimate.case.full;
    let (rig, values) = (&full.model.rig, full.parameters(&estimate.isolation.best.theta));
    highest_at(rig, &values, (full.drive, full.times), rig.components[component].ports[0], quantity)
}

/// The same at a node of a rig with values of all of its parameters, SI; 0 where it has none.
pub(super) fn highest_at(
    rig: &Rig,
    values: &[f64],
    (drive, times): (&InputSignals, &[f64]),
    node: usize,
    quantity: Quantity,
) -> f64 {
    if !matches!(rig.nodes[node].kind, NodeKind::Volume { .. }) {
        return 0.0;
    }
    let shown = readings(rig, values, (drive, times), &[(Target::Node(node), quantity)]);
    shown.map_or(0.0, |shown| shown.into_iter().flatten().fold(f64::NEG_INFINITY, f64::max))
}

/// What virtual sensors of these quantities would read, SI, `[sensor][row]`; `None` where the model cannot be solved.
pub(super) fn readings(
    rig: &Rig,
    values: &[f64],
    (drive, times): (&InputSignals, &[f64]),
    watched: &[(Target, Quantity)],
) -> Option<Vec<Vec<f64>>> {
    let (mut rig, before) = (rig.clone(), rig.sensors.len());
    let mut values = values.to_vec();
    for &(target, quantity) in watched {
        if !rig.watch(target, quantity) {
            return None;
        }
        values.extend([0.0, 1.0]);
    }
    Some(Model::new(rig).solve(&values, drive, times).ok()?.values.split_off(before))
}
