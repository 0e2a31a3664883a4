//! What one mistake in how a record was taken, or oil of another viscosity, does; and the record and the rig without it.

use super::result::{CommonCause, OTHER_OIL};
use crate::model::Model;
use crate::number::{rounded, text, with_unit};
use crate::record::{Channel, Record};
use crate::rig::{Quantity, Rig};
use crate::settings::DiagnosisSettings;

/// Standard atmosphere, Pa (ISO 2533): what an absolute pressure sensor shows above a gauge one.
const ATMOSPHERE: f64 = 101_325.0;

/// A mistake in how a record was taken, or oil that is not that of the rig file.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Cause {
    /// The logger's clock runs fast by this share.
    FastClock(f64),
    /// Pressures are absolute where the rig file takes them as gauge.
    AbsolutePressures,
    /// The columns of two sensors stand in each other's place.
    Swapped([usize; 2]),
    /// A sensor counts the other way.
    Turned(usize),
    /// Inputs are recorded so many rows after they have acted. That they act after they are recorded is no mistake, but dead time.
    Late(Inputs, usize),
    /// The oil flows more easily than the rig file says by this share: it is warmer, or another one.
    OtherOil(f64),
}

/// Largest change of the viscosity that is searched, as a factor: of a mineral oil of VG 46 with viscosity index 100 that is 40 degC warm
/// by the rig file, and 95 degC in truth.
const OIL_MOST: f64 = 6.0;
/// Share of the viscosity by which its derivative is taken: readings run straight over it, and change by far more than the solver errs.
const OIL_TRIED: f64 = 0.01;

/// Inputs that come by the same way into a record.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Inputs {
    One(usize),
    Commands,
    All,
}

impl Inputs {
    /// By their indices.
    pub(super) fn of(self, rig: &Rig) -> Vec<usize> {
        let takes = |&input: &usize| match self {
            Self::One(one) => input == one,
            Self::Commands => rig.inputs[input].noise == 0.0,
            Self::All => true,
        };
        (0..rig.inputs.len()).filter(takes).collect()
    }

    /// Longest time that a part follows one of them behind, as stated, s.
    pub(super) fn followed_within(self, rig: &Rig) -> f64 {
        let inputs = self.of(rig);
        let followers = rig.followers().filter(|follower| inputs.contains(&follower.input));
        followers.map(|follower| rig.parameters[follower.lag].value).fold(0.0, f64::max)
    }

    /// Each alone, all commands and all inputs, as far as these are others.
    pub(super) fn groups(rig: &Rig) -> Vec<Self> {
        let mut groups: Vec<Self> = (0..rig.inputs.len()).map(Self::One).collect();
        let several = [Self::Commands, Self::All].into_iter().filter(|group| group.of(rig).len() > 1);
        for group in several {
            if groups.iter().all(|other| other.of(rig) != group.of(rig)) {
                groups.push(group);
            }
        }
        groups
    }
}

impl Cause {
    /// The share at which the derivative by its size is taken.
    pub(super) fn tried(self, settings: &DiagnosisSettings) -> f64 {
        if matches!(self, Self::OtherOil(_)) { OIL_TRIED } else { settings.clock_rate_tried }
    }

    /// Half the range of its size that is searched, as a logarithm.
    pub(super) fn most(self, settings: &DiagnosisSettings) -> f64 {
        if matches!(self, Self::OtherOil(_)) { OIL_MOST.ln() } else { settings.clock_rate_most.ln_1p() }
    }

    /// Values of the rig's parameters, SI, with it.
    pub(super) fn values(self, rig: &Rig, values: &[f64]) -> Vec<f64> {
        match self {
            Self::OtherOil(share) => rig.in_oil(1.0 + share, values),
            _ => values.to_vec(),
        }
    }

    /// The rig with it.
    pub(super) fn model(self, model: &Model) -> Model {
        match self {
            Self::OtherOil(share) => Model::new(model.rig.with_oil(1.0 + share)).with_tolerance(model.tolerance),
            _ => model.clone(),
        }
    }

    /// The record as it would have been without the mistake.
    pub(super) fn corrected(self, rig: &Rig, record: &Record) -> Record {
        let mut corrected = record.clone();
        match self {
            Self::OtherOil(_) => {}
            Self::FastClock(rate) => corrected.time.iter_mut().for_each(|time| *time /= 1.0 + rate),
            Self::AbsolutePressures => {
                for sensor in rig.sensors.iter().filter(|sensor| sensor.quantity == Quantity::Pressure) {
                    change(&mut corrected, &sensor.column, |value| value - ATMOSPHERE);
                }
            }
            Self::Turned(sensor) => change(&mut corrected, &rig.sensors[sensor].column, |value| -value),
            Self::Late(inputs, rows) => {
                for input in inputs.of(rig) {
                    let column = &rig.inputs[input].column;
                    let channel = corrected.channels.iter_mut().find(|channel| &channel.name == column);
                    let Some(values) = channel.map(|channel| &mut channel.values) else { continue };
                    if let Some(&last) = values.last() {
                        values.drain(..rows.min(values.len()));
                        values.resize(record.time.len(), last);
                    }
                }
            }
            Self::Swapped(pair) => {
                let place =
                    |sensor: usize| corrected.channels.iter().position(|c| c.name == rig.sensors[sensor].column);
                if let [Some(a), Some(b)] = pair.map(place) {
                    let of_a = std::mem::take(&mut corrected.channels[a].values);
                    corrected.channels[a].values = std::mem::replace(&mut corrected.channels[b].values, of_a);
                }
            }
        }
        corrected
    }

