//! Worked numbers of cards, evaluated.

use approx::assert_relative_eq;
use borescope::Unit;
use borescope::internals::physics::card::{Answer, Card};
use borescope::internals::physics::fluid::{self, Fluid};
use borescope::internals::physics::ports::{PortFlows, PortVariables};

pub fn unit(symbol: &str) -> Unit {
    Unit::parse(symbol).unwrap()
}

/// Parameters of the fluid as its card has them, SI.
pub fn fluid_of_defaults() -> Vec<f64> {
    fluid::CARD.parameters.iter().map(|p| unit(p.unit).to_si(p.default.unwrap())).collect()
}

/// Each worked number of a card against what its law answers.
pub fn worked_numbers_come_out(
    card: &Card,
    law: impl Fn(&[f64], &Fluid<f64>, &PortVariables<f64>, &mut PortFlows<f64>),
) {
    let fluid = Fluid::new(&fluid_of_defaults());
    for worked in card.worked {
        for (name, _) in worked.parameters {
            assert!(card.parameters.iter().any(|p| p.name == *name), "{} has no {name}", card.kind);
        }
        let parameters: Vec<f64> = card
            .parameters
            .iter()
            .map(|p| {
                let stated =
                    |name: &str| worked.parameters.iter().find(|(own, _)| *own == name).map(|(_, value)| *value);
                let given = p.given(stated);
                // Volumes and the like that the worked number does not depend on.
                unit(p.unit).difference_to_si(given.or(p.default).unwrap_or(1.0))
            })
            .collect();
        let mut seen = PortVariables::default();
        seen.z[..worked.at.len()].copy_from_slice(worked.at);
        seen.u[..worked.inputs.len()].copy_from_slice(worked.inputs);
        let mut answers = PortFlows::default();
        law(&parameters, &fluid, &seen, &mut answers);
        let got = match worked.answer {
            Answer::Through(port) => answers.through[port],
            Answer::Capacity(port) => answers.capacity[port],
            Answer::Rate(state) => answers.rate[state],
        };
        println!("{}: {}: {got:.6e}, expected {:.6e}", card.kind, worked.text, worked.expect);
        assert_relative_eq!(got, worked.expect, max_relative = 1e-3);
    }
}
