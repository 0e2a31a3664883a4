//! What a directional valve connects in its centre, as its own law and values say: drawn from the flow, so that no kind of valve and no
//! name of a parameter has to be known here.

use crate::physics::ATMOSPHERE;
use crate::physics::card::PortKind;
use crate::physics::fluid::{self, Fluid};
use crate::physics::ports::{PortFlows, PortVariables};
use crate::rig::Rig;

/// Ports of the symbol: pressure and tank below, consumers above.
const PORTS: usize = 4;
/// Pressure over that of all other ports, Pa: at a low one a leak, in proportion to it, is small beside an edge, which goes with the root.
const PRESSURE: f64 = 1e5;
/// Share of an edge's flow fully switched from which on two ports are drawn as connected: below it is a leak.
const OPEN: f64 = 0.02;
/// Where the lines of two ports of one side meet, px from the middle.
const BENT: f64 = 8.0;

/// The lines in the middle square of a component's symbol: ports that the centre connects are joined, the others end in a bar.
pub(super) fn path(rig: &Rig, component: usize, ends: &[(f64, f64)]) -> String {
    let groups = connected(rig, component);
    let mut path = String::new();
    for (number, group) in groups.iter().enumerate() {
        if groups[..number].contains(group) {
            continue;
        }
        let members: Vec<(f64, f64)> =
            ends.iter().zip(&groups).filter(|(_, of)| *of == group).map(|(end, _)| *end).collect();
        path.push_str(&lines(&members));
    }
    path
}

/// Lines of ports that are connected with one another; of one alone its bar. The square ends at two thirds of the way to a port's end.
fn lines(members: &[(f64, f64)]) -> String {
    let rim = |y: f64| y / 1.5;
    match *members {
        [(x, y)] => format!("M{x:.0} {:.0}v{:.0}m-5 0h10", rim(y), -BENT * y.signum()),
        [(x, y), (other_x, other_y)] if y != other_y => {
            format!("M{x:.0} {:.0}L{other_x:.0} {:.0}", rim(y), rim(other_y))
        }
        [(x, y), (other_x, _)] => {
            format!("M{x:.0} {:.0}V{:.0}H{other_x:.0}V{:.0}", rim(y), BENT * y.signum(), rim(y))
        }
        _ => {
            let to_middle = members.iter().map(|(x, y)| format!("M{x:.0} {:.0}V0", rim(*y)));
            to_middle.chain([format!("M{:.0} 0H{:.0}", members[0].0, -members[0].0)]).collect()
        }
    }
}

/// For each port the first port that the centre connects it with, itself where it is shut.
fn connected(rig: &Rig, component: usize) -> [usize; PORTS] {
    let mut groups: [usize; PORTS] = std::array::from_fn(|port| port);
    let Some(flows) = flows(rig, component) else { return groups };
    let (centre, switched) = (flows(0.0), [flows(1.0), flows(-1.0)]);
    let widest = switched.iter().flatten().flatten().copied().fold(0.0, f64::max);
    for (from, to) in (0..PORTS).flat_map(|from| (0..from).map(move |to| (from, to))) {
        if centre[from][to].max(centre[to][from]) > OPEN * widest {
            let (keep, drop) = (groups[from].min(groups[to]), groups[from].max(groups[to]));
            groups.iter_mut().filter(|group| **group == drop).for_each(|group| *group = keep);
        }
    }
    groups
}