    pub(super) fn report(self, rig: &Rig, record: &Record, instead_of: Vec<String>) -> CommonCause {
        let late = |rows: usize| record.sampling().map(|sampling| rounded(rows as f64 * sampling.interval, 4));
        let column = |sensor: usize| rig.sensors[sensor].column.clone();
        let viscosity = self.viscosity(rig);
        let (kind, columns, clause) = match self {
            Self::FastClock(rate) => {
                let way = if rate < 0.0 { "slow" } else { "fast" };
                let percent = text(rounded(100.0 * rate.abs(), 3));
                ("fast-clock", vec!["time".to_owned()], format!("the clock of the logger is {percent} % {way}"))
            }
            Self::AbsolutePressures => {
                let pressures = rig.sensors.iter().filter(|sensor| sensor.quantity == Quantity::Pressure);
                let clause = "the pressures are absolute, where the rig file takes them as gauge".to_owned();
                ("absolute-pressures", pressures.map(|sensor| sensor.column.clone()).collect(), clause)
            }
            Self::Swapped([a, b]) => {
                let clause = format!("the columns `{}` and `{}` are swapped", column(a), column(b));
                ("swapped-columns", vec![column(a), column(b)], clause)
            }
            Self::Turned(sensor) => {
                let clause = format!("`{}` counts the other way", column(sensor));
                ("turned-sign", vec![column(sensor)], clause)
            }
            Self::Late(inputs, rows) => {
                let columns: Vec<String> =
                    inputs.of(rig).into_iter().map(|input| rig.inputs[input].column.clone()).collect();
                let named: Vec<String> = columns.iter().map(|column| format!("`{column}`")).collect();
                let by = text(1e3 * late(rows).unwrap_or(0.0));
                let clause = match named.as_slice() {
                    [one] => format!("{one} is recorded {by} ms after it acts"),
                    several => format!("{} are recorded {by} ms after they act", several.join(" and ")),
                };
                ("late-inputs", columns, clause)
            }
            Self::OtherOil(_) => {
                let said = |viscosity: f64| {
                    rig.viscosity().map(|own| with_unit(rounded(own.unit.from_si(viscosity), 3), &own.unit.to_string()))
                };
                let [is, stated] =
                    [viscosity, rig.viscosity().map(|own| own.value)].map(|si| si.and_then(said).unwrap_or_default());
                (OTHER_OIL, Vec::new(), format!("the oil has {is} instead of {stated}"))
            }
        };
        let value = match self {
            Self::FastClock(rate) => Some(rounded(rate, 4)),
            Self::Late(_, rows) => late(rows),
            Self::OtherOil(_) => viscosity.map(|viscosity| rounded(viscosity, 4)),
            Self::AbsolutePressures | Self::Swapped(_) | Self::Turned(_) => None,
        };
        CommonCause { kind, columns, value, clause, instead_of }
    }

    /// Viscosity of the oil, Pa·s, where it is another.
    fn viscosity(self, rig: &Rig) -> Option<f64> {
        let Self::OtherOil(share) = self else { return None };
        rig.viscosity().map(|own| own.value / (1.0 + share))
    }

    /// What has no size and could concern this rig.
    pub(super) fn discrete(rig: &Rig) -> Vec<Self> {
        let pressures = rig.sensors.iter().filter(|sensor| sensor.quantity == Quantity::Pressure).count();
        let mut causes = Vec::new();
        // One pressure alone is an offset of its sensor.
        causes.extend((pressures > 1).then_some(Self::AbsolutePressures));
        for (a, sensor) in rig.sensors.iter().enumerate() {
            causes.push(Self::Turned(a));
            let alike = |b: &usize| rig.sensors[*b].quantity == sensor.quantity;
            causes.extend((0..a).filter(alike).map(|b| Self::Swapped([b, a])));
        }
        causes
    }
}

fn change(record: &mut Record, column: &str, to: impl Fn(f64) -> f64) {
    let channel = record.channels.iter_mut().find(|channel: &&mut Channel| channel.name == column);
    if let Some(channel) = channel {
        channel.values.iter_mut().for_each(|value| *value = to(*value));
    }
}
