//! Scales of channels: what the numbers of a card become, step by step.

use std::collections::{BTreeMap, BTreeSet};

use super::object::{Data, Properties, Value};

/// The input of a step that takes the raw data of its channel.
const RAW: u32 = 0xFFFF_FFFF;
/// Most steps of a scale, and coefficients of a polynomial: every one is computed for each value. Those of DAQmx have six or less, and
/// the longest polynomials, of thermocouples, fifteen coefficients.
const MOST: usize = 64;

/// Where a step has its input from.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Source {
    Raw,
    Step(usize),
}

/// What a step does.
#[derive(Debug, Clone, PartialEq)]
enum Law {
    /// Takes the value of a card that goes to the scale of this number.
    Scaler(u32),
    Same(Source),
    Linear {
        from: Source,
        slope: f64,
        intercept: f64,
    },
    /// Coefficients from that of the zeroth power on.
    Polynomial {
        from: Source,
        coefficients: Vec<f64>,
    },
    /// Rising inputs with their outputs, straight between them, constant beyond.
    Table {
        from: Source,
        points: Vec<(f64, f64)>,
    },
    Add(Source, Source),
    /// The right one less the left one, as NI's programs compute it.
    Subtract(Source, Source),
}

/// The steps that the value of a channel needs, each behind its inputs; the last one gives the value.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Scale {
    steps: Vec<Law>,
}

impl Scale {
    /// The scale in the properties of a channel, of its group, or of the file; `None` where its numbers are to be taken as they are.
    ///
    /// # Errors
    /// Why the channel is of no use: a step of a kind that is not read, or that lacks a number or an input.
    pub fn of(properties: &[Option<&Properties>]) -> Result<Option<Self>, String> {
        for properties in properties.iter().copied().flatten() {
            if let Some(count) = count(properties) {
                let scaled = properties.get("NI_Scaling_Status") == Some(&Value::Text("scaled".to_owned()));
                return if scaled { Ok(None) } else { Self::read(properties, count - 1).map(Some) };
            }
        }
        Ok(None)
    }

    /// The step of this number, and all that it needs; inputs have smaller numbers, so that there are no circles.
    fn read(properties: &Properties, last: u32) -> Result<Self, String> {
        let mut found = BTreeMap::new();
        let mut wanted = BTreeSet::from([last]);
        while let Some(number) = wanted.pop_last() {
            let step = Step { properties, number };
            let inputs = step.inputs()?;
            if inputs.iter().any(|input| *input != RAW && *input >= number) {
                return Err(format!("its scale {number} takes what comes behind it"));
            }
            wanted.extend(inputs.iter().filter(|input| **input != RAW));
            found.insert(number, (step, inputs));
            if found.len() > MOST {
                return Err(format!("its scale has more than {MOST} steps"));
            }
        }
        let place: BTreeMap<u32, usize> = found.keys().copied().zip(0..).collect();
        let source = |input: &u32| place.get(input).map_or(Source::Raw, |place| Source::Step(*place));
        let law = |(step, inputs): &(Step<'_>, Vec<u32>)| step.law(&inputs.iter().map(source).collect::<Vec<_>>());
        Ok(Self { steps: found.values().map(law).collect::<Result<_, _>>()? })
    }

    /// The values of a channel.
    ///
    /// # Errors
    /// An input that the channel does not have.
    pub fn apply(&self, data: &mut Data) -> Result<Vec<f64>, String> {
        let raw = std::mem::take(&mut data.numbers);
        let mut cards: Vec<&[f64]> = Vec::new();
        let mut count = if data.scalers.is_empty() { raw.len() } else { usize::MAX };
        for law in &self.steps {
            let card = match law {
                Law::Scaler(number) => data.scalers.get(number).map(Vec::as_slice),
                _ => Some(&[][..]),
            };
            let card = card.ok_or_else(|| format!("its scale takes values that the file does not have: {law:?}"))?;
            if matches!(law, Law::Scaler(_)) {
                count = count.min(card.len());
            }
            cards.push(card);
        }
        if raw.len() < count {
            return match self.steps.iter().any(Law::takes_raw) || count == usize::MAX {
                true => Err("its scale takes raw data that the file does not have".to_owned()),
                false => Ok(self.compute(&[], &cards, count)),
            };
        }
        Ok(self.compute(&raw, &cards, count))
    }

    fn compute(&self, raw: &[f64], cards: &[&[f64]], count: usize) -> Vec<f64> {
        let mut done = vec![f64::NAN; self.steps.len()];
        let value = |row: usize| {
            let raw = raw.get(row).copied().unwrap_or(f64::NAN);
            for (place, (law, card)) in self.steps.iter().zip(cards).enumerate() {
                let card = card.get(row).copied().unwrap_or(f64::NAN);
                let value = law.value(card, raw, &done);
                if let Some(slot) = done.get_mut(place) {
                    *slot = value;
                }
            }
            done.last().copied().unwrap_or(raw)
        };
        (0..count).map(value).collect()
    }
}

/// How many scales there are; `None` without any.
fn count(properties: &Properties) -> Option<u32> {
    let count = match properties.get("NI_Number_Of_Scales") {
        Some(Value::Number(count)) => *count as u32,
        _ => properties.keys().filter_map(|name| numbered(name)).max()?.saturating_add(1),
    };
    (count > 0).then_some(count)
}

/// The number in `NI_Scale[1]_Scale_Type`.
fn numbered(name: &str) -> Option<u32> {
    name.strip_prefix("NI_Scale[")?.strip_suffix("]_Scale_Type")?.parse().ok()
}

/// The properties of one scale.
struct Step<'a> {
    properties: &'a Properties,
    number: u32,
}

