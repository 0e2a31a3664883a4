//! What an effect becomes in a rig: a component beside the others, a loss ahead of a port, other parameters, other readings.

use super::effect::{EffectInstance, InstalledEffect, Location, ParameterSetting, Readings};
use super::{Drop, InitialPressure, Node, NodeKind, Parameter, Rig};
use crate::complaint::{Complaint, Kind, Place};
use crate::physics::card::Card;
use crate::physics::effect::{At, Effect, Form};

impl Rig {
    /// Gives the rig an effect, and returns the indices of its parameters in the order of the effect. New parameters come
    /// behind all others, so that every index keeps its meaning.
    ///
    /// # Errors
    /// An effect that the rig has already; a parameter that the effect does not have, or a value outside its bounds.
    #[doc(hidden)]
    pub fn give_effect(
        &mut self,
        placed: &EffectInstance,
        given: &[ParameterSetting],
    ) -> Result<Vec<usize>, Complaint> {
        let id = self.effect_id(placed);
        if self.effects.iter().any(|present| present.id == id) {
            return Err(Complaint::new(Kind::Duplicate, format!("the rig has the effect `{id}` already"))
                .at(Place::file(&self.path)));
        }
        let indices = self.attach(placed, &id, given)?;
        self.effects.push(InstalledEffect { id, placed: *placed, parameters: indices.clone() });
        Ok(indices)
    }

    /// Makes an effect part of the model under a name, which its components and parameters take.
    pub(super) fn attach(
        &mut self,
        placed: &EffectInstance,
        id: &str,
        given: &[ParameterSetting],
    ) -> Result<Vec<usize>, Complaint> {
        let refuse = |kind, what: String| Err(Complaint::new(kind, what).at(Place::file(&self.path)));
        let indices: Vec<usize> = match placed.effect.form {
            Form::ParameterChange => {
                let own: Option<Vec<usize>> =
                    placed.effect.parameters.iter().map(|free| self.bent(placed, free.name)).collect();
                let Some(own) = own else { return refuse(Kind::UnknownName, format!("nothing for `{id}` to bend")) };
                own
            }
            Form::Shunt { card, joints, shared } => {
                let nodes = self.joints(placed.spot, joints);
                let Some(nodes) = nodes else {
                    return refuse(Kind::MissingEntry, format!("the effect `{id}` needs a tank in the rig"));
                };
                let mut values: Vec<(&str, f64)> =
                    given.iter().map(|given| (given.name.as_str(), given.value)).collect();
                if let Location::Component(component) = placed.spot {
                    for (own, theirs) in shared.iter().filter(|(own, _)| given.iter().all(|given| given.name != *own)) {
                        let id = format!("{}.{theirs}", self.components[component].name);
                        values.extend(self.parameter(&id).map(|index| (*own, self.parameters[index].value)));
                    }
                }
                let first = self.parameters.len();
                self.join(id, card, &nodes, &values)?;
                free_indices(card, placed.effect, first)
            }
            Form::Series { card } => {
                let Location::Node(node) = placed.spot else {
                    return refuse(Kind::Contradiction, format!("`{id}` needs a node"));
                };
                let beyond = self.nodes.len();
                let drains = matches!(placed.effect.at, At::Return);
                let moved: Vec<(usize, usize)> =
                    if drains { self.draining(node).collect() } else { self.actuators(node).collect() };
                // A chamber has its oil; a motor has none, nor has what drains.
                let has_oil = moved.iter().any(|(component, _)| self.components[*component].moves_a_body());
                let own = self.nodes[node].clone();
                self.nodes.push(Node { name: format!("{} beyond {id}", own.name), ..own.clone() });
                for (component, port) in moved {
                    self.components[component].ports[port] = beyond;
                }
                if own.kind == (NodeKind::Volume { initial: InitialPressure::Balance }) && !drains {
                    self.nodes[node].kind = NodeKind::Volume { initial: InitialPressure::Like(beyond) };
                } else {
                    self.nodes[beyond].kind = NodeKind::Volume { initial: InitialPressure::Like(node) };
                }
                let first = self.parameters.len();
                let values: Vec<(&str, f64)> = given.iter().map(|given| (given.name.as_str(), given.value)).collect();
                let ends = if has_oil { [node, beyond] } else { [beyond, node] };
                self.join(id, card, &ends, &values)?;
                free_indices(card, placed.effect, first)
            }
            Form::Reading { card } => {
                let Location::Sensor(sensor) = placed.spot else {
                    return refuse(Kind::Contradiction, format!("`{id}` needs a sensor"));
                };
                let first = self.parameters.len();
                self.give_parameters(placed, card, id, given)?;
                self.readings.push(Readings { card, sensor, first_parameter: first });
                free_indices(card, placed.effect, first)
            }
            Form::PressureLoss { card } => {
                let Location::Component(component) = placed.spot else {
                    return refuse(Kind::Contradiction, format!("`{id}` needs a component"));
                };
                if self.components[component].drop.is_some() {
                    let name = &self.components[component].name;
                    return refuse(
                        Kind::Duplicate,
                        format!("`{name}` loses pressure to another effect than `{id}` already"),
                    );
                }
                let first_parameter = self.parameters.len();
                self.give_parameters(placed, card, id, given)?;
                self.components[component].drop = Some(Drop { card, first_parameter });
                free_indices(card, placed.effect, first_parameter)
            }
        };
        for given in given {
            let own = placed.effect.parameters.iter().position(|free| free.name == given.name);
            let Some(index) = own.map(|own| indices[own]) else { continue };
            let parameter = &mut self.parameters[index];
            if !(parameter.bounds.0..=parameter.bounds.1).contains(&given.value) {
                let what = format!("`{}` is outside its physical bounds", parameter.id);
                return Err(Complaint::new(Kind::Bounds, what).at(Place::file(&self.path)).help(format!(
                    "{}: {}",
                    parameter.meaning,
                    super::range(parameter.bounds, &parameter.unit)
                )));
            }
            (parameter.value, parameter.sigma, parameter.per_event) = (given.value, given.sigma, false);
        }
        Ok(indices)
    }

    /// The parameters of an effect's card behind all others, as given or else at their defaults.
    fn give_parameters(
        &mut self,
        placed: &EffectInstance,
        card: &Card,
        id: &str,
        given: &[ParameterSetting],
    ) -> Result<(), Complaint> {
        for own in card.parameters {
            let unit = self.effect_unit(placed, own.name);
            let default = own.default.map(|default| unit.difference_to_si(default));
            let Some(value) = given.iter().find(|given| given.name == own.name).map(|given| given.value).or(default)
            else {
                return Err(Complaint::new(Kind::MissingEntry, format!("the effect `{id}` has no `{}`", own.name))
                    .at(Place::file(&self.path)));
            };
            // A limit in the unit of a sensor may have either sign.
            let low = if own.unit == "-" && card.formula.is_none() {
                f64::NEG_INFINITY
            } else {
                unit.difference_to_si(own.bounds.0)
            };
            self.parameters.push(Parameter {
                id: format!("{id}.{}", own.name),
                bounds: (low, unit.difference_to_si(own.bounds.1)),
                unit,
                value,
                sigma: 0.0,
                per_event: false,
                role: own.role,
                spread: 0.0,
                meaning: own.meaning.to_owned(),
                place: Place::file(&self.path),
            });
        }
        Ok(())
    }
}

fn free_indices(card: &Card, effect: &Effect, first: usize) -> Vec<usize> {
    let place = |name| card.parameters.iter().position(|own| own.name == name).unwrap_or(0);
    effect.parameters.iter().map(|free| first + place(free.name)).collect()
}
