//! The text of a drafted rig file.

use std::fmt::Write;

use toml_edit::Key;

use super::DraftOptions;
use super::roles::{Location, Roles};
use crate::number::{rounded, written};
use crate::record::{Channel, Record};
use crate::units::{Dimension, Quantity};

pub(super) use crate::rig::PLACEHOLDER as OPEN;

/// Pressure of water per level, mbar/m.
const WATER: f64 = 97.9;

const HYDRAULIC_OIL: &str = r#"
[fluid]
density = "870 kg/m3"  # DATA SHEET
viscosity = "40 mPa.s"  # DATA SHEET, at the temperature of the record
bulk_modulus = "14000 bar"  # DATA SHEET
"#;

/// Pump, relief valve, directional valve, cylinder, load; and the columns that the record lacks.
pub(super) fn cylinder(record: &Record, roles: &Roles<'_>, options: &DraftOptions) -> (String, Vec<String>) {
    let mut out = head(record, "cylinder with directional valve") + HYDRAULIC_OIL;
    let at = |quantity, spot| roles.at(quantity, spot);
    let starts = |spot, otherwise: &str| match at("pressure", spot) {
        Some(p) => {
            let first = p.begins_at().map_or_else(|| "0 bar".to_owned(), |si| shown(p, si));
            format!(
                "{{}}  # starts at what its sensor shows first; a cycle without record needs {{ initial = \"{first}\" }}"
            )
        }
        None => format!("{{ initial = \"{otherwise}\" }}"),
    };
    let position = at("position", Location::Piston);
    let begins = position.and_then(|x| Some(shown(x, x.begins_at()?))).unwrap_or_else(|| "0 mm".to_owned());
    let opening = at("pressure", Location::PumpLine).and_then(|p| Some((p, p.range()?.1)));
    let opening = opening.map_or("100 bar".to_owned(), |(p, most)| written(p.unit.from_si(most), 2, &p.unit));
    let given = |quantity: &Option<Quantity>, otherwise: String| match quantity {
        Some(given) => format!("\"{given}\""),
        None => format!("\"{otherwise}\"  {OPEN}"),
    };
    let travel = position.and_then(|x| Some(written(x.unit.from_si(x.range()?.1), 3, &x.unit)));
    let _ = write!(
        out,
        r#"
[nodes]
tank = {{}}
pump_line = {pump_line}
A = {a}
B = {b}
piston = {{ position = "{begins}" }}  # 0 where the rod is in

[components.tank]
kind = "tank"
ports = {{ T = "tank" }}

[components.pump]
kind = "pump"
ports = {{ P = "pump_line", T = "tank" }}
displacement = "5 cc/rev"  {OPEN}
speed = "1500 rev/min"  {OPEN}

[components.pump_line]
kind = "line-volume"
ports = {{ P = "pump_line" }}
volume = "100 cm3"  {OPEN}

[components.relief]
kind = "relief-valve"
ports = {{ P = "pump_line", T = "tank" }}
set_pressure = "{opening}"  {OPEN}
rated_flow = "10 L/min"  {OPEN}
rated_overpressure = "5 bar"  {OPEN}

{valve}
[components.cylinder]
kind = "cylinder"
ports = {{ A = "A", B = "B", rod = "piston" }}
bore = {bore}
rod = {rod}
stroke = {stroke}
dead_volume_A = "50 cm3"  {OPEN}
dead_volume_B = "50 cm3"  {OPEN}
mass = "100 kg"  {OPEN}
viscous_friction = "1 kN.s/m"  {OPEN}
"#,
        valve = valve(roles),
        pump_line = starts(Location::PumpLine, &opening),
        a = starts(Location::A, "balance"),
        b = starts(Location::B, "0 bar"),
        bore = given(&options.bore, "40 mm".to_owned()),
        rod = given(&options.rod, "20 mm".to_owned()),
        stroke = given(&options.stroke, travel.unwrap_or_else(|| "200 mm".to_owned())),
    );
    if roles.load.is_some() {
        out.push_str(
            "\n[components.load]\nkind = \"external-force\"  # a positive force pushes the rod in\nports = { body = \"piston\" }\n\
             force = \"load\"\n",
        );
    }
    out.push_str("\n# hold: a row of the record says what acted before it, or what acts after it.\n");
    match (roles.solenoids, roles.command) {
        (Some(two), _) => {
            for (entry, solenoid) in SOLENOIDS.into_iter().zip(two) {
                let most = solenoid.range().map_or(1.0, |(_, high)| solenoid.unit.from_si(high));
                out.push_str(&switched(entry, solenoid, most, "while it is energised"));
            }
        }
        (None, Some(command)) => {
            let most = command.range().map_or(0.0, |(low, high)| command.unit.from_si(high.abs().max(low.abs())));
            let full = if most > 0.0 { rounded(most, 2) } else { 10.0 };
            out.push_str(&switched("command", command, full, "open it fully"));
        }
        (None, None) => out.push_str("[inputs.command]\nunit = \"-\"\nhold = \"before\"\n"),
    }
    if let Some(load) = roles.load {
        let _ = write!(
            out,
            "\n[inputs.load]\nunit = \"{}\"\n{}hold = \"before\"\nnoise = \"{}\"\n",
            load.unit,
            column("load", load),
            noise(load)
        );
    }
    out.push_str("\n[sensors]  # noise: from the scatter of the column; a flow counts into its port, with direction = \"out\" out of it\n");
    let mut names = Names::default();
    for one in &roles.sensors {
        let place = match (one.quantity, one.spot) {
            ("flow", Location::PumpLine) => "\"directional_valve.P\"",
            ("flow", Location::A) => "\"directional_valve.A\", direction = \"out\"",
            ("flow", _) => "\"directional_valve.B\"",
            (_, Location::PumpLine) => "\"pump_line\"",
            (_, Location::A) => "\"A\"",
            (_, Location::B) => "\"B\"",
            (_, Location::Piston) => "\"piston\"",
        };
        out.push_str(&names.sensor(one.channel, one.quantity, place));
    }
    left(record, roles, &mut out);
    out.push_str(
        "\n[faults]\n\"cylinder.clearance\" = { bounds = [\"0 mm\", \"0.4 mm\"] }\n\"pump.loss\" = { bounds = [0, 0.6] }\n",
    );
    out.push_str(if roles.solenoids.is_some() {
        "\"directional_valve.leakage\" = { bounds = [\"0 L/min/bar\", \"0.1 L/min/bar\"] }\n"
    } else {
        "\"directional_valve.opening\" = { bounds = [0.02, 1.2] }\n\
         \"directional_valve.leak_AT\" = { bounds = [\"0 L/min/bar\", \"0.1 L/min/bar\"] }\n"
    });
    (out, (roles.command.is_none() && roles.solenoids.is_none()).then(|| "command".to_owned()).into_iter().collect())
}