/// What flows out of each port while another is under pressure, `[under pressure][out of]`, m³/s, at a position of the spool; `None` of
/// what has other ports than the symbol.
fn flows(rig: &Rig, component: usize) -> Option<impl Fn(f64) -> [[f64; PORTS]; PORTS]> {
    let this = &rig.components[component];
    let is_hydraulic = this.card.ports.iter().all(|port| port.kind == PortKind::Hydraulic);
    let values = rig.nominal();
    let fluid = Fluid::new(values.get(..fluid::CARD.parameters.len())?);
    let law = this.law(|index| values[index], &fluid).filter(|_| is_hydraulic && this.card.ports.len() == PORTS)?;
    Some(move |spool: f64| {
        std::array::from_fn(|pressed| {
            let mut seen = PortVariables::<f64>::default();
            seen.z[..PORTS].fill(ATMOSPHERE);
            seen.z[pressed] += PRESSURE;
            // A valve without a spool of its own follows its command at once.
            (seen.z[PORTS], seen.u[0]) = (spool, spool);
            let mut answers = PortFlows::default();
            law.evaluate(&seen, &mut answers);
            answers.through.map(|into| (-into).max(0.0))
        })
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::circuit::symbol::Symbol;

    const RIG: &str = r#"
[fluid]
density = "870 kg/m3"
viscosity = "40 mPa.s"
bulk_modulus = "14000 bar"

[nodes]
tank = {}
P = { initial = "0 bar" }
A = { initial = "0 bar" }
B = { initial = "0 bar" }

[components]
tank = { kind = "tank", ports = { T = "tank" } }
volume_P = { kind = "line-volume", ports = { P = "P" }, volume = "100 cm3" }
volume_A = { kind = "line-volume", ports = { P = "A" }, volume = "100 cm3" }
volume_B = { kind = "line-volume", ports = { P = "B" }, volume = "100 cm3" }
valve = { kind = "KIND", ports = { P = "P", T = "tank", A = "A", B = "B" }, rated_flow = "40 L/min", VALUES }

[inputs.a]
unit = "-"
[inputs.b]
unit = "-"
"#;

    fn drawn(kind: &str, values: &str) -> String {
        let mut text = RIG.replace("KIND", kind).replace("VALUES", values);
        if !values.contains("b = \"b\"") {
            text = text.replace("[inputs.b]\nunit = \"-\"\n", "");
        }
        let rig = Rig::parse("rig.toml", text).unwrap_or_else(|told| panic!("{told}"));
        let valve = rig.components.iter().position(|component| component.name == "valve").unwrap();
        path(&rig, valve, Symbol::DirectionalValve.ends())
    }

    #[test]
    fn the_centre_is_drawn_as_the_values_have_it() {
        let bar = |x: i32, y: i32| format!("M{x} {y}v{}m-5 0h10", if y > 0 { -8 } else { 8 });
        let shut = [bar(-10, 20), bar(10, 20), bar(-10, -20), bar(10, -20)].concat();
        let solenoids = |centre: &str| drawn("catalogue:solenoid-valve", &format!("a = \"a\", b = \"b\"{centre}"));
        assert_eq!(solenoids(""), shut);
        // A leak is no opening.
        assert_eq!(solenoids(", leakage = \"0.02 L/min/bar\""), shut);
        assert_eq!(
            solenoids(", centre_PT = 0.5"),
            ["M-10 20V8H10V20".to_owned(), bar(-10, -20), bar(10, -20)].concat()
        );
        let float = [bar(-10, 20), "M10 20V0M-10 -20V0M10 -20V0M10 0H-10".to_owned()].concat();
        assert_eq!(solenoids(", centre_AT = 0.25, centre_BT = 0.25"), float);
        let open = "M-10 20V0M10 20V0M-10 -20V0M10 -20V0M-10 0H10";
        assert_eq!(solenoids(", centre_PT = 1, centre_AT = 1, centre_BT = 1, centre_PA = 1, centre_PB = 1"), open);

        let switched = "command = \"a\", rated_drop = \"5 bar\", lag = \"20 ms\"";
        assert_eq!(drawn("directional-valve", switched), shut);
        let servo = |lap: &str| {
            drawn("catalogue:servo-valve", &format!("command = \"a\", natural_frequency = \"60 Hz\", lap = \"{lap}\""))
        };
        assert_eq!((servo("3 %"), servo("-10 %").as_str()), (shut, open));
    }
}
