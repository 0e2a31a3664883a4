//! A record beside what the healthy model says of it: columns that were exchanged, a column, the time or a value of the rig file that is
//! in another unit.

use rayon::prelude::*;

use super::sense::begun_elsewhere;
use crate::complaint::Complaint;
use crate::diagnosis::problem::{count_there, square_sum};
use crate::diagnosis::search::roughly;
use crate::diagnosis::summary::{ratio_to_healthy, reads_otherwise};
use crate::model::{InputSignals, Model};
use crate::number::{in_unit, rounded, text, with_unit};
use crate::record::{Channel, Record};
use crate::rig::Rig;
use crate::units::Unit;

/// Rows from the first that are simulated.
const ROWS: usize = 20_000;
/// Squares of what is missed, over those of the noise, from which it is not noise: three times as large.
const BEYOND_NOISE: f64 = 9.0;
/// Fewest rows that tell whether a model follows.
const FIRST_ROWS: usize = 32;
/// Share of the squares of a reading that the model misses, up to which nothing is asked: worn parts and data sheets reach a
/// third of a reading.
const MISSED: f64 = 0.1;
/// The same from which two columns are compared with each other's, a tenth of a reading: that an exchange explains both leaves little to
/// chance.
const EXCHANGED: f64 = 0.01;
/// Share of what is missed that may be left where they are exchanged, or the time is in another unit: half of each reading's distance,
/// as few are tried.
const LEFT: f64 = 0.25;
/// The same for a value of the rig file, where many are tried: a tenth of the distance, which data sheets leave.
const FOLLOWED: f64 = 0.01;
/// Values of the rig file that are named.
const MOST: usize = 3;
/// What units are mistaken for each other by: powers of ten, minutes for seconds, psi for bar, inches for millimetres, and the other
/// way.
const MISTAKEN: [f64; 6] = [10.0, 100.0, 1000.0, 60.0, 14.5038, 25.4];
/// What units of a column are mistaken for each other by beside these: gallons for litres, m3/h for L/min.
const MISTAKEN_COLUMN: [f64; 2] = [3.785_41, 1000.0 / 60.0];
/// How many times as long a record is whose time is in another unit than stated: ms, min and h for s and the other way, and us taken
/// for s.
const LONGER: [f64; 7] = [1e3, 60.0, 3600.0, 1e-3, 1.0 / 60.0, 1.0 / 3600.0, 1e-6];

/// What the healthy model finds doubtful in a record, each in words with what it may be; nothing where the record lacks an input.
///
/// # Errors
/// A [context](crate::Context) that was cancelled.
pub fn doubts(rig: &Rig, record: &Record) -> Result<Vec<String>, Complaint> {
    rig.context().run(|| {
        rig.context().stage("comparing the record with the healthy model");
        let told = told(rig, record);
        rig.context().check()?;
        Ok(told)
    })
}

fn told(rig: &Rig, record: &Record) -> Vec<String> {
    let Ok(drive) = &InputSignals::from_record(rig, record) else { return Vec::new() };
    let model = roughly(&rig.model());
    let channels: Vec<Option<&Channel>> =
        rig.sensors.iter().map(|sensor| rig.sensor_column(record, sensor).ok()).collect();
    let measured = channels.iter().map(|channel| Some(channel.as_ref()?.values.as_slice())).collect();
    let units = channels.iter().map(|channel| Some(channel.as_ref()?.unit.clone())).collect();
    let beside = Beside { rig, drive, times: &record.time[..record.time.len().min(ROWS)], measured, units };
    let Some(healthy) = beside.solved(&model, &rig.healthy()) else { return Vec::new() };
    let exchanged = beside.exchanged(&healthy);
    if !exchanged.is_empty() {
        return exchanged;
    }
    let far: Vec<usize> = (0..healthy.len()).filter(|&sensor| beside.is_far(&healthy, sensor)).collect();
    let misread = beside.misread(&healthy);
    match far.as_slice() {
        [] => misread,
        // A column alone is off by itself.
        [one] if misread.iter().any(|(sensor, _)| sensor == one) => misread,
        _ => match beside.in_another_unit(&model, &healthy, record) {
            Some(value) => return vec![value],
            None => misread,
        },
    }
    .into_iter()
    .map(|(_, told)| told)
    .chain(begun_elsewhere(rig, record))
    .collect()
}