/// Inputs of a valve with two solenoids.
const SOLENOIDS: [&str; 2] = ["solenoid_a", "solenoid_b"];

/// The directional valve: with a command, or with two solenoids.
fn valve(roles: &Roles<'_>) -> String {
    let ports = r#"ports = { P = "pump_line", T = "tank", A = "A", B = "B" }"#;
    if roles.solenoids.is_none() {
        return format!(
            r#"[components.directional_valve]
kind = "directional-valve"  # command 1: P to A and B to T; -1: P to B and A to T
{ports}
command = "command"
rated_flow = "10 L/min"  {OPEN}
rated_drop = "10 bar"  {OPEN}
lag = "20 ms"  {OPEN}
"#
        );
    }
    let [a, b] = SOLENOIDS;
    format!(
        r#"[components.directional_valve]
kind = "catalogue:solenoid-valve"  # a: P to A and B to T; b: P to B and A to T; exchange the columns of the inputs if the machine moves the other way
{ports}
a = "{a}"
b = "{b}"
rated_flow = "10 L/min"  {OPEN}
rated_drop = "10 bar"  {OPEN}
energised_lag = "20 ms"  {OPEN}
released_lag = "30 ms"  {OPEN}
centre_PT = 0  {OPEN}: 0 closed, about 0.5 where the centre lets the pump off to the tank
centre_AT = 0  {OPEN}: open with centre_BT where the cylinder floats
centre_BT = 0  {OPEN}
"#
    )
}

/// An input that opens a valve: a share as it is, a voltage over that at which it is `full`.
fn switched(entry: &str, channel: &Channel, full: f64, what: &str) -> String {
    let mut out = format!("[inputs.{entry}]\nunit = \"-\"\n{}", column(entry, channel));
    let unit = &channel.unit;
    if unit.dimension == Dimension::VOLTAGE {
        let _ = writeln!(out, "scale = \"{}/{unit}\"  {OPEN}: here {full} {unit} {what}", rounded(1.0 / full, 3));
    }
    out + "hold = \"before\"\n"
}

