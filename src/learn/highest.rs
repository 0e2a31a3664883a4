//! How high a level or a pressure rises at a component over a record: levels and beginnings of effects are tried below that.

use crate::diagnosis::estimate::Estimate;
use crate::model::{InputSignals, Model};
use crate::rig::{Location, NodeKind, Quantity, Rig};

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
    let shown = readings(rig, values, (drive, times), node, quantity);
    shown.map_or(0.0, |shown| shown.into_iter().fold(f64::NEG_INFINITY, f64::max))
}

/// What a virtual sensor of a quantity at a node would read, SI; `None` where the model cannot be solved.
pub(super) fn readings(
    rig: &Rig,
    values: &[f64],
    (drive, times): (&InputSignals, &[f64]),
    node: usize,
    quantity: Quantity,
) -> Option<Vec<f64>> {
    let mut rig = rig.clone();
    if !rig.watch(node, quantity) {
        return None;
    }
    let values = [values, &[0.0, 1.0]].concat();
    Model::new(rig).solve(&values, drive, times).ok()?.values.pop()
}
