//! Effects in a rig: where they may sit, and how they are called there.

use super::{Component, NodeKind, Rig};
use crate::complaint::{Complaint, Kind, Place, help_with_names};
use crate::physics::card::{Card, PortKind};
use crate::physics::component::facts;
use crate::physics::component::facts::Symbol;
use crate::physics::effect::{At, EFFECTS, Effect, Form, FreeParameter, InitialGuess, Joint};
use crate::units::Unit;

/// An effect at its place in a rig.
#[derive(Debug, Clone, Copy)]
pub struct EffectInstance {
    pub effect: &'static Effect,
    pub spot: Location,
}

/// Where an effect sits, as an index into the rig.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Location {
    Fluid,
    Node(usize),
    Component(usize),
    Sensor(usize),
}

/// An effect that a rig has.
#[derive(Debug, Clone)]
pub struct InstalledEffect {
    /// `kind@place`.
    pub id: String,
    pub placed: EffectInstance,
    /// Indices of its parameters, in the order of the effect.
    pub parameters: Vec<usize>,
}

/// What an effect does to the readings of a sensor.
#[derive(Debug, Clone)]
pub struct Readings {
    pub card: &'static Card,
    pub sensor: usize,
    pub first_parameter: usize,
}

/// A parameter of an effect as it is to be: SI, with its standard uncertainty (0: exact).
#[derive(Debug, Clone, PartialEq)]
pub struct ParameterSetting {
    pub name: String,
    pub value: f64,
    pub sigma: f64,
}

impl Rig {
    /// Every effect at every place where this rig may have it, in the order of the library.
    #[doc(hidden)]
    pub fn effect_places(&self) -> Vec<EffectInstance> {
        self.effect_names()
            .flat_map(|effect| self.spots(effect).into_iter().map(move |spot| EffectInstance { effect, spot }))
            .collect()
    }

    /// Those of some effects that are not the same law at the same nodes as one before them, such as the friction of the second of two
    /// cylinders that move one body: what one does is what the other does.
    pub(crate) fn distinct(&self, placed: Vec<EffectInstance>) -> Vec<EffectInstance> {
        let mut kept: Vec<EffectInstance> = Vec::new();
        for one in placed {
            if !kept.iter().any(|other| self.is_same_law(other, &one)) {
                kept.push(one);
            }
        }
        kept
    }

    /// Whether two effects at their places are one law at the same nodes.
    pub(crate) fn is_same_law(&self, a: &EffectInstance, b: &EffectInstance) -> bool {
        let (Location::Component(first), Location::Component(second)) = (a.spot, b.spot) else { return false };
        let value = |component: usize, name: &str| {
            self.parameter(&format!("{}.{name}", self.components[component].name)).map(|at| self.parameters[at].value)
        };
        let alike = |name: &str| value(first, name) == value(second, name);
        let [one, other] = [first, second].map(|at| &self.components[at]);
        a.effect.name == b.effect.name
            && match a.effect.form {
                Form::Shunt { joints, shared, .. } => {
                    self.joints(a.spot, joints) == self.joints(b.spot, joints)
                        && shared.iter().all(|(_, theirs)| alike(theirs))
                }
                Form::ParameterChange => {
                    one.card.kind == other.card.kind
                        && one.ports == other.ports
                        && one.card.parameters.iter().all(|own| alike(own.name))
                }
                Form::Series { .. } | Form::PressureLoss { .. } | Form::Reading { .. } => false,
            }
    }