/// A pump, and open tanks in a row.
pub(super) fn reservoirs(record: &Record, roles: &Roles<'_>) -> (String, Vec<String>) {
    let mut out = head(record, "tanks in a row");
    let _ = write!(
        out,
        "\n[fluid]  # water at 20 degC\ndensity = \"998 kg/m3\"\nviscosity = \"1 mPa.s\"\nbulk_modulus = \"2.2 GPa\"\n\n\
         [nodes]\nsump = {{}}\n"
    );
    let count = roles.levels.len().max(1);
    for tank in 1..=count {
        let level = roles.levels.get(tank - 1).and_then(|level| level.begins_at()).unwrap_or(0.0);
        let _ = writeln!(out, "tank_{tank} = {{ initial = \"{} mbar\" }}", rounded(level * WATER, 3));
    }
    let _ = write!(
        out,
        "\n[components.sump]\nkind = \"tank\"\nports = {{ T = \"sump\" }}\n\n[components.pump]\nkind = \"flow-source\"\n\
         ports = {{ P = \"tank_1\", T = \"sump\" }}\nvoltage = \"command\"\ngain = \"1 L/min/V\"  {OPEN}\n"
    );
    for tank in 1..=count {
        let (kind, next) =
            if tank == count { ("orifice", "sump".to_owned()) } else { ("free-outlet", format!("tank_{}", tank + 1)) };
        let _ = write!(
            out,
            "\n[components.tank_{tank}]\nkind = \"reservoir\"\nports = {{ P = \"tank_{tank}\" }}\narea = \"150 cm2\"  {OPEN}\n\n\
             [components.outlet_{tank}]\nkind = \"{kind}\"\nports = {{ in = \"tank_{tank}\", out = \"{next}\" }}\ndiameter = \"8 mm\"  {OPEN}\n\
             transition_pressure = \"0.5 mbar\"\n"
        );
    }
    out.push_str("\n[inputs.command]\nunit = \"V\"\n");
    if let Some(command) = roles.command {
        out.push_str(&column("command", command));
    }
    out.push_str("hold = \"after\"\n\n[sensors]  # noise: from the scatter of the column\n");
    let mut names = Names::default();
    for (index, level) in roles.levels.iter().enumerate() {
        out.push_str(&names.sensor(level, "level", &format!("\"tank_{}\"", index + 1)));
    }
    left(record, roles, &mut out);
    out.push_str("\n[faults]\n");
    for tank in 1..=count {
        let _ = writeln!(out, "\"outlet_{tank}.diameter\" = {{ bounds = [\"2 mm\", \"10 mm\"] }}");
    }
    (out, roles.command.is_none().then(|| "command".to_owned()).into_iter().collect())
}

fn head(record: &Record, name: &str) -> String {
    let file = record.path.file_name().map_or_else(String::new, |file| file.to_string_lossy().into_owned());
    format!(
        "# A draft from the columns of {}. Put in the values marked {}, take away what your circuit does not have,\n\
         # and add what it has: `borescope check` says what is wrong, docs/reference/rig-file.md what there is.\n\n[rig]\nname = \"{name}\"\n",
        crate::visible::visible(&file),
        &OPEN[2..],
    )
}

/// Columns that the draft makes no use of.
fn left(record: &Record, roles: &Roles<'_>, out: &mut String) {
    for channel in record.channels.iter().filter(|channel| roles.of_column(&channel.name).is_none()) {
        let _ = writeln!(out, "# column {} [{}]: not used", channel.name, channel.unit);
        let quantity = if channel.unit.dimension == Dimension::PRESSURE {
            "pressure"
        } else if channel.unit.dimension == Dimension::FLOW {
            "flow"
        } else {
            continue;
        };
        let at = if quantity == "flow" { "COMPONENT.PORT" } else { "NODE" };
        let (column, unit) = (quoted(&channel.name), &channel.unit);
        let _ = writeln!(
            out,
            "#   to use it: NAME = {{ quantity = \"{quantity}\", at = \"{at}\", column = {column}, noise = \"... {unit}\" }}"
        );
    }
}

/// The line that names a column, where the entry has another name.
fn column(entry: &str, channel: &Channel) -> String {
    if entry == channel.name { String::new() } else { format!("column = {}\n", quoted(&channel.name)) }
}

fn quoted(text: &str) -> String {
    toml_edit::Value::from(text).to_string()
}

/// Names of sensors that are taken.
#[derive(Default)]
struct Names(Vec<String>);

