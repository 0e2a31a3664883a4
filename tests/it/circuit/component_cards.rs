//! Every component's card: its units read, its sizes fit, and its worked numbers come out.

use std::cell::Cell;

use crate::support::cards;

use borescope::internals::numeric::{Dual, Real};
use borescope::internals::physics::ATMOSPHERE;
use borescope::internals::physics::component::{AnyLaw, CARDS};
use borescope::internals::physics::fluid::Fluid;
use borescope::internals::physics::ports::{INPUTS, PORTS, PortFlows, PortVariables, STATES, VARIABLES};
use cards::unit;

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
        assert_eq!(CARDS.iter().filter(|other| other.kind == card.kind).count(), 1, "{} appears twice", card.kind);
        assert!(!card.worked.is_empty() || card.fixes_pressure.is_some(), "{} has no worked number", card.kind);
    }
}

#[test]
fn worked_numbers_come_out() {
    for card in CARDS {
        cards::worked_numbers_come_out(card, |parameters, fluid, seen, answers| {
            AnyLaw::new(card, parameters, fluid).unwrap().evaluate(seen, answers);
        });
    }
}

#[test]
fn what_throttles_passes_more_the_larger_the_drop() {
    // Behind a loss in its line a law is solved for one flow, which it has only where it rises.
    let at_hand = ATMOSPHERE + 100e5;
    for card in CARDS.iter().filter(|card| card.throttles) {
        cards::worked_numbers_come_out(card, |parameters, fluid, seen, answers| {
            let law = AnyLaw::new(card, parameters, fluid).unwrap();
            law.evaluate(seen, answers);
            let flow = |drop: f64| {
                let (mut moved, mut other) = (*seen, *answers);
                (moved.z[0], moved.z[1]) = (at_hand + drop, at_hand);
                law.evaluate(&moved, &mut other);
                assert_eq!(other.through[0], -other.through[1], "{}: what enters leaves", card.kind);
                other.through[0]
            };
            let flows: Vec<f64> = (-1000..=1000).map(|tenths| flow(f64::from(tenths) * 1e4)).collect();
            assert!(flows.is_sorted(), "{} throttles, but its flow falls where the drop rises", card.kind);
        });
    }
}

/// A law is evaluated at rest too, where nothing flows and nothing moves, and with each parameter at the ends that its card allows.
#[test]
fn laws_and_their_slopes_are_finite_at_rest_whatever_a_rig_file_may_say() {
    type Slopes = Dual<f64, VARIABLES>;
    let fluid: Vec<Slopes> = cards::fluid_of_defaults().into_iter().map(Dual::constant).collect();
    let fluid = Fluid::new(&fluid);
    for card in CARDS {
        cards::worked_numbers_come_out(card, |parameters, plain, seen, answers| {
            AnyLaw::new(card, parameters, plain).unwrap().evaluate(seen, answers);
            let at_rest = |variable: usize| if variable < card.hydraulic_ports() { ATMOSPHERE } else { 0.0 };
            for (place, parameter) in card.parameters.iter().enumerate() {
                let (low, high) = parameter.bounds;
                let ends = [low, high].map(|end| unit(parameter.unit).difference_to_si(end));
                // What has to be positive has the least number there is as its end.
                let sensible = |end: &f64| *end == 0.0 || (1e-100..1e100).contains(&end.abs());
                for value in ends.into_iter().filter(sensible) {
                    let mut all: Vec<Slopes> = parameters.iter().map(|&value| Dual::constant(value)).collect();
                    all[place] = Dual::constant(value);
                    let law = AnyLaw::new(card, &all, &fluid).unwrap();
                    let mut rest = PortVariables::<Slopes>::default();
                    for (variable, slot) in rest.z.iter_mut().enumerate() {
                        *slot = Dual::variable(at_rest(variable), variable);
                    }
                    rest.fluidity = Dual::constant(seen.fluidity);
                    let mut got = PortFlows::<Slopes>::default();
                    law.evaluate(&rest, &mut got);
                    let told = got.through.iter().chain(&got.capacity).chain(&got.rate);
                    let finite =
                        told.into_iter().all(|one| one.re.is_finite() && one.eps.iter().all(|e| e.is_finite()));
                    assert!(finite, "{} at rest with {} = {value} (SI): {got:?}", card.kind, parameter.name);
                }
            }
        });
    }
}

#[test]
fn a_card_says_whether_its_law_sees_the_viscosity() {
    for card in CARDS {
        let differs = Cell::new(false);
        cards::worked_numbers_come_out(card, |parameters, fluid, seen, answers| {
            let law = AnyLaw::new(card, parameters, fluid).unwrap();
            law.evaluate(seen, answers);
            let (mut thinner, mut other) = (*seen, *answers);
            thinner.fluidity = 2.0 * seen.fluidity;
            law.evaluate(&thinner, &mut other);
            if (0..PORTS).any(|port| other.through[port] != answers.through[port]) {
                differs.set(true);
            }
        });
        // What a gap passes need not show in its worked number, but what shows has to be said.
        assert!(
            card.sees_viscosity || !differs.get(),
            "{} uses `seen.fluidity` and does not say `sees_viscosity`",
            card.kind
        );
    }
}