/// A record beside the model.
struct Beside<'a> {
    rig: &'a Rig,
    drive: &'a InputSignals,
    times: &'a [f64],
    /// Of each sensor that the record has, SI.
    measured: Vec<Option<&'a [f64]>>,
    /// Of its column.
    units: Vec<Option<Unit>>,
}

impl Beside<'_> {
    /// What the sensors read with these parameters, `[sensor][row]`, SI.
    fn solved(&self, model: &Model, parameters: &[f64]) -> Option<Vec<Vec<f64>>> {
        Some(model.solve(parameters, self.drive, self.times).ok()?.values)
    }

    /// What one sensor would show had its column the numbers of another one's, SI.
    fn numbers_of(&self, other: usize, own: usize) -> Option<Vec<f64>> {
        let [from, to] = [self.units[other].as_ref()?, self.units[own].as_ref()?];
        Some(self.measured[other]?.iter().map(|si| to.to_si(from.from_si(*si))).collect())
    }

    /// What a curve of the model misses of what a sensor shows, against both, as squares: from 0 to 1, noise counts as nothing.
    fn missed(&self, curve: &[f64], sensor: usize) -> Option<f64> {
        self.missed_by(curve, sensor, self.measured[sensor]?)
    }

    fn missed_by(&self, curve: &[f64], sensor: usize, measured: &[f64]) -> Option<f64> {
        let measured = &measured[..curve.len()];
        let noise = count_there(measured) as f64 * self.rig.sensors[sensor].noise.powi(2);
        let miss = (square_sum(curve, measured) - noise).max(0.0);
        let size = measured.iter().filter(|y| !y.is_nan()).map(|y| y * y).sum::<f64>();
        (size > 0.0).then(|| miss / (miss + size))
    }

    /// Pairs of sensors, each of which shows what the model says of the other; the numbers are those of the columns, whose units stay.
    fn exchanged(&self, healthy: &[Vec<f64>]) -> Vec<String> {
        let sensors = &self.rig.sensors;
        let pairs = (0..sensors.len()).flat_map(|b| (0..b).map(move |a| (a, b)));
        let are_exchanged = |&(a, b): &(usize, usize)| {
            let fell = |own: usize, other: usize| {
                let before = self.missed(&healthy[own], own)?;
                let after = self.missed_by(&healthy[own], own, &self.numbers_of(other, own)?)?;
                Some(before > EXCHANGED && after < LEFT * before)
            };
            fell(a, b) == Some(true) && fell(b, a) == Some(true)
        };
        let told = |(a, b): (usize, usize)| {
            let [a, b] = [a, b].map(|one| &sensors[one].column);
            format!(
                "`{a}` shows what the healthy model says of `{b}`, and `{b}` that of `{a}`: are the two columns exchanged?"
            )
        };
        pairs.filter(are_exchanged).map(told).collect()
    }

    /// Whether the model misses more of a reading than worn parts and data sheets do.
    fn is_far(&self, outputs: &[Vec<f64>], sensor: usize) -> bool {
        self.missed(&outputs[sensor], sensor).is_some_and(|share| share > MISSED)
    }

    /// The first rows in which the model is far from a sensor already, and the sensors that it is far from there; all where that
    /// takes them. Where nothing moves, noise alone is as large as the reading.
    fn far_first(&self, outputs: &[Vec<f64>]) -> (usize, Vec<usize>) {
        let all = self.times.len();
        let far = |rows: usize| -> Vec<usize> {
            let begun: Vec<Vec<f64>> = outputs.iter().map(|curve| curve[..rows].to_vec()).collect();
            let is_beyond_noise = |sensor: usize| {
                let measured = self.measured[sensor].map(|measured| &measured[..rows]).unwrap_or_default();
                let noise = count_there(measured) as f64 * self.rig.sensors[sensor].noise.powi(2);
                square_sum(&begun[sensor][..measured.len()], measured) > BEYOND_NOISE * noise
            };
            (0..begun.len()).filter(|&sensor| self.is_far(&begun, sensor) && is_beyond_noise(sensor)).collect()
        };
        let doubled = std::iter::successors(Some(FIRST_ROWS), |rows| Some(2 * rows)).take_while(|rows| *rows < all);
        let found = doubled.map(|rows| (rows, far(rows))).find(|(_, far)| !far.is_empty());
        found.unwrap_or_else(|| (all, (0..outputs.len()).collect()))
    }

    /// Sensors whose columns read several times what the model says, and the same in words.
    fn misread(&self, healthy: &[Vec<f64>]) -> Vec<(usize, String)> {
        let told = self.rig.sensors.iter().enumerate().filter_map(|(index, sensor)| {
            let measured = &self.measured[index]?[..self.times.len()];
            let ratio = ratio_to_healthy(&self.rig.settings().diagnosis, measured, &healthy[index])
                .or_else(|| self.ratio_of_units(&healthy[index], index, measured))?;
            let unit = self.rig.sensor_unit(sensor).symbol;
            Some((index, reads_otherwise(&format!("`{}`", sensor.column), ratio, &unit)))
        });
        told.collect()
    }

    /// By what a column that the model is far from reads otherwise, if that is the ratio of two units, with which the model follows it.
    fn ratio_of_units(&self, healthy: &[f64], sensor: usize, measured: &[f64]) -> Option<f64> {
        let before = self.missed(healthy, sensor).filter(|before| *before > MISSED)?;
        let ratios = MISTAKEN.iter().chain(&MISTAKEN_COLUMN).flat_map(|factor| [*factor, 1.0 / factor]);
        let left = |ratio: f64| {
            let read: Vec<f64> = measured.iter().map(|value| value / ratio).collect();
            Some((self.missed_by(healthy, sensor, &read)?, ratio))
        };
        let best = ratios.filter_map(left).min_by(|a, b| a.0.total_cmp(&b.0))?;
        (best.0 < FOLLOWED * before).then_some(best.1)
    }

    /// Values of the rig file with one of which, read in another unit, the model follows a record that it is far from; or the time of
    /// the record, read so.
    fn in_another_unit(&self, model: &Model, healthy: &[Vec<f64>], record: &Record) -> Option<String> {
        let all_missed = |outputs: &[Vec<f64>], of: &[usize]| -> f64 {
            of.iter().filter_map(|&sensor| self.missed(&outputs[sensor], sensor)).sum()
        };
        let all: Vec<usize> = (0..healthy.len()).collect();
        let before = all_missed(healthy, &all);
        let nominal = self.rig.healthy();
        let stated = (0..nominal.len()).filter(|&own| nominal[own] != 0.0 && !self.rig.is_of_sensor(own));
        let factors = MISTAKEN.iter().flat_map(|factor| [*factor, 1.0 / factor]);
        let values = stated.flat_map(|own| factors.clone().map(move |factor| Misread::Value(own, factor)));
        let tried: Vec<Misread> = LONGER.iter().map(|longer| Misread::Time(*longer)).chain(values).collect();
        // A value that is right follows where the model is far first; most do not, and need not be simulated to the end.
        let (rows, far) = self.far_first(healthy);
        let begin = |outputs: &[Vec<f64>]| outputs.iter().map(|curve| curve[..rows].to_vec()).collect::<Vec<_>>();
        let enough_there = LEFT * all_missed(&begin(healthy), &far);
        let first = self.first_rows(record);
        let left = |misread: Misread| {
            let (parameters, longer) = match misread {
                Misread::Value(own, factor) => {
                    let mut parameters = nominal.clone();
                    parameters[own] *= factor;
                    let (low, high) = self.rig.parameters[own].bounds;
                    if !(low..=high).contains(&parameters[own]) {
                        return None;
                    }
                    (parameters, None)
                }
                Misread::Time(longer) => (nominal.clone(), Some(stretched(&first, longer))),
            };
            let other = longer.as_ref().map(|record| InputSignals::from_record(self.rig, record)).transpose().ok()?;
            let drive = other.as_ref().unwrap_or(self.drive);
            let times = longer.as_ref().map_or(self.times, |record| &record.time);
            let missed = |rows: usize, of: &[usize]| {
                let (measured, units) = (self.measured.clone(), self.units.clone());
                let beside = Beside { rig: self.rig, drive, times: &times[..rows], measured, units };
                Some(all_missed(&beside.solved(model, &parameters)?, of))
            };
            // Of times there are few, and where the model is far first may be a fault's doing.
            let begins = matches!(misread, Misread::Time(_)) || missed(rows, &far)? < enough_there;
            begins.then(|| Some((missed(times.len(), &all)?, misread)))?
        };
        let mut left: Vec<(f64, Misread)> = tried.into_par_iter().filter_map(left).collect();
        left.retain(|(after, misread)| {
            let share = if matches!(misread, Misread::Time(_)) { LEFT } else { FOLLOWED };
            *after < share * before
        });
        left.sort_by(|a, b| a.0.total_cmp(&b.0));
        let told: Vec<String> = left.iter().take(MOST).map(|(_, misread)| self.told(misread, &nominal)).collect();
        (!told.is_empty()).then(|| {
            let told = told.join(", or ");
            format!("the healthy model is far from the record, and follows it with {told}: is that in another unit?")
        })
    }

    fn told(&self, misread: &Misread, nominal: &[f64]) -> String {
        match *misread {
            Misread::Time(longer) if longer > 1.0 => {
                format!("its time {} times as long", text(rounded(longer, 4)))
            }
            Misread::Time(longer) => format!("its time {} times as short", text(rounded(1.0 / longer, 4))),
            Misread::Value(own, factor) => {
                let parameter = &self.rig.parameters[own];
                let shown = |value: f64| with_unit(rounded(in_unit(value, &parameter.unit), 4), &parameter.unit.symbol);
                let (other, stated) = (shown(nominal[own] * factor), shown(nominal[own]));
                format!("`{}` at {other} instead of {stated} ({})", parameter.id, parameter.place)
            }
        }
    }

    /// The rows that are simulated, as a record of their own.
    fn first_rows(&self, record: &Record) -> Record {
        let rows = self.times.len();
        let channels = record
            .channels
            .iter()
            .map(|channel| Channel::new(channel.name.clone(), channel.unit.clone(), channel.values[..rows].to_vec()));
        Record::new(record.path.clone(), self.times.to_vec(), channels.collect())
    }
}