impl Step<'_> {
    fn get(&self, name: &str) -> Option<&Value> {
        self.properties.get(&format!("NI_Scale[{}]_{name}", self.number))
    }

    fn kind(&self) -> Option<&str> {
        match self.get("Scale_Type")? {
            Value::Text(text) => Some(text),
            _ => None,
        }
    }

    fn number(&self, name: &str) -> Result<f64, String> {
        match self.get(name) {
            Some(Value::Number(number)) => Ok(*number),
            _ => Err(format!("its scale {} has no `{name}`", self.number)),
        }
    }

    fn input(&self, name: &str) -> u32 {
        self.number(name).map_or(RAW, |number| number as u32)
    }

    /// The numbers of the scales that it takes, or [`RAW`].
    fn inputs(&self) -> Result<Vec<u32>, String> {
        match self.kind() {
            // A scale without a type stands for the values of the card with its number.
            None => Ok(Vec::new()),
            Some(kind @ ("Linear" | "Polynomial" | "Table" | "AdvancedAPI")) => {
                Ok(vec![self.input(&format!("{kind}_Input_Source"))])
            }
            Some(kind @ ("Add" | "Subtract")) => Ok(vec![
                self.input(&format!("{kind}_Left_Operand_Input_Source")),
                self.input(&format!("{kind}_Right_Operand_Input_Source")),
            ]),
            Some(kind) => Err(format!("its scale is of the kind `{kind}`, which is not read")),
        }
    }

    fn law(&self, inputs: &[Source]) -> Result<Law, String> {
        let from = inputs.first().copied().unwrap_or(Source::Raw);
        let right = inputs.get(1).copied().unwrap_or(Source::Raw);
        Ok(match self.kind() {
            None => Law::Scaler(self.number),
            Some("Linear") => {
                Law::Linear { from, slope: self.number("Linear_Slope")?, intercept: self.number("Linear_Y_Intercept")? }
            }
            Some("Polynomial") => {
                // NI's own programs leave the size away where there are four.
                let count = self.number("Polynomial_Coefficients_Size").unwrap_or(4.0) as usize;
                if count > MOST {
                    return Err(format!("its scale has more than {MOST} coefficients"));
                }
                Law::Polynomial { from, coefficients: self.list("Polynomial_Coefficients", count)? }
            }
            Some("Table") => Law::Table { from, points: self.table()? },
            Some("Add") => Law::Add(from, right),
            Some("Subtract") => Law::Subtract(from, right),
            _ => Law::Same(from),
        })
    }

    fn list(&self, name: &str, count: usize) -> Result<Vec<f64>, String> {
        (0..count).map(|index| self.number(&format!("{name}[{index}]"))).collect()
    }

    fn table(&self) -> Result<Vec<(f64, f64)>, String> {
        let list = |name: &str| {
            let count = self.number(&format!("{name}_Size"))?;
            self.list(name, count as usize)
        };
        let (inputs, outputs) = (list("Table_Pre_Scaled_Values")?, list("Table_Scaled_Values")?);
        let mut points: Vec<(f64, f64)> = inputs.iter().copied().zip(outputs.iter().copied()).collect();
        if points.first() > points.last() {
            points.reverse();
        }
        let rises = points.windows(2).all(|pair| pair[0].0 < pair[1].0);
        if points.is_empty() || inputs.len() != outputs.len() || !rises {
            return Err(format!("the table of its scale {} does not rise", self.number));
        }
        Ok(points)
    }
}

