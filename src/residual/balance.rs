//! Flows that nobody measures at their port but that follow from the mass balance of its node.

use super::known::Parameters;
use super::reading::Readings;
use super::view::View;
use crate::numeric::Real;
use crate::physics::component::facts;
use crate::physics::component::facts::Balance as Passes;
use crate::rig::{NodeKind, Quantity, Rig, Target};

/// One share of a flow.
#[derive(Debug, Clone, PartialEq)]
enum Term {
    /// A measured flow.
    Measured { reading: usize, sign: f64 },
    /// What the volume at a port takes up: capacity times rate of pressure.
    Stored { view: View, port: usize, rate: usize, sign: f64 },
    /// What the law of a component lets into a port at the measured quantities.
    Law { view: View, port: usize, sign: f64 },
}

/// A flow into one port, or the sum over several ports of one node, from measured channels.
#[derive(Debug, Clone, Default, PartialEq)]
pub(super) struct Balance {
    terms: Vec<Term>,
    /// Check valves that are taken as shut: inlet and outlet pressures and cracking pressure must say so.
    pub shut: Vec<View>,
}

/// How many such components a balance may reach across.
const REACH: usize = 3;

impl Balance {
    /// Flow into a port: its sensor, or else the balance of its node.
    pub fn into_port(rig: &Rig, component: usize, port: usize, readings: &mut Readings) -> Option<Self> {
        let mut balance = Self::default();
        balance.add_port(rig, (component, port), 1.0, readings, REACH)?;
        Some(balance)
    }

    /// Sum of the flows into `ports`, all of one node, from everything else that meets there.
    pub fn of_node(rig: &Rig, ports: &[(usize, usize)], readings: &mut Readings) -> Option<Self> {
        let mut balance = Self::default();
        balance.add_node(rig, ports, 1.0, readings, REACH)?;
        Some(balance)
    }

    fn add_port(
        &mut self,
        rig: &Rig,
        at: (usize, usize),
        sign: f64,
        readings: &mut Readings,
        reach: usize,
    ) -> Option<()> {
        if let Some((reading, own)) = readings.port(rig, at.0, at.1) {
            self.terms.push(Term::Measured { reading, sign: sign * own });
            // A meter at a part reads what effects inside it pass too.
            for inside in rig.metered(at.0, at.1).into_iter().skip(1) {
                self.add_law(rig, inside, sign, readings)?;
            }
            return Some(());
        }
        self.add_node(rig, &[at], sign, readings, reach)
    }

    fn add_node(
        &mut self,
        rig: &Rig,
        ports: &[(usize, usize)],
        sign: f64,
        readings: &mut Readings,
        reach: usize,
    ) -> Option<()> {
        let &(first, port) = ports.first()?;
        let node = rig.components[first].ports[port];
        if reach == 0 || matches!(rig.nodes[node].kind, NodeKind::Held { .. }) {
            return None;
        }
        // What an effect inside a part passes is in the reading of a meter at that part.
        let metered: Vec<(usize, usize)> = rig
            .sensors
            .iter()
            .filter_map(|sensor| if let Target::Port(part, port) = sensor.target { Some((part, port)) } else { None })
            .flat_map(|(part, port)| rig.metered(part, port).into_iter().skip(1))
            .collect();
        for (index, component) in rig.parts() {
            for (port, _) in component.ports.iter().enumerate().filter(|(_, joined)| **joined == node) {
                let balance = facts(component.card).balance;
                if matches!(balance, Passes::Stores | Passes::Chamber | Passes::LawAndStores) {
                    let rate = readings.node(rig, node, Quantity::Pressure, 1)?;
                    let view = View::of(rig, index, readings)?;
                    self.terms.push(Term::Stored { view, port, rate, sign: -sign });
                }
                if ports.contains(&(index, port)) || balance == Passes::Stores || metered.contains(&(index, port)) {
                    continue;
                }
                if let Some((reading, own)) = readings.port(rig, index, port) {
                    self.terms.push(Term::Measured { reading, sign: -sign * own });
                } else if matches!(balance, Passes::OneWay { .. }) {
                    self.shut.push(View::of(rig, index, readings)?);
                } else if balance == Passes::Through {
                    self.add_port(rig, (index, 1 - port), sign, readings, reach - 1)?;
                } else if balance == Passes::ThroughOrLaw {
                    self.add_across_or_law(rig, (index, port), sign, readings, reach)?;
                } else if matches!(balance, Passes::Law | Passes::LawAndStores) {
                    self.add_law(rig, (index, port), sign, readings)?;
                } else {
                    return None;
                }
            }
        }
        Some(())
    }

    /// Takes the flow into a port off: as it is measured beyond the component, which owes nothing to its parameters, or as its
    /// law says.
    fn add_across_or_law(
        &mut self,
        rig: &Rig,
        (component, port): (usize, usize),
        sign: f64,
        readings: &mut Readings,
        reach: usize,
    ) -> Option<()> {
        let (mut across, mut tried) = (self.clone(), readings.clone());
        let found = across.add_port(rig, (component, 1 - port), sign, &mut tried, reach - 1);
        if found.is_some() && across.terms[self.terms.len()..].iter().all(|term| !matches!(term, Term::Law { .. })) {
            (*self, *readings) = (across, tried);
            return Some(());
        }
        self.add_law(rig, (component, port), sign, readings)
    }

    fn add_law(&mut self, rig: &Rig, at: (usize, usize), sign: f64, readings: &mut Readings) -> Option<()> {
        let (component, port) = at;
        // A port that only looks at the pressure takes nothing, whatever is measured.
        if rig.components[component].card.own.is_some_and(|own| !own.passes(port)) {
            return Some(());
        }
        let view = View::of(rig, component, readings)?;
        self.terms.push(Term::Law { view, port, sign: -sign });
        Some(())
    }

    /// Whether a flow in it follows from the law of a component.
    pub fn has_law(&self) -> bool {
        self.terms.iter().any(|term| matches!(term, Term::Law { .. }))
    }

    /// Components whose law the balance evaluates.
    pub fn components(&self) -> impl Iterator<Item = usize> {
        self.terms.iter().filter_map(|term| match term {
            Term::Stored { view, .. } | Term::Law { view, .. } => Some(view.component),
            Term::Measured { .. } => None,
        })
    }

    /// The flow in m³/s, positive into the port.
    pub fn flow<T: Real>(&self, p: &Parameters<T>, x: &[T]) -> T {
        self.terms.iter().fold(T::zero(), |sum, term| {
            sum + match term {
                Term::Measured { reading, sign } => x[*reading] * *sign,
                Term::Stored { view, port, rate, sign } => view.answers(p, x).capacity[*port] * x[*rate] * *sign,
                Term::Law { view, port, sign } => view.answers(p, x).through[*port] * *sign,
            }
        })
    }

    /// The measured flows alone, without what the volumes take up: how the paper reads its equations.
    pub fn measured<T: Real>(&self, x: &[T]) -> T {
        self.terms.iter().fold(T::zero(), |sum, term| match term {
            Term::Measured { reading, sign } => sum + x[*reading] * *sign,
            Term::Stored { .. } | Term::Law { .. } => sum,
        })
    }
}
