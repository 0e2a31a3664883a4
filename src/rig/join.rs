//! Components that are joined to a rig in memory.

use super::{Component, NodeKind, Parameter, Rig, range};
use crate::complaint::{Complaint, Kind, Place};
use crate::physics::card::{Card, PortKind};
use crate::units::Unit;

impl Rig {
    /// Joins one more component, behind all others; its parameters come behind all others too, so that every index keeps
    /// its meaning. `ports` are nodes in the order of the card, `values` parameters that differ from their defaults, SI.
    /// The component's parameters are taken as exact.
    ///
    /// # Errors
    /// A name that is taken; ports that do not fit the card; a card with inputs that is no formula, or that keeps the pressure
    /// of a node; a value that is missing or outside its bounds.
    pub(crate) fn join(
        &mut self,
        name: &str,
        card: &'static Card,
        ports: &[usize],
        values: &[(&str, f64)],
    ) -> Result<(), Complaint> {
        let place = Place::file(&self.path);
        let refuse = |kind, what: String| {
            Err(Complaint::new(kind, format!("`{name}` cannot be joined: {what}")).at(Place::file(&self.path)))
        };
        if self.components.iter().any(|component| component.name == name) {
            return refuse(Kind::Duplicate, "there is one of this name".to_owned());
        }
        let fits = |(kind, &node): (PortKind, &usize)| match self.nodes.get(node).map(|node| &node.kind) {
            Some(NodeKind::Body { .. }) => kind == PortKind::Mechanical,
            Some(NodeKind::Volume { .. } | NodeKind::Held { .. }) => kind == PortKind::Hydraulic,
            None => false,
        };
        if ports.len() != card.ports.len() || !card.ports.iter().map(|port| port.kind).zip(ports).all(fits) {
            return refuse(Kind::Shape, format!("its nodes are not what the ports of a `{}` meet", card.kind));
        }
        let inputs: Option<Vec<usize>> =
            card.inputs.iter().map(|input| self.inputs.iter().position(|own| own.name == input.name)).collect();
        let Some(inputs) =
            inputs.filter(|inputs| card.fixes_pressure.is_none() && (inputs.is_empty() || card.formula.is_some()))
        else {
            return refuse(Kind::Contradiction, format!("a `{}` drives the circuit", card.kind));
        };
        if let Some((unknown, _)) = values.iter().find(|(key, _)| card.parameters.iter().all(|own| own.name != *key)) {
            return refuse(Kind::UnknownName, format!("a `{}` has no `{unknown}`", card.kind));
        }
        let mut parameters = Vec::new();
        for own in card.parameters {
            let unit = Unit::parse(own.unit).unwrap_or_else(|_| Unit::dimensionless());
            let bounds = (unit.difference_to_si(own.bounds.0), unit.difference_to_si(own.bounds.1));
            let given = own.given(|name| values.iter().find(|(key, _)| *key == name).map(|(_, value)| *value));
            let Some(value) = given.or_else(|| card.default_of(own).map(|default| unit.difference_to_si(default)))
            else {
                return refuse(Kind::MissingEntry, format!("its `{}` is not given", own.name));
            };
            if !(bounds.0..=bounds.1).contains(&value) {
                return refuse(Kind::Bounds, format!("its `{}` is outside the physical bounds", own.name))
                    .map_err(|complaint| complaint.help(format!("{}: {}", own.meaning, range(bounds, &unit))));
            }
            parameters.push(Parameter {
                id: format!("{name}.{}", own.name),
                unit,
                value,
                bounds,
                sigma: 0.0,
                per_event: false,
                role: own.role,
                spread: 0.0,
                meaning: own.meaning.to_owned(),
                place: place.clone(),
            });
        }
        self.components.push(Component {
            name: name.to_owned(),
            card,
            ports: ports.to_vec(),
            inputs,
            first_parameter: self.parameters.len(),
            initial: vec![None; card.states.len()],
            usual_start: vec![false; card.states.len()],
            margin: false,
            drop: None,
            place,
        });
        self.parameters.extend(parameters);
        Ok(())
    }
}