/// What may be in another unit than stated.
#[derive(Debug, Clone, Copy)]
enum Misread {
    /// A parameter, and by how much.
    Value(usize, f64),
    /// The time, and how many times as long it is.
    Time(f64),
}

/// A record over another time.
fn stretched(record: &Record, longer: f64) -> Record {
    let time = record.time.iter().map(|time| time * longer).collect();
    Record::new(record.path.clone(), time, record.channels.clone())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_time_in_another_unit_is_asked_about_and_a_right_one_is_not() {
        let mut rig = Rig::read("fixtures/telescopic/rig.toml").unwrap();
        // Its interval would tell.
        rig.cycle = None;
        let record = rig.record("fixtures/telescopic/healthy_1.csv").unwrap();
        let displacement = rig.parameter("pump.displacement").unwrap();
        let fault = rig.faults.iter().position(|fault| fault.parameter == displacement).unwrap();
        let stated = rig.faults[fault].healthy;
        // Nor does it take a machine that is as its data sheet says.
        for off in [1.0, 1.05] {
            rig.faults[fault].healthy = off * stated;
            let told = |longer: f64| told(&rig, &stretched(&record, longer)).join("; ");
            assert!(!told(1.0).contains("its time"), "{}", told(1.0));
            let wrong = [(1e-3, "1000 times as long"), (1e3, "1000 times as short"), (1.0 / 60.0, "60 times as long")];
            for (wrong, how) in wrong {
                let told = told(wrong);
                assert!(told.contains(&format!("follows it with its time {how}")), "{off}, {wrong}: {told}");
            }
        }
    }
}
