//! Where nodes start that start at what their sensors show.

use crate::complaint::{Complaint, Kind};
use crate::numeric::Scalar;
use crate::physics::GRAVITY;
use crate::record::Record;
use crate::rig::{InitialPressure, NodeKind, Quantity, Rig, Target};

/// Readings that are taken for the beginning in any case: so few that little happens meanwhile.
const READINGS: usize = 3;
/// Standard deviations by which the means of two stretches of readings may differ for the first to count as at rest. One comparison in
/// twenty fails by chance, so one alone is not believed: what moves fails the next, over twice the time, by far.
const AT_REST: f64 = 2.0;

/// What a sensor shows of its node at the start, of which the rig file says nothing.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Shown {
    /// Index of a sensor of a pressure, a level, a position or a state.
    pub sensor: usize,
    /// The reading, and one standard deviation of it by noise, SI.
    pub value: f64,
    /// One standard deviation of `value` by noise, SI.
    pub sigma: f64,
    /// Rate of the reading, SI per s.
    pub rate: f64,
}

/// What a sensor shows of the pressure or level of a node at the start.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct FirstReading {
    /// The reading, SI; 0 where nothing shows it.
    pub shown: f64,
    /// One standard deviation of `shown` by noise, SI.
    pub sigma: f64,
    /// Index of the sensor that shows it.
    pub sensor: Option<usize>,
}

impl FirstReading {
    /// The gauge pressure, Pa, free of the offset and gain of the sensor among these parameters, SI: a sensor that is off must not start
    /// the circuit off.
    pub fn freed<S: Scalar>(&self, rig: &Rig, parameters: &[S]) -> S {
        let Some(sensor) = self.sensor.map(|sensor| &rig.sensors[sensor]) else { return S::constant(self.shown) };
        let (offset, gain) = (parameters[sensor.first_parameter], parameters[sensor.first_parameter + 1]);
        let gain = if gain.re() > 0.0 { gain } else { S::one() };
        let value = (S::constant(self.shown) - offset) / gain;
        if sensor.quantity == Quantity::Level { value * (parameters[0] * GRAVITY) } else { value }
    }

    /// One standard deviation of the same by noise, Pa.
    pub fn freed_sigma(&self, rig: &Rig, parameters: &[f64]) -> f64 {
        let further = Self { shown: self.shown + self.sigma, ..*self };
        (further.freed(rig, parameters) - self.freed(rig, parameters)).abs()
    }

    /// What the sensor would show of the same start with other parameters than `found`, SI.
    #[must_use]
    pub fn shown_with(self, rig: &Rig, found: &[f64], other: &[f64]) -> Self {
        let Some(sensor) = self.sensor else { return self };
        let shown = Shown { sensor, value: self.shown, sigma: 0.0, rate: 0.0 }.shown_with(rig, found, other);
        Self { shown: shown.value, ..self }
    }
}

impl Shown {
    /// What the sensor would show of the same start with other parameters than `found`, SI.
    #[must_use]
    pub fn shown_with(self, rig: &Rig, found: &[f64], other: &[f64]) -> Self {
        let own = rig.sensors[self.sensor].first_parameter;
        let gain = other[own + 1] / found[own + 1];
        Self { value: (self.value - found[own]) * gain + other[own], rate: self.rate * gain, ..self }
    }
}

/// Mean of the readings from the beginning on, and how many: twice as many as long as those that are added show the same. What
/// begins to move within the second half leaves the first alone; what accelerates within the first shows seven times as much in the
/// second.
fn at_rest(values: &[f64], sigma: f64) -> Option<(f64, usize)> {
    let values: Vec<f64> = values.iter().copied().filter(|value| value.is_finite()).collect();
    let mean = |values: &[f64]| values.iter().sum::<f64>() / values.len() as f64;
    // A stated noise above what the readings show would hide that they move.
    let shown = |values: &[f64]| {
        let squares: f64 = values.windows(2).map(|pair| (pair[1] - pair[0]).powi(2)).sum();
        (0.5 * squares / (values.len() - 1) as f64).sqrt()
    };
    let rests = |count: usize| {
        let sigma = sigma.min(shown(&values[..(4 * count).min(values.len())]));
        let (first, second) = (&values[..2 * count], &values[2 * count..(4 * count).min(values.len())]);
        let scatter = sigma * (1.0 / first.len() as f64 + 1.0 / second.len() as f64).sqrt();
        (mean(second) - mean(first)).abs() <= AT_REST * scatter
    };
    let compared = |count: usize| 3 * count <= values.len() && count > 0;
    let mut count = READINGS.min(values.len());
    while compared(count) {
        count = match (rests(count), 2 * count) {
            (true, twice) => twice,
            (false, twice) if compared(twice) && rests(twice) => 2 * twice,
            (false, _) => break,
        };
    }
    (count > 0).then(|| (mean(&values[..count]), count))
}

/// Where bodies begin of which the rig file says that the record shows it: the mean of the readings at rest of the first sensor
/// that has any. They begin at the speed of the rig file.
pub(super) fn positions(rig: &Rig, record: &Record) -> Result<Vec<Shown>, Complaint> {
    let mut shown = Vec::new();
    for (index, node) in rig.nodes.iter().enumerate() {
        let NodeKind::Body { position: None, velocity } = node.kind else { continue };
        let mut found = None;
        for (number, sensor) in rig.sensors.iter().enumerate() {
            if sensor.target == Target::Node(index) && sensor.quantity == Quantity::Position && found.is_none() {
                let sigma = sensor.variance().sqrt();
                let gain = rig.parameters[sensor.first_parameter + 1].value;
                found = at_rest(&rig.sensor_column(record, sensor)?.values, sigma).map(|(value, count)| Shown {
                    sensor: number,
                    value,
                    sigma: sigma / (count as f64).sqrt(),
                    rate: velocity * gain,
                });
            }
        }
        shown.push(found.ok_or_else(|| {
            Complaint::new(
                Kind::MissingEntry,
                format!("nothing shows where `{}` begins: its sensor has no value", node.name),
            )
            .at(node.place.clone())
            .at(record.header())
            .help("write where it begins, such as `position = \"0 mm\"`, or take a record in which its sensor works")
        })?);
    }
    Ok(shown)
}

