//! Where the model ends: pressures below vacuum, at which oil would boil and tear.

use std::fmt;

use serde::Serialize;

use super::{InputSignals, Model};
use crate::number::{rounded, text};
use crate::physics::VACUUM;
use crate::rig::{NodeKind, Quantity, Rig, Target};

/// A pressure below vacuum: oil would boil and tear there, which the model does not know.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(feature = "internals", derive(schemars::JsonSchema))]
pub struct BelowVacuum {
    /// The node that falls lowest.
    pub node: String,
    /// When, s.
    pub at_s: f64,
    /// To which gauge pressure, bar.
    pub pressure_bar: f64,
    /// Nodes that fall below vacuum, this one included.
    pub nodes: usize,
}

impl fmt::Display for BelowVacuum {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [pressure, at] = [self.pressure_bar, self.at_s].map(|value| text(rounded(value, 4)));
        write!(
            f,
            "the pressure of node `{}` falls to {pressure} bar at {at} s, below vacuum (-1.013 bar over the atmosphere)",
            self.node
        )?;
        if self.nodes > 1 {
            write!(f, " ({} nodes fall below it)", self.nodes)?;
        }
        f.write_str(": oil would cavitate, which the model does not know, so it is not valid there; many machines have a check valve from the tank for that")
    }
}

impl BelowVacuum {
    /// Of gauge pressures of volumes, Pa, at the times of the rows, s.
    pub(crate) fn of(rig: &Rig, volumes: &[usize], pressures: &[Vec<f64>], times: &[f64]) -> Option<Self> {
        let lowest = |values: &Vec<f64>| values.iter().copied().zip(times).min_by(|a, b| a.0.total_cmp(&b.0));
        let each = volumes.iter().zip(pressures).filter_map(|(&node, values)| Some((node, lowest(values)?)));
        let below: Vec<(usize, (f64, &f64))> = each.filter(|(_, (least, _))| *least < VACUUM).collect();
        let &(node, (least, at)) = below.iter().min_by(|a, b| a.1.0.total_cmp(&b.1.0))?;
        Some(Self {
            node: rig.nodes[node].name.clone(),
            at_s: rounded(*at, 6),
            pressure_bar: rounded(least / 1e5, 4),
            nodes: below.len(),
        })
    }
}

impl Model {
    /// The same rig with a sensor of its pressure at every volume, behind its own sensors, and these volumes: what no sensor shows may be
    /// where the model ends.
    pub(crate) fn showing_volumes(&self) -> (Self, Vec<usize>) {
        let mut rig = self.rig.clone();
        let is_volume = |&node: &usize| matches!(self.rig.nodes[node].kind, NodeKind::Volume { .. });
        let volumes = (0..self.rig.nodes.len())
            .filter(is_volume)
            .filter(|&node| rig.watch(Target::Node(node), Quantity::Pressure));
        let volumes = volumes.collect();
        (Self::new(rig).with_tolerance(self.tolerance), volumes)
    }

    /// Where pressures fall below vacuum with these parameters, SI; `None` where they do not, or the model cannot be solved.
    pub(crate) fn below_vacuum(&self, parameters: &[f64], drive: &InputSignals, times: &[f64]) -> Option<BelowVacuum> {
        let (shown, volumes) = self.showing_volumes();
        let mut all = shown.rig.nominal();
        all.iter_mut().zip(parameters).for_each(|(slot, &value)| *slot = value);
        let outputs = shown.solve(&all, drive, times).ok()?;
        BelowVacuum::of(&self.rig, &volumes, outputs.values.get(self.rig.sensors.len()..)?, times)
    }
}
