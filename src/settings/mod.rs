//! Every threshold of diagnosis, learning and calibration, each with its unit, its meaning and where its value comes from.
//!
//! A threshold is written once, in the table of its group; code reads it as a field. [`Settings`] come with the
//! [context](crate::Context) of a rig, so two computations in one program may have different ones. What is no threshold stays where it
//! is used: constants of physics and mathematics, grids of starts, digits that are printed.

use crate::complaint::{Complaint, Kind};

/// A group of settings, from a table of `meaning, name: type = value, "unit", "derivation"`.
macro_rules! settings {
    (
        $(#[$about:meta])*
        $group:ident, $prefix:literal {
            $($(#[doc = $meaning:literal])+ $name:ident: $kind:ty = $value:expr, $unit:literal, $derivation:literal;)*
        }
    ) => {
        $(#[$about])*
        #[derive(Debug, Clone, PartialEq)]
        pub(crate) struct $group {
            $($(#[doc = $meaning])+ pub $name: $kind,)*
        }

        impl Default for $group {
            fn default() -> Self {
                Self { $($name: $value,)* }
            }
        }

        impl $group {
            /// Each with its value here.
            pub(super) fn each(&self) -> impl Iterator<Item = $crate::settings::Setting> {
                [$($crate::settings::Setting {
                    id: concat!($prefix, ".", stringify!($name)),
                    value: $crate::settings::Number::to_f64(self.$name),
                    is_whole: <$kind as $crate::settings::Number>::IS_WHOLE,
                    unit: $unit,
                    meaning: concat!($($meaning),+).trim_ascii(),
                    derivation: $derivation,
                },)*]
                .into_iter()
            }

            /// Sets the one of this name; others are left.
            pub(super) fn set(&mut self, id: &str, value: f64) {
                $(if id == concat!($prefix, ".", stringify!($name)) {
                    self.$name = $crate::settings::Number::of(value);
                })*
            }
        }
    };
}

mod calibration;
mod diagnosis;
mod learn;

pub(crate) use calibration::CalibrationSettings;
pub(crate) use diagnosis::DiagnosisSettings;
pub(crate) use learn::LearningSettings;

/// The thresholds of diagnosis, learning and calibration.
///
/// ```
/// use borescope::{Context, Rig, Settings};
///
/// // Fewer false alarms of sensors: one normal value in 1.7 million instead of one in 30,000.
/// let settings = Settings::default().with("diagnosis.adequate_deviations", 5.0)?;
/// let context = Context::new().with_settings(settings);
/// let rig = Rig::read("fixtures/telescopic/rig.toml")?.with_context(&context);
/// for setting in rig.context().settings().each() {
///     println!("{} = {} {}: {}", setting.id, setting.value, setting.unit, setting.meaning);
/// }
/// assert!(Settings::default().with("diagnosis.adequate_deviation", 5.0).is_err());
/// # Ok::<(), borescope::Complaint>(())
/// ```
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Settings {
    /// Of diagnoses.
    pub(crate) diagnosis: DiagnosisSettings,
    /// Of what compares models and learns what they lack.
    pub(crate) learn: LearningSettings,
    /// Of calibrations.
    pub(crate) calibration: CalibrationSettings,
}

/// One of the settings.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Setting {
    /// Such as `diagnosis.present_probability`.
    pub id: &'static str,
    /// In `unit`.
    pub value: f64,
    /// Whether it is a number of things.
    pub is_whole: bool,
    /// What one of it is.
    pub unit: &'static str,
    /// What depends on it.
    pub meaning: &'static str,
    /// Why it has the value that it has by default.
    pub derivation: &'static str,
}

impl Setting {
    /// Whether its values are shares of a whole, 0 to 1.
    pub fn is_share(&self) -> bool {
        ["probability", "share", "cosine", "correlation"].iter().any(|one| self.unit.starts_with(one))
    }
}

impl Settings {
    /// Each with its value here, group by group.
    pub fn each(&self) -> impl Iterator<Item = Setting> {
        self.diagnosis.each().chain(self.learn.each()).chain(self.calibration.each())
    }

    /// The same with one at another value.
    ///
    /// # Errors
    /// No setting of this id, or a value that it cannot have.
    pub fn with(mut self, id: &str, value: f64) -> Result<Self, Complaint> {
        let Some(setting) = self.each().find(|setting| setting.id == id) else {
            return Err(Complaint::new(Kind::UnknownName, format!("there is no setting `{id}`"))
                .help("`docs/reference/settings.md` lists them"));
        };
        let whole = !setting.is_whole || (value >= 1.0 && value.fract() == 0.0 && value <= f64::from(u32::MAX));
        if !(value > 0.0 && value.is_finite() && whole && (value < 1.0 || setting.unit != "probability")) {
            let may_be = match setting.unit {
                "probability" => "a number between 0 and 1",
                _ if setting.is_whole => "a whole number, 1 or more",
                _ => "a number above 0",
            };
            return Err(
                Complaint::new(Kind::Bounds, format!("`{id}` cannot be {value}")).help(format!("give {may_be}"))
            );
        }
        self.diagnosis.set(id, value);
        self.learn.set(id, value);
        self.calibration.set(id, value);
        Ok(self)
    }
}

/// A number that a setting may be.
trait Number: Copy {
    const IS_WHOLE: bool;

    fn of(value: f64) -> Self;
    fn to_f64(self) -> f64;
}

impl Number for f64 {
    const IS_WHOLE: bool = false;

    fn of(value: f64) -> Self {
        value
    }

    fn to_f64(self) -> f64 {
        self
    }
}

impl Number for usize {
    const IS_WHOLE: bool = true;

    fn of(value: f64) -> Self {
        value as Self
    }

    fn to_f64(self) -> f64 {
        self as f64
    }
}

impl Number for u64 {
    const IS_WHOLE: bool = true;

    fn of(value: f64) -> Self {
        value as Self
    }

    fn to_f64(self) -> f64 {
        self as f64
    }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use super::*;

    #[test]
    fn each_has_an_id_of_its_own_and_says_what_it_is_and_why() {
        let all: Vec<Setting> = Settings::default().each().collect();
        let ids: BTreeSet<&str> = all.iter().map(|setting| setting.id).collect();
        assert_eq!(ids.len(), all.len());
        for Setting { id, value, unit, meaning, derivation, .. } in all {
            assert!(value > 0.0 && !unit.is_empty(), "{id}");
            for text in [meaning, derivation] {
                assert!(text.len() > 4 && text.ends_with(['.', '`']) && !text.contains("  "), "{id}: {text}");
            }
        }
    }

    #[test]
    fn each_can_be_set_alone() {
        let given = Settings::default();
        for setting in given.each() {
            let value = if setting.is_whole { setting.value + 1.0 } else { 0.5 * setting.value };
            let other = given.clone().with(setting.id, value).unwrap();
            for (before, after) in given.each().zip(other.each()) {
                assert_eq!(after.value, if before.id == setting.id { value } else { before.value }, "{}", before.id);
            }
        }
    }

    #[test]
    fn what_a_setting_cannot_be_is_refused() {
        let refused = |id: &str, value: f64| Settings::default().with(id, value).unwrap_err().to_string();
        assert!(refused("diagnosis.present", 0.1).contains("no setting"));
        assert!(refused("diagnosis.present_probability", 1.0).contains("between 0 and 1"));
        assert!(refused("diagnosis.isolation_rounds", 0.5).contains("whole number"));
        assert!(refused("diagnosis.huber_width", f64::NAN).contains("above 0"));
    }
}