/// Where states of components begin of which the rig file says nothing: the mean of the readings at rest of the first sensor of each that
/// has any. A shaft that creeps under its load does not begin at the speed 0 of its kind.
pub(super) fn states(rig: &Rig, record: &Record) -> Vec<Shown> {
    let mut shown: Vec<Shown> = Vec::new();
    for (number, sensor) in rig.sensors.iter().enumerate() {
        let Target::State(component, state) = sensor.target else { continue };
        let known = shown.iter().any(|other| rig.sensors[other.sensor].target == sensor.target);
        if known || !rig.components[component].usual_start[state] {
            continue;
        }
        let Ok(channel) = rig.sensor_column(record, sensor) else { continue };
        let sigma = sensor.variance().sqrt();
        shown.extend(at_rest(&channel.values, sigma).map(|(value, count)| Shown {
            sensor: number,
            value,
            sigma: sigma / (count as f64).sqrt(),
            rate: 0.0,
        }));
    }
    shown
}

/// Mean of the readings at rest of each node that starts at what its sensor shows: of several sensors the first that shows something.
pub(super) fn readings(rig: &Rig, record: &Record) -> Result<Vec<FirstReading>, Complaint> {
    let mut readings: Vec<Option<FirstReading>> = vec![None; rig.nodes.len()];
    let by_record = |node: usize| rig.nodes[node].kind == (NodeKind::Volume { initial: InitialPressure::Record });
    for (index, sensor) in rig.sensors.iter().enumerate() {
        let Target::Node(node) = sensor.target else { continue };
        let is_pressure = matches!(sensor.quantity, Quantity::Pressure | Quantity::Level);
        if !is_pressure || readings[node].is_some() || !by_record(node) {
            continue;
        }
        let channel = rig.sensor_column(record, sensor)?;
        let sigma = sensor.variance().sqrt();
        let Some((shown, count)) = at_rest(&channel.values, sigma) else { continue };
        readings[node] = Some(FirstReading { shown, sigma: sigma / (count as f64).sqrt(), sensor: Some(index) });
    }
    for (index, node) in rig.nodes.iter().enumerate() {
        if readings[index].is_none() && by_record(index) {
            let what = format!("nothing shows where node `{}` starts: its sensor is dead or has no value", node.name);
            return Err(Complaint::new(Kind::MissingEntry, what).at(node.place.clone()).at(record.header()).help(
                "write how it starts: `initial = \"20 bar\"` in its line, or take a record in which its sensor works",
            ));
        }
    }
    Ok(readings.into_iter().map(Option::unwrap_or_default).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_beginning_at_rest_is_averaged_as_long_as_it_rests() {
        // Noise that alternates, then a run from the 100th reading on.
        let noise = |row: usize| if row.is_multiple_of(2) { 1.0 } else { -1.0 };
        let reading = |row: usize| noise(row) + (row as f64 - 100.0).max(0.0);
        let values: Vec<f64> = (0..300).map(reading).collect();
        let (mean, count) = at_rest(&values, 1.0).unwrap();
        assert!((24..=100).contains(&count) && mean.abs() < 0.05, "{count}: {mean}");
        // What moves at once is read where it begins.
        let (mean, count) = at_rest(&(0..300).map(f64::from).collect::<Vec<_>>(), 0.1).unwrap();
        assert_eq!((mean, count), (1.0, READINGS));
        assert_eq!(at_rest(&[f64::NAN], 1.0), None);
        // Six readings that are high by chance.
        let chance: Vec<f64> = (0..96).map(|row| noise(row) + if row < 6 { 1.4 } else { 0.0 }).collect();
        let (mean, count) = at_rest(&chance, 1.0).unwrap();
        assert!(count >= 48 && mean.abs() < 0.2, "{count}: {mean}");
    }

    #[test]
    fn a_sensor_that_is_off_starts_no_circuit_off() {
        let path = "fixtures/telescopic/rig.toml";
        let rig = Rig::parse(path, std::fs::read_to_string(path).unwrap()).unwrap();
        let sensor = rig.sensors.iter().position(|sensor| sensor.name == "p_B").unwrap();
        let first = FirstReading { shown: 7e5, sigma: 0.0, sensor: Some(sensor) };
        let healthy = rig.nominal();
        let mut off = healthy.clone();
        let own = rig.sensors[sensor].first_parameter;
        (off[own], off[own + 1]) = (2e5, 1.25);
        // 2 bar too much, and a quarter: 7 bar are 4.
        assert_eq!((first.freed(&rig, &healthy), first.freed(&rig, &off)), (7e5, 4e5));
        // A healthy sensor would have shown these.
        assert_eq!(first.shown_with(&rig, &off, &healthy).freed(&rig, &healthy), 4e5);
        let shown = Shown { sensor, value: 7e5, sigma: 0.0, rate: 5.0 };
        assert_eq!(shown.shown_with(&rig, &off, &healthy), Shown { value: 4e5, rate: 4.0, ..shown });
    }
}
