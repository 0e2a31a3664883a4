//! The law of an effect that was found, over the axis of a curve without a formula that acts where it does.

use super::acting::{Acting, Ports, answers, determined, fluid_of};
use super::fitted_model::FittedModel;
use super::states::Axis;
use crate::model::InputSignals;
use crate::physics::component::AnyLaw;
use crate::physics::ports::PortVariables;
use crate::rig::{InstalledEffect, NodeKind, Quantity, Rig};

/// An effect that was found, in the model that has it.
#[derive(Debug, Clone, Copy)]
pub struct Found<'a> {
    pub model: &'a FittedModel,
    pub effect: &'a InstalledEffect,
    /// Values of the rig without it, SI.
    pub nominal: &'a [f64],
    /// Share of it that the model lacks which is asked what is missing.
    pub lacking: f64,
}

/// The law of an effect over the axis of a curve that acts at the same nodes.
pub(super) struct LawOnAxis {
    acting: Acting,
    of_effect: Ports,
    /// The curve with all heights one: how it turns a height into a flow or a force.
    unit_curve: AnyLaw<f64>,
    of_curve: Ports,
    /// Where the axis stands among the variables of the curve and of the effect, where it sees it.
    axis: (usize, Option<usize>),
    over_pressure: bool,
    /// State on the axis, SI, with what effect and curve see in that row, by state.
    rows: Vec<(f64, PortVariables<f64>, PortVariables<f64>)>,
    /// Share of the law that the state on the axis determines.
    pub determined: f64,
}

/// Rows count where the curve turns a height into at least this share of the flow or force that it does at most: below it, where a
/// piston turns round or two chambers are at one pressure, it says nothing.
const TURNS: f64 = 0.5;

impl LawOnAxis {
    /// `None` where the effect adds nothing, or not at the nodes of the curve, which is the last component of `rig` with these heights.
    pub fn of(
        found: &Found<'_>,
        run: (&InputSignals, &[f64]),
        rig: &Rig,
        heights: &[usize],
        axis: &Axis,
    ) -> Option<Self> {
        let (with, all) = (&found.model.rig, &found.model.values);
        let acting = Acting::of(with, all, found.nominal, found.effect)?;
        let (of_effect, of_curve) = (Ports::of(with, acting.component), Ports::of(rig, rig.components.len() - 1));
        let variables = of_curve.variables();
        let on_axis = variables.iter().position(|variable| variable.1 == axis.quantity)?;
        let in_effect = of_effect.variables().iter().position(|variable| *variable == variables[on_axis]);
        let height = |index: usize| if heights.contains(&index) { 1.0 } else { rig.parameters[index].value };
        let unit_curve = rig.components.last()?.law(height, &fluid_of(all))?;
        let rows = of_effect.seen(with, all, run)?.into_iter().zip(of_curve.seen(with, all, run)?);
        let mut law = Self {
            acting,
            of_effect,
            unit_curve,
            of_curve,
            axis: (on_axis, in_effect),
            over_pressure: axis.quantity == Quantity::Pressure,
            rows: rows.map(|(effect, curve)| (0.0, effect, curve)).collect(),
            determined: 0.0,
        };
        if !law.acts_at_the_same_nodes(rig) {
            return None;
        }
        let turned = |row: &(f64, _, PortVariables<f64>)| answers(&law.unit_curve, &row.2).through[0].abs();
        let most = law.rows.iter().map(turned).fold(0.0, f64::max);
        let kept: Vec<bool> = law.rows.iter().map(|row| turned(row) >= TURNS * most).collect();
        let mut kept = kept.into_iter();
        law.rows.retain(|_| kept.next().unwrap_or(false));
        let states: Vec<f64> = law.rows.iter().map(|row| law.state(&row.2)).collect();
        law.rows.iter_mut().zip(states).for_each(|(row, state)| row.0 = state);
        let along: (Vec<f64>, Vec<f64>) = law.rows.iter().map(|row| (row.0, law.height(&row.1, &row.2))).unzip();
        law.determined = determined(&along.0, &along.1);
        law.rows.sort_by(|a, b| a.0.total_cmp(&b.0));
        (law.determined > 0.0).then_some(law)
    }

    fn state(&self, curve: &PortVariables<f64>) -> f64 {
        if self.over_pressure { curve.z[0] - curve.z[1] } else { curve.z[self.axis.0] }
    }

    /// Nodes whose pressure is held do not notice.
    fn acts_at_the_same_nodes(&self, rig: &Rig) -> bool {
        let moves = |node: usize| rig.nodes.get(node).is_none_or(|node| !matches!(node.kind, NodeKind::Held { .. }));
        let nodes = |ports: &Ports, through: &dyn Fn(usize) -> bool| {
            let acts = ports.nodes.iter().enumerate().filter(|(port, (_, node))| moves(*node) && through(*port));
            let mut nodes: Vec<usize> = acts.map(|(_, port)| port.1).collect();
            nodes.sort_unstable();
            nodes
        };
        let of_curve = nodes(&self.of_curve, &|port| {
            self.rows.iter().any(|row| answers(&self.unit_curve, &row.2).through[port] != 0.0)
        });
        let of_effect =
            nodes(&self.of_effect, &|port| self.rows.iter().any(|row| self.acting.through(&row.1, port) != 0.0));
        of_curve == of_effect
    }

    /// The height of the curve that does what the effect does, SI.
    fn height(&self, effect: &PortVariables<f64>, curve: &PortVariables<f64>) -> f64 {
        let node = self.of_curve.nodes[0].1;
        let ports = self.of_effect.nodes.iter().enumerate().filter(|(_, port)| port.1 == node);
        let adds: f64 = ports.map(|(port, _)| self.acting.through(effect, port)).sum();
        adds / answers(&self.unit_curve, curve).through[0]
    }

    /// The same at a state on the axis, SI, all other states as in the row that is nearest to it.
    pub fn at(&self, state: f64) -> f64 {
        let above = self.rows.partition_point(|row| row.0 < state);
        let near = [above.checked_sub(1), Some(above)].into_iter().flatten().filter_map(|row| self.rows.get(row));
        let Some((_, effect, curve)) = near.min_by(|a, b| (a.0 - state).abs().total_cmp(&(b.0 - state).abs())) else {
            return f64::NAN;
        };
        let (mut effect, mut curve) = (*effect, *curve);
        curve.z[self.axis.0] = state + if self.over_pressure { curve.z[1] } else { 0.0 };
        if let Some(axis) = self.axis.1 {
            effect.z[axis] = curve.z[self.axis.0];
        }
        self.height(&effect, &curve)
    }
}