    fn spots(&self, effect: &'static Effect) -> Vec<Location> {
        match effect.at {
            At::Fluid(_) => vec![Location::Fluid],
            At::Warmth(_) => self.temperature.iter().map(|_| Location::Fluid).collect(),
            At::Node => {
                let volume = |&node: &usize| matches!(self.nodes[node].kind, NodeKind::Volume { .. });
                (0..self.nodes.len()).filter(volume).map(Location::Node).collect()
            }
            At::Actuator => {
                let actuated = |&node: &usize| {
                    matches!(self.nodes[node].kind, NodeKind::Volume { .. }) && self.actuators(node).next().is_some()
                };
                (0..self.nodes.len()).filter(actuated).map(Location::Node).collect()
            }
            At::Return => {
                // Two such lines in series are one.
                let has_one = |node: &usize| {
                    let mut lines =
                        self.components.iter().filter(|component| Some(component.card.kind) == kind(effect));
                    lines.any(|line| line.ports.contains(node))
                };
                let drained = (0..self.nodes.len()).filter(|&node| self.draining(node).next().is_some());
                drained.filter(|node| !has_one(node)).map(Location::Node).collect()
            }
            At::Component { card, .. } => self.components_with(|component| component.card.kind == card.kind),
            At::Like { symbol, .. } => {
                let mut spots = self.components_with(|component| facts(component.card).symbol == symbol);
                spots.retain(|spot| self.has_what_it_needs(effect, *spot));
                spots
            }
            At::Sensor => (0..self.sensors.len()).map(Location::Sensor).collect(),
            At::NamedSensor(name) => {
                self.sensors.iter().position(|sensor| sensor.name == name).map(Location::Sensor).into_iter().collect()
            }
            At::Named(name) => self.node(name).map(Location::Node).into_iter().collect(),
            At::NamedComponent(name) => {
                let own = self.components.iter().position(|component| component.name == name);
                own.map(Location::Component).into_iter().collect()
            }
        }
    }

    fn components_with(&self, does: impl Fn(&Component) -> bool) -> Vec<Location> {
        let own = self.components.iter().enumerate().filter(|(_, component)| does(component));
        own.map(|(index, _)| Location::Component(index)).collect()
    }

    /// Whether a component has the ports and the parameters that an effect takes from it.
    fn has_what_it_needs(&self, effect: &'static Effect, spot: Location) -> bool {
        let Form::Shunt { joints, shared, .. } = effect.form else { return true };
        let Location::Component(component) = spot else { return true };
        let card = self.components[component].card;
        self.joints(spot, joints).is_some()
            && shared.iter().all(|(_, theirs)| card.parameters.iter().any(|own| own.name == *theirs))
    }

