//! Which of a component's answers depend on what: found by evaluating its law with dual numbers at scattered points.
//!
//! So no list has to be kept beside the laws. A dependence counts if its derivative is not zero somewhere: what only
//! acts in one position of a valve, or at an end stop, is part of the structure.

use crate::numeric::{Dual, Real};
use crate::physics::card::PortKind;
use crate::physics::fluid::{self, Fluid};
use crate::physics::ports::{INPUTS, PORTS, PortFlows, PortVariables, STATES, VARIABLES};
use crate::rig::{Component, Rig};
use crate::units::Unit;

/// Points at which each law is evaluated. The narrowest known range, in which a flow control valve regulates, is met by
/// one point in a hundred.
const POINTS: usize = 2048;
/// Directions of one evaluation: at least as many as variables and inputs.
const DIRECTIONS: usize = 8;

type Number = Dual<f64, DIRECTIONS>;

/// What one answer depends on.
#[derive(Debug, Clone, Default)]
pub struct Dependence {
    /// By the component's variables, in the order of its card.
    pub variables: [bool; VARIABLES],
    pub inputs: [bool; INPUTS],
    /// Places in the list of parameters asked about.
    pub parameters: Vec<usize>,
    /// Whether the answer is ever anything but zero.
    pub present: bool,
}

/// The dependence of every answer of a component.
#[derive(Debug, Clone, Default)]
pub struct Dependences {
    pub through: [Dependence; PORTS],
    pub capacity: [Dependence; PORTS],
    pub rate: [Dependence; STATES],
}

impl Dependences {
    fn each<'a>(
        &'a mut self,
        answers: &'a PortFlows<Number>,
    ) -> impl Iterator<Item = (&'a mut Dependence, &'a Number)> {
        let through = self.through.iter_mut().zip(&answers.through);
        through.chain(self.capacity.iter_mut().zip(&answers.capacity)).chain(self.rate.iter_mut().zip(&answers.rate))
    }
}

/// What the answers of `component` depend on. `asked` are parameters of the rig with the ranges in which they vary; all
/// others stay at their values.
pub fn probe(rig: &Rig, component: &Component, asked: &[(usize, (f64, f64))]) -> Dependences {
    let mut found = Dependences::default();
    let mut random = Random(0x5eed);
    let own: Vec<usize> = component.parameters().collect();
    let shared = fluid::CARD.parameters.len();
    let relevant: Vec<usize> =
        (0..asked.len()).filter(|&index| own.contains(&asked[index].0) || asked[index].0 < shared).collect();
    let nominal = rig.nominal();
    for _ in 0..POINTS {
        let mut parameters: Vec<Number> = nominal.iter().map(|&value| Number::constant(value)).collect();
        for &index in &relevant {
            let (parameter, range) = asked[index];
            parameters[parameter] = Number::constant(random.within(range, nominal[parameter]));
        }
        let seen = point(component, &mut random);
        let mut evaluate =
            |parameters: &[Number], seen: &PortVariables<Number>, note: &dyn Fn(&mut Dependence, usize)| {
                let fluid = Fluid::new(&parameters[..shared]);
                let Some(law) = component.law(|index| parameters[index], &fluid) else { return };
                let mut answers = PortFlows::default();
                law.evaluate(seen, &mut answers);
                for (dependence, answer) in found.each(&answers) {
                    dependence.present |= answer.re != 0.0;
                    let acts = |slope: &f64| *slope != 0.0 && slope.is_finite();
                    (0..DIRECTIONS).filter(|&direction| acts(&answer.eps[direction])).for_each(|d| note(dependence, d));
                }
            };
        let mut moved = seen;
        for (direction, value) in moved.z.iter_mut().chain(&mut moved.u).enumerate() {
            *value = Number::variable(value.re, direction);
        }
        evaluate(&parameters, &moved, &|dependence, direction| match direction.checked_sub(VARIABLES) {
            None => dependence.variables[direction] = true,
            Some(input) => dependence.inputs[input] = true,
        });
        for chunk in relevant.chunks(DIRECTIONS) {
            let mut moved = parameters.clone();
            for (direction, &index) in chunk.iter().enumerate() {
                let parameter = asked[index].0;
                moved[parameter] = Number::variable(moved[parameter].re, direction);
            }
            evaluate(&moved, &seen, &|dependence, direction| {
                if !dependence.parameters.contains(&chunk[direction]) {
                    dependence.parameters.push(chunk[direction]);
                }
            });
        }
    }
    found
}

/// A point with magnitudes of any size: 1 kPa to 1 GPa, 10 um to 10 m, 0.1 mm/s to 10 m/s, states around their scale.
fn point(component: &Component, random: &mut Random) -> PortVariables<Number> {
    let mut values = Vec::with_capacity(VARIABLES);
    for port in component.card.ports {
        match port.kind {
            PortKind::Hydraulic => values.push(random.magnitude(3.0, 9.0)),
            PortKind::Mechanical => {
                values.push(random.signed(-5.0, 1.0));
                values.push(random.signed(-4.0, 1.0));
            }
        }
    }
    for state in component.card.states {
        let scale = state.scale * Unit::parse(state.unit).map_or(1.0, |unit| unit.factor);
        values.push(scale * random.signed(-3.0, 1.0));
    }
    let mut seen: PortVariables<Number> = PortVariables::default();
    seen.z.iter_mut().zip(values).for_each(|(place, value)| *place = Number::constant(value));
    seen.u.iter_mut().for_each(|place| *place = Number::constant(random.signed(-3.0, 4.0)));
    seen
}

/// Fixed sequence of scattered numbers (SplitMix64).
struct Random(u64);

impl Random {
    /// From 0 to 1.
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut bits = self.0;
        bits = (bits ^ (bits >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        bits = (bits ^ (bits >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((bits ^ (bits >> 31)) >> 11) as f64 / (1u64 << 53) as f64
    }

    /// From `10^low` to `10^high`, each decade alike.
    fn magnitude(&mut self, low: f64, high: f64) -> f64 {
        10f64.powf(low + (high - low) * self.next())
    }

    fn signed(&mut self, low: f64, high: f64) -> f64 {
        let magnitude = self.magnitude(low, high);
        if self.next() < 0.5 { -magnitude } else { magnitude }
    }

    /// Within a range; around `value` where the range has no end.
    fn within(&mut self, (low, high): (f64, f64), value: f64) -> f64 {
        if low.is_finite() && high.is_finite() {
            low + (high - low) * self.next()
        } else {
            (value * (0.5 + self.next())).max(low).min(high)
        }
    }
}