impl Names {
    /// The line of a sensor. Ids of parameters hold its name between points, so it has none.
    fn sensor(&mut self, channel: &Channel, quantity: &str, at: &str) -> String {
        let letters = channel.name.chars().map(|letter| if letter.is_alphanumeric() { letter } else { '_' });
        let plain = letters.collect::<String>();
        let numbered = (2..).map(|number| format!("{plain}_{number}"));
        let name =
            std::iter::once(plain.clone()).chain(numbered).find(|name| !self.0.contains(name)).unwrap_or_default();
        let column = if name == channel.name { String::new() } else { format!(", column = {}", quoted(&channel.name)) };
        let digit = channel.unit.difference_from_si(channel.last_digit());
        let resolution = if digit > 0.0 {
            format!(", resolution = \"{}\"", written(digit, 2, &channel.unit))
        } else {
            String::new()
        };
        let line = format!(
            "{} = {{ quantity = \"{quantity}\", at = {at}{column}, noise = \"{}\"{resolution} }}\n",
            Key::new(&name),
            noise(channel)
        );
        self.0.push(name);
        line
    }
}

fn shown(channel: &Channel, si: f64) -> String {
    written(channel.unit.from_si(si), 4, &channel.unit)
}

/// One standard deviation of a sample in the unit of the column, from the second differences of its values: what the circuit does is
/// smooth over three rows, mostly. At least half a digit; a thousandth of the range where they show how the curve bends and no noise.
fn noise(channel: &Channel) -> String {
    /// Second differences over twice the rows are as large where they are noise, and four times as large where the curve bends: between
    /// the two, by their ratio.
    const BENDS: f64 = 2.0;
    let values: Vec<f64> = channel.values.iter().copied().filter(|value| value.is_finite()).collect();
    let scatter = scatter(&values, 1);
    let range = channel.range().map_or(0.0, |(low, high)| high - low);
    let least = match channel.last_digit() {
        digit if digit > 0.0 => digit / 2.0,
        _ if scatter > 0.0 && scatter_over(&values) < BENDS => 0.0,
        _ => 1e-3 * range,
    };
    let sigma = channel.unit.difference_from_si(scatter.max(least));
    // A column that stands still says nothing of its noise.
    written(if sigma > 0.0 { sigma } else { 1.0 }, 2, &channel.unit)
}

/// One standard deviation of white noise whose second differences over so many rows have the median of these.
fn scatter(values: &[f64], rows: usize) -> f64 {
    /// Median of the absolute value over the standard deviation, of normal numbers.
    const MEDIAN: f64 = 0.6745;
    let bend = |three: &[f64]| (three[0] - 2.0 * three[rows] + three[2 * rows]).abs();
    let mut bends: Vec<f64> = values.windows(2 * rows + 1).map(bend).collect();
    bends.sort_by(f64::total_cmp);
    bends.get(bends.len() / 2).map_or(0.0, |median| median / MEDIAN / 6f64.sqrt())
}

/// By how much the scatter over two rows exceeds that over one.
fn scatter_over(values: &[f64]) -> f64 {
    scatter(values, 2) / scatter(values, 1)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::units::Unit;

    /// Numbers that look like noise of this size, by the golden ratio.
    fn noisy(size: f64, row: usize) -> f64 {
        let uniform =
            |row: usize| (row as f64 * 0.618_033_988_75).fract() + (row as f64 * row as f64 * 0.414_213_562).fract();
        size * (uniform(row) + uniform(row + 7) + uniform(row + 31) - 3.0) * 2.0
    }

    fn drafted(values: Vec<f64>) -> f64 {
        let unit = Unit::parse("mm").unwrap();
        let text = noise(&Channel::new("x", unit.clone(), values.into_iter().map(|mm| unit.to_si(mm)).collect()));
        text.trim_end_matches(" mm").parse().unwrap()
    }

    #[test]
    fn noise_below_a_thousandth_of_the_range_is_what_the_column_scatters_by() {
        let stroke = |row: usize| 300.0 * (row as f64 / 1000.0).min(1.0);
        let scattered: Vec<f64> = (0..3000).map(|row| stroke(row) + noisy(0.05, row)).collect();
        let exact = scatter(&(0..3000).map(|row| noisy(0.05, row)).collect::<Vec<_>>(), 1);
        let drafted_as = drafted(scattered);
        assert!((drafted_as / exact - 1.0).abs() < 0.1 && drafted_as < 0.1, "{drafted_as}, {exact}");
        // A curve without noise bends, and its bends are no noise.
        let smooth: Vec<f64> = (0..3000).map(|row| 150.0 * (row as f64 / 200.0).sin() + 150.0).collect();
        assert_eq!(drafted(smooth), 0.3);
    }
}