impl Law {
    fn takes_raw(&self) -> bool {
        match self {
            Self::Scaler(_) => false,
            Self::Same(from) | Self::Linear { from, .. } | Self::Polynomial { from, .. } | Self::Table { from, .. } => {
                *from == Source::Raw
            }
            Self::Add(left, right) | Self::Subtract(left, right) => *left == Source::Raw || *right == Source::Raw,
        }
    }

    fn value(&self, card: f64, raw: f64, done: &[f64]) -> f64 {
        let of = |source: &Source| match source {
            Source::Raw => raw,
            Source::Step(place) => done.get(*place).copied().unwrap_or(f64::NAN),
        };
        match self {
            Self::Scaler(_) => card,
            Self::Same(from) => of(from),
            Self::Linear { from, slope, intercept } => of(from) * slope + intercept,
            Self::Polynomial { from, coefficients } => {
                let x = of(from);
                coefficients.iter().rev().fold(0.0, |sum, coefficient| sum * x + coefficient)
            }
            Self::Table { from, points } => between(points, of(from)),
            Self::Add(left, right) => of(left) + of(right),
            Self::Subtract(left, right) => of(right) - of(left),
        }
    }
}

/// The value at `x` of a curve that is straight between its points and constant beyond.
fn between(points: &[(f64, f64)], x: f64) -> f64 {
    let after = points.partition_point(|point| point.0 <= x);
    let (before, behind) = (after.checked_sub(1).and_then(|at| points.get(at)), points.get(after));
    match (before, behind) {
        _ if x.is_nan() => x,
        (Some(a), Some(b)) => a.1 + (b.1 - a.1) * ((x - a.0) / (b.0 - a.0)),
        (Some(end), None) | (None, Some(end)) => end.1,
        (None, None) => f64::NAN,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn properties(entries: &[(&str, f64)], kinds: &[(u32, &str)]) -> Properties {
        let number = |(name, value): &(&str, f64)| ((*name).to_owned(), Value::Number(*value));
        let kind =
            |(number, kind): &(u32, &str)| (format!("NI_Scale[{number}]_Scale_Type"), Value::Text((*kind).to_owned()));
        entries.iter().map(number).chain(kinds.iter().map(kind)).collect()
    }

    fn applied(properties: &Properties, raw: &[f64]) -> Result<Vec<f64>, String> {
        let scale = Scale::of(&[Some(properties)])?.unwrap();
        scale.apply(&mut Data { numbers: raw.to_vec(), ..Data::default() })
    }

    #[test]
    fn steps_follow_each_other() {
        let given = properties(
            &[
                ("NI_Scale[0]_Linear_Slope", 2.0),
                ("NI_Scale[0]_Linear_Y_Intercept", 1.0),
                ("NI_Scale[1]_Polynomial_Coefficients_Size", 3.0),
                ("NI_Scale[1]_Polynomial_Coefficients[0]", 1.0),
                ("NI_Scale[1]_Polynomial_Coefficients[1]", 0.0),
                ("NI_Scale[1]_Polynomial_Coefficients[2]", 0.5),
                ("NI_Scale[1]_Polynomial_Input_Source", 0.0),
            ],
            &[(0, "Linear"), (1, "Polynomial")],
        );
        // x -> 2x + 1 -> 1 + y²/2.
        assert_eq!(applied(&given, &[0.0, 1.0, -1.5]).unwrap(), [1.5, 5.5, 3.0]);
    }

    #[test]
    fn tables_are_straight_between_their_points() {
        let mut entries =
            vec![("NI_Scale[0]_Table_Pre_Scaled_Values_Size", 3.0), ("NI_Scale[0]_Table_Scaled_Values_Size", 3.0)];
        entries.extend([
            ("NI_Scale[0]_Table_Pre_Scaled_Values[0]", 4.0),
            ("NI_Scale[0]_Table_Pre_Scaled_Values[1]", 2.0),
            ("NI_Scale[0]_Table_Pre_Scaled_Values[2]", 0.0),
            ("NI_Scale[0]_Table_Scaled_Values[0]", 10.0),
            ("NI_Scale[0]_Table_Scaled_Values[1]", 20.0),
            ("NI_Scale[0]_Table_Scaled_Values[2]", 0.0),
        ]);
        let given = properties(&entries, &[(0, "Table")]);
        let values = applied(&given, &[-1.0, 0.0, 0.5, 2.0, 3.0, 9.0, f64::NAN]).unwrap();
        assert_eq!(values[..6], [0.0, 0.0, 5.0, 20.0, 15.0, 10.0]);
        assert!(values[6].is_nan());
    }

    #[test]
    fn what_cards_gave_is_taken_by_number() {
        let given = properties(
            &[
                ("NI_Number_Of_Scales", 3.0),
                ("NI_Scale[2]_Subtract_Left_Operand_Input_Source", 0.0),
                ("NI_Scale[2]_Subtract_Right_Operand_Input_Source", 1.0),
            ],
            &[(2, "Subtract")],
        );
        let scale = Scale::of(&[None, Some(&given)]).unwrap().unwrap();
        let scalers = BTreeMap::from([(0, vec![1.0, 2.0, 3.0]), (1, vec![10.0, 20.0])]);
        assert_eq!(scale.apply(&mut Data { scalers, ..Data::default() }).unwrap(), [9.0, 18.0]);
        assert!(scale.apply(&mut Data::default()).unwrap_err().starts_with("its scale takes values"));
    }

    #[test]
    fn scales_that_are_not_read_say_so() {
        let wrong =
            |entries: &[(&str, f64)], kinds: &[(u32, &str)]| applied(&properties(entries, kinds), &[1.0]).unwrap_err();
        assert_eq!(wrong(&[], &[(0, "RTD")]), "its scale is of the kind `RTD`, which is not read");
        assert_eq!(wrong(&[], &[(0, "Linear")]), "its scale 0 has no `Linear_Slope`");
        assert_eq!(
            wrong(&[("NI_Scale[0]_Linear_Input_Source", 0.0)], &[(0, "Linear")]),
            "its scale 0 takes what comes behind it"
        );
        let many = [("NI_Scale[0]_Polynomial_Coefficients_Size", 1e9)];
        assert_eq!(wrong(&many, &[(0, "Polynomial")]), "its scale has more than 64 coefficients");
        let given = properties(&[("NI_Number_Of_Scales", 1.0)], &[]);
        assert!(applied(&given, &[1.0]).is_err());
        let mut scaled = properties(&[], &[(0, "RTD")]);
        scaled.insert("NI_Scaling_Status".to_owned(), Value::Text("scaled".to_owned()));
        assert_eq!(Scale::of(&[Some(&scaled)]), Ok(None));
    }
}