    /// Every effect that this rig may have: the library's, those of its components, then its own.
    fn effect_names(&self) -> impl Iterator<Item = &'static Effect> {
        EFFECTS.iter().chain(&self.own_effects).copied()
    }

    /// Components that move a body or turn a shaft and have a port at this node, with the port.
    pub(super) fn actuators(&self, node: usize) -> impl Iterator<Item = (usize, usize)> {
        let moves = |component: &&Component| component.moves_a_body() || facts(component.card).symbol == Symbol::Motor;
        self.components.iter().enumerate().filter(move |(_, component)| moves(component)).flat_map(
            move |(index, component)| {
                let here = component.ports.iter().enumerate().filter(move |(_, at)| **at == node);
                here.map(move |(port, _)| (index, port))
            },
        )
    }

    /// Directional valves that drain into this node, with the port.
    pub(super) fn draining(&self, node: usize) -> impl Iterator<Item = (usize, usize)> {
        let valves = self.components.iter().enumerate();
        let valves = valves.filter(|(_, component)| facts(component.card).symbol == Symbol::DirectionalValve);
        valves.flat_map(move |(index, component)| {
            let ports = component.card.ports.iter().zip(&component.ports).enumerate();
            ports.filter(move |(_, (port, at))| port.name == "T" && **at == node).map(move |(port, _)| (index, port))
        })
    }

    /// The name of an effect at its place, `kind@place`, or the kind alone where the place goes without saying.
    #[doc(hidden)]
    pub fn effect_id(&self, placed: &EffectInstance) -> String {
        let effect = placed.effect;
        let place = match placed.spot {
            Location::Fluid => None,
            Location::Node(node) => Some(&self.nodes[node].name),
            Location::Sensor(sensor) => Some(&self.sensors[sensor].name),
            Location::Component(component) => {
                let said = matches!(
                    effect.at,
                    At::Component { named: true, .. } | At::Like { named: true, .. } | At::NamedComponent(_)
                ) || self.spots(effect).len() > 1;
                said.then(|| &self.components[component].name)
            }
        };
        place.map_or_else(|| effect.name.to_owned(), |place| format!("{}@{place}", effect.name))
    }

    /// The effect of this name at its place.
    ///
    /// # Errors
    /// An effect that is not in the library, or a place where this rig cannot have it.
    #[doc(hidden)]
    pub fn placed(&self, id: &str) -> Result<EffectInstance, Complaint> {
        let (name, place) = id.split_once('@').map_or((id, None), |(name, place)| (name, Some(place)));
        // The library and components may have effects of one name, each at places of its own.
        let alike: Vec<&'static Effect> = self.effect_names().filter(|effect| effect.name == name).collect();
        if alike.is_empty() {
            return Err(Complaint::new(Kind::UnknownName, format!("there is no effect `{name}`"))
                .at(Place::file(&self.path))
                .help(help_with_names(name, "effects", self.effect_names().map(|effect| effect.name))));
        }
        let places = |effect: &&'static Effect| {
            let effect = *effect;
            self.spots(effect).into_iter().map(move |spot| EffectInstance { effect, spot })
        };
        let all: Vec<EffectInstance> = alike.iter().flat_map(places).collect();
        let ids: Vec<String> = all.iter().map(|placed| self.effect_id(placed)).collect();
        let found = match place {
            Some(place) => all.iter().find(|placed| self.spot_name(placed.spot) == Some(place)),
            None if all.len() == 1 => all.first(),
            None => None,
        };
        found.copied().ok_or_else(|| {
            let complaint = Complaint::new(Kind::UnknownName, format!("this rig cannot have the effect `{id}`"))
                .at(Place::file(&self.path));
            if ids.is_empty() {
                complaint.help(format!("`{name}` needs {}", needs(alike[0].at)))
            } else {
                complaint.help(help_with_names(id, "places", ids.iter().map(String::as_str)))
            }
        })
    }

    /// The one of some names in a rig file by which it has the effect of this id, which may say a place that need not be said; the id
    /// itself where none does.
    pub(crate) fn effect_among<'a>(&self, mut names: impl Iterator<Item = &'a str>, id: &'a str) -> &'a str {
        let is_it = |name: &&str| self.placed(name).is_ok_and(|placed| self.effect_id(&placed) == id);
        names.find(is_it).unwrap_or(id)
    }

    fn spot_name(&self, spot: Location) -> Option<&str> {
        match spot {
            Location::Fluid => None,
            Location::Node(node) => Some(&self.nodes[node].name),
            Location::Component(component) => Some(&self.components[component].name),
            Location::Sensor(sensor) => Some(&self.sensors[sensor].name),
        }
    }

    /// Unit of a parameter of an effect at its place, as the rig file writes it.
    #[doc(hidden)]
    pub fn effect_unit(&self, placed: &EffectInstance, name: &str) -> Unit {
        let Some(card) = placed.effect.form.card() else {
            let index = self.bent(placed, name);
            return index.map_or_else(Unit::dimensionless, |index| self.parameters[index].unit.clone());
        };
        match (card.parameters.iter().find(|own| own.name == name).map(|own| own.unit), placed.spot) {
            // A reading's own limits are in the unit of the sensor.
            (Some("-"), Location::Sensor(sensor)) if card.formula.is_none() => self.sensor_unit(&self.sensors[sensor]),
            (Some(unit), _) => Unit::parse(unit).unwrap_or_else(|_| Unit::dimensionless()),
            (None, _) => Unit::dimensionless(),
        }
    }

    /// What is tried first of a parameter of an effect, SI; `None` of a level, which has to be looked for.
    pub(crate) fn first_size(&self, placed: &EffectInstance, free: &FreeParameter) -> Option<f64> {
        let unit = || self.effect_unit(placed, free.name);
        match (free.first, placed.spot) {
            (InitialGuess::Value(value) | InitialGuess::Onset(value), _) => Some(unit().difference_to_si(value)),
            (InitialGuess::Noise(factor), Location::Sensor(sensor)) => Some(factor * self.sensors[sensor].noise),
            (InitialGuess::Noise(_), _) => Some(unit().difference_to_si(1.0)),
            (InitialGuess::Range(_), _) => None,
        }
    }

    /// Index of the parameter that an effect bends.
    #[doc(hidden)]
    pub fn bent(&self, placed: &EffectInstance, name: &str) -> Option<usize> {
        let owner = match placed.spot {
            Location::Fluid => "fluid".to_owned(),
            Location::Sensor(sensor) => format!("sensor.{}", self.sensors[sensor].name),
            Location::Component(component) => self.components[component].name.clone(),
            Location::Node(_) => return None,
        };
        self.parameter(&format!("{owner}.{name}"))
    }

    /// The nodes that the ports of a joined effect meet; `None` without a tank or a port where one is needed.
    pub(super) fn joints(&self, spot: Location, joints: &[Joint]) -> Option<Vec<usize>> {
        let tank = self.components.iter().find(|component| component.card.fixes_pressure.is_some());
        let tank = tank.map(|component| component.ports[0]);
        let port = |kind: PortKind, nth: usize| match spot {
            Location::Component(component) => {
                let component = &self.components[component];
                let ports = component.card.ports.iter().zip(&component.ports);
                ports.filter(|(port, _)| port.kind == kind).nth(nth).map(|(_, node)| *node)
            }
            _ => None,
        };
        let here = match spot {
            Location::Node(node) => Some(node),
            Location::Component(component) => self.components[component].ports.first().copied(),
            _ => None,
        };
        joints
            .iter()
            .map(|joint| match joint {
                Joint::Here => here,
                Joint::Tank => tank,
                Joint::Hydraulic(nth) => port(PortKind::Hydraulic, *nth),
                Joint::Body | Joint::Load => port(PortKind::Mechanical, 0),
                Joint::Next => self.next(here?).or(tank),
                Joint::Named(name) => self.node(name),
            })
            .collect()
    }

    /// Ports of components whose flows, or forces, a meter at a port reads together: that port, and those of effects inside the component
    /// that meet it, as the slip of a pump, which never leaves its housing, or the friction of a seal.
    pub fn metered(&self, component: usize, port: usize) -> Vec<(usize, usize)> {
        let ports = self.components[component].card.ports;
        let nth = ports[..port].iter().filter(|other| other.kind == ports[port].kind).count();
        let met = match (ports[port].kind, nth) {
            (PortKind::Hydraulic, nth) => Some(Joint::Hydraulic(nth)),
            (PortKind::Mechanical, 0) => Some(Joint::Body),
            (PortKind::Mechanical, _) => None,
        };
        let inside = self.effects.iter().filter(|effect| effect.placed.spot == Location::Component(component));
        let beside = inside.flat_map(|effect| {
            let joints = if let Form::Shunt { joints, .. } = effect.placed.effect.form { joints } else { &[] };
            let joined = self.components.iter().position(|joined| joined.name == effect.id);
            let meets = joints.iter().enumerate().filter(move |(_, joint)| met == Some(**joint));
            joined.into_iter().flat_map(move |joined| meets.clone().map(move |(own, _)| (joined, own)))
        });
        std::iter::once((component, port)).chain(beside).collect()
    }

    /// The node into which a reservoir's outlet drains.
    fn next(&self, node: usize) -> Option<usize> {
        self.components
            .iter()
            .filter(|component| matches!(facts(component.card).symbol, Symbol::Orifice | Symbol::FreeOutlet))
            .find(|component| component.ports[0] == node)
            .map(|component| component.ports[1])
    }
}

/// The kind of the component that an effect joins.
fn kind(effect: &Effect) -> Option<&'static str> {
    effect.form.card().map(|card| card.kind)
}

fn needs(at: At) -> String {
    match at {
        At::Fluid(_) => "a fluid".to_owned(),
        At::Warmth(_) => "the column of a temperature: `temperature` in `[fluid]`".to_owned(),
        At::Node => "a node with a volume".to_owned(),
        At::Actuator => "a node with a cylinder or a motor".to_owned(),
        At::Return => "a node into which a directional valve drains".to_owned(),
        At::Component { card, .. } => format!("a `{}`", card.kind),
        At::Like { symbol, .. } => format!("{} with the ports and parameters that it needs", symbol.words()),
        At::Sensor => "a sensor".to_owned(),
        At::Named(node) => format!("the node `{node}`"),
        At::NamedSensor(sensor) => format!("the sensor `{sensor}`"),
        At::NamedComponent(component) => format!("the component `{component}`"),
    }
}
