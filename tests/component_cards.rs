//! Every component's card: its units read, its sizes fit, and its worked numbers come out.

use approx::assert_relative_eq;
use borescope::physics::card::Answer;
use borescope::physics::component::{Answers, AnyLaw, CARDS, INPUTS, PORTS, STATES, Seen, VARIABLES};
use borescope::physics::fluid::{self, Fluid};
use borescope::units::Unit;

fn unit(symbol: &str) -> Unit {
    Unit::parse(symbol).unwrap()
}

#[test]
fn cards_are_complete() {
    for card in CARDS {
        for text in [card.kind, card.meaning, card.law, card.source, card.validity] {
            assert!(!text.is_empty(), "{}: a text is missing", card.kind);
        }
        assert!(card.variables() <= VARIABLES && card.ports.len() <= PORTS, "{}", card.kind);
        assert!(card.states.len() <= STATES && card.inputs.len() <= INPUTS, "{}", card.kind);
        for parameter in card.parameters {
            unit(parameter.unit);
            assert!(parameter.bounds.0 < parameter.bounds.1, "{}.{}", card.kind, parameter.name);
        }
        for state in card.states {
            unit(state.unit);
        }
        assert_eq!(CARDS.iter().filter(|other| other.kind == card.kind).count(), 1, "{} stands twice", card.kind);
        assert!(!card.worked.is_empty() || card.fixes_pressure.is_some(), "{} has no worked number", card.kind);
    }
}

#[test]
fn worked_numbers_come_out() {
    let fluid_values: Vec<f64> =
        fluid::CARD.parameters.iter().map(|p| unit(p.unit).to_si(p.default.unwrap())).collect();
    let fluid = Fluid::new(&fluid_values);
    for card in CARDS {
        for worked in card.worked {
            for (name, _) in worked.parameters {
                assert!(card.parameters.iter().any(|p| p.name == *name), "{} has no {name}", card.kind);
            }
            let parameters: Vec<f64> = card
                .parameters
                .iter()
                .map(|p| {
                    let given = worked.parameters.iter().find(|(name, _)| *name == p.name).map(|(_, value)| *value);
                    // Volumes and the like that the worked number does not depend on.
                    unit(p.unit).difference_to_si(given.or(p.default).unwrap_or(1.0))
                })
                .collect();
            let mut seen = Seen { z: [0.0; VARIABLES], u: [0.0; INPUTS] };
            seen.z[..worked.at.len()].copy_from_slice(worked.at);
            seen.u[..worked.inputs.len()].copy_from_slice(worked.inputs);
            let mut answers = Answers::default();
            AnyLaw::new(card.kind, &parameters, &fluid).unwrap().evaluate(&seen, &mut answers);
            let got = match worked.answer {
                Answer::Through(port) => answers.through[port],
                Answer::Capacity(port) => answers.capacity[port],
                Answer::Rate(state) => answers.rate[state],
            };
            println!("{}: {}: {got:.6e}, expected {:.6e}", card.kind, worked.text, worked.expect);
            assert_relative_eq!(got, worked.expect, max_relative = 1e-3);
        }
    }
}
