//! What one has to know with a verdict: what the record does not say, and what else the verdict may come from.

use super::table::few;
use crate::diagnosis::OTHER_OIL;
use crate::diagnosis::summary::reads_otherwise;
use crate::diagnosis::{
    ChannelReport, Diagnosis, DynamicsReport, FAR_OFF, OffDataSheet, OffSheetValue, UncertainReport, Verdict,
};
use crate::estimation::Identifiable;
use crate::number::{before_unit, rounded, text, with_unit, worth};
use crate::record::survey::{Doubt, Finding, told};

/// Faults that could be there at any size without showing, and what a verdict other than healthy may come from although
/// nothing is worn.
pub(super) fn caveats(diagnosis: &Diagnosis) -> Vec<String> {
    // Without a remark there was no search for an interval.
    let untold = |fault: &&crate::diagnosis::FaultReport| {
        fault.identifiable == Identifiable::Unidentifiable && fault.remark.is_some()
    };
    let open: Vec<&str> = diagnosis.faults.iter().filter(untold).map(|fault| fault.id.as_str()).collect();
    let mut told: Vec<String> = drafted(diagnosis.unfilled).into_iter().collect();
    told.extend(diagnosis.at_odds.iter().map(|odd| format!("Record and rig file differ: {odd}.")));
    if let Some(cause) = &diagnosis.common_cause {
        let without = match cause.instead_of.as_slice() {
            [] => "no faults of this rig explain the record".to_owned(),
            some => format!("it would take {}", some.join(", ")),
        };
        let check = if cause.kind == OTHER_OIL { "which oil it is and how warm" } else { "how the record was taken" };
        told.push(format!("Check {check}: if it is not so that {}, {without}.", cause.clause));
    }
    told.extend(diagnosis.off_data_sheet.as_ref().map(off_data_sheet));
    told.extend(undeclared(&diagnosis.undeclared));
    told.extend(diagnosis.below_vacuum.as_ref().map(|below| format!("By the explanation {below}.")));
    let explained = diagnosis.missing_effect.as_ref().is_some_and(|missing| missing.explained);
    // Where a sensor is missed, what the others leave is no wonder.
    if diagnosis.is_explained() || explained {
        told.extend(weighed_down(&diagnosis.channels));
    }
    told.extend(followed_otherwise(&diagnosis.dynamics));
    told.extend(far_off(&diagnosis.uncertain));
    if !open.is_empty() {
        told.push(format!("The record does not determine {}.", open.join(", ")));
    }
    if diagnosis.verdict == Verdict::Healthy {
        return told;
    }
    for channel in &diagnosis.channels {
        if let Some(ratio) = channel.ratio_to_healthy {
            told.push(reads_otherwise(&channel.name, ratio, &channel.unit));
        }
    }
    if !diagnosis.is_explained() && !explained {
        let asks =
            "`borescope check` asks whether columns are exchanged, or a value of the rig file is in another unit.";
        told.push(asks.to_owned());
    }
    match diagnosis.verdict {
        Verdict::ModelInadequate => told.extend(taken_as_exact(&diagnosis.taken_as_exact)),
        _ if !diagnosis.as_new.is_empty() => told.push(no_further_off(&diagnosis.as_new)),
        _ => told.extend(which_are_exact(&diagnosis.taken_as_exact)),
    }
    // A record that is explained across the gap need not be split there.
    let gap = longest_gap(diagnosis).filter(|_| !diagnosis.is_explained());
    told.extend(gap.map(|gap| {
        let [from, to] = [gap.from_s, gap.to_s].map(|time| text(rounded(time, 9)));
        format!("Rows are missing from {from} s to {to} s: the commands there are not known; split the record there.")
    }));
    told
}

/// That a result means little while values are those of a draft.
fn drafted(unfilled: usize) -> Option<String> {
    let what = match unfilled {
        0 => return None,
        1 => "One value of the rig file is still marked DATA SHEET: until it is that".to_owned(),
        several => format!("{several} values of the rig file are still marked DATA SHEET: until they are those"),
    };
    Some(format!("{what} of your machine, this says little. `borescope check` names the lines."))
}

/// What of a rig file may be behind a misfit: values of a draft, or else of data sheets, as long as nothing explains the record.
#[cfg(feature = "cli")]
pub(super) fn unsure_file(unfilled: usize, taken_as_exact: usize, explained: bool) -> Option<String> {
    let sheet = |count: usize| {
        let (values, count_as) = if count == 1 { ("value", "counts as") } else { ("values", "count as") };
        format!("{count} {values} {count_as} exact; a wrong one looks like missing physics: calibrate.")
    };
    drafted(unfilled).or_else(|| (taken_as_exact > 0 && !explained).then(|| sheet(taken_as_exact)))
}

/// What the fit record does not tell of the check record.
pub(super) fn left_open(names: &[String]) -> Option<String> {
    let names: Vec<&str> = names.iter().map(String::as_str).collect();
    let told = || format!("Not determined by the fit record, so left open in the check record: {}.", few(&names, 2));
    (!names.is_empty()).then(told)
}

/// Values off their data sheets that are named.
pub(super) const OFF_NAMED: usize = 3;

/// A value with what the rig file states.
pub(super) fn off_sheet(off: &OffSheetValue) -> String {
    let value = before_unit(worth(off.value, off.sigma_before), &off.unit);
    format!("{} {value} (stated {})", off.id, text(rounded(off.nominal, 4)))
}

/// What the record takes otherwise than the rig file states it.
fn off_data_sheet(off: &OffDataSheet) -> String {
    let named: Vec<String> = off.values.iter().take(OFF_NAMED).map(off_sheet).collect();
    let more = match off.values.len().saturating_sub(OFF_NAMED) {
        0 => String::new(),
        more => format!(" and {more} more"),
    };
    let otherwise = match off.instead_of.as_slice() {
        [] => "no faults explain the record".to_owned(),
        some => format!("it would take {}", some.join(", ")),
    };
    let then = match off.beyond_chance() {
        None => "Calibrate on healthy records: intervals become narrower.".to_owned(),
        Some(one) => format!(
            "In 19 of 20 new machines none of {} values is as far off as {}: it has changed, or physics is missing, which `suggest` asks.",
            off.values.len(),
            one.id
        ),
    };
    format!(
        "This takes parts to be as far off their data sheets as parts are: {}{more}. With every value as stated, {otherwise}, and {}x the sensor noise is left. \
         {then}",
        named.join(", "),
        text(rounded(off.times_noise_as_stated, 2))
    )
}

/// Faults that were found although the rig file declares none of them.
fn undeclared(ids: &[String]) -> Option<String> {
    let (is, its, it) = match ids {
        [] => return None,
        [_] => ("is no declared fault", "its value has", "it"),
        _ => ("are no declared faults", "their values have", "them"),
    };
    Some(format!(
        "{} {is} of the rig file: {its} changed, or the file has {it} wrong. Declare {it} under `[faults]` to have every record searched for {it}, \
         or correct the file.",
        ids.join(", ")
    ))
}

/// So many of them are named.
const ABOVE_NAMED: usize = 3;

/// Sensors that count as explained although more than noise is left.
fn weighed_down(channels: &[ChannelReport]) -> Option<String> {
    let mut above: Vec<&ChannelReport> = channels.iter().filter(|one| one.is_above_noise()).collect();
    above.sort_by(|a, b| b.times_noise.total_cmp(&a.times_noise));
    let one = |one: &&ChannelReport| format!("{} {}x", one.name, text(rounded(one.times_noise, 2)));
    let mut named: Vec<String> = above.iter().take(ABOVE_NAMED).map(one).collect();
    if above.len() > ABOVE_NAMED {
        named.push(format!("{} more", above.len() - ABOVE_NAMED));
    }
    (!above.is_empty()).then(|| {
        format!(
            "Above the noise and explained all the same: {}; within the tolerance of the rig file, or by timing where the curve is steep.",
            named.join(", ")
        )
    })
}

/// Values of data sheets that a model which does not explain its record takes as exact.
fn taken_as_exact(ids: &[String]) -> Option<String> {
    let names: Vec<&str> = ids.iter().map(String::as_str).collect();
    let named = few(&names, EXACT_NAMED);
    (!ids.is_empty()).then(|| {
        format!(
            "Before you believe faults or missing physics: {named} are taken as exact, although parts deviate from data sheets. \
             Calibrate on healthy records, or state `+-`; `borescope check` lists them."
        )
    })
}

/// Faults as small as what new parts deviate by.
fn no_further_off(ids: &[String]) -> String {
    let (is, its, it) = if ids.len() == 1 { ("is", "its", "it") } else { ("are", "their", "them") };
    format!(
        "{} {is} no further off than new parts of {its} kind: before you believe {it}, calibrate on healthy records, or state `+-` at the \
         component.",
        ids.join(", ")
    )
}

/// The same beside faults that explain the record, in a line.
fn which_are_exact(ids: &[String]) -> Option<String> {
    match ids {
        [] => None,
        [one] => Some(format!("Intervals take {one} as exact: give it `+-`, or calibrate.")),
        [one, other] => Some(format!("Intervals take {one} and {other} as exact: give them `+-`, or calibrate.")),
        all => Some(format!("Intervals take {} data-sheet values as exact: give them `+-`, or calibrate.", all.len())),
    }
}

/// So many exact values are named.
const EXACT_NAMED: usize = 3;

/// So many values that are far from those of the rig file are named.
const FAR_NAMED: usize = 3;

/// A value beside that of the rig file.
pub(super) fn far_from_stated(id: &str, [value, nominal]: [f64; 2], unit: &str, deviations: f64) -> String {
    let [value, nominal] = [value, nominal].map(|value| with_unit(rounded(value, 4), unit));
    format!("{id} at {value}, {deviations:.1} standard deviations from {nominal}")
}

/// Uncertain parameters that are not believed where an explanation has them.
fn far_off(uncertain: &[UncertainReport]) -> Option<String> {
    let one = |one: &UncertainReport| {
        let told = far_from_stated(&one.id, [one.value, one.nominal], &one.unit, one.deviations());
        if one.sigma_after.is_none() { format!("{told} (the end of its search)") } else { told }
    };
    let mut far: Vec<&UncertainReport> = uncertain.iter().filter(|one| one.deviations() > FAR_OFF).collect();
    far.sort_by(|a, b| b.deviations().total_cmp(&a.deviations()));
    let mut told: Vec<String> = far.iter().take(FAR_NAMED).map(|far| one(far)).collect();
    if far.len() > FAR_NAMED {
        told.push(format!("and {} more as far off", far.len() - FAR_NAMED));
    }
    (!far.is_empty()).then(|| {
        format!(
            "This explanation has {}: that value or the model is other than stated, and what depends on it is less sure than its \
             interval says.",
            told.join(", ")
        )
    })
}

/// How spools follow, where a record asks for other than the rig file has.
pub(super) fn followed_otherwise(dynamics: &[DynamicsReport]) -> Option<String> {
    let other =
        |one: &DynamicsReport| format!("{} {} {} ({} stated)", one.id, text(one.value), one.unit, text(one.nominal));
    let others: Vec<String> = dynamics.iter().map(other).collect();
    let told = || format!("The record shows that spools follow otherwise than stated: {}.", others.join(", "));
    (!others.is_empty()).then(told)
}

/// The same where a model has learnt with them.
pub(super) fn learnt_with(dynamics: &[DynamicsReport]) -> Option<String> {
    followed_otherwise(dynamics).map(|told| told + " All errors are those with them.")
}

/// How long a directional valve of size 10 takes at most, s.
const SWITCHING: f64 = 0.1;

/// The longest stretch of missing rows, if it is long enough to hide a switching.
fn longest_gap(diagnosis: &Diagnosis) -> Option<&Finding> {
    let missing = diagnosis.left_out.iter().filter(|finding| finding.doubt == Doubt::MissingRows);
    let length = |finding: &Finding| finding.to_s - finding.from_s;
    missing.filter(|finding| length(finding) > SWITCHING).max_by(|a, b| length(a).total_cmp(&length(b)))
}

/// When something goes wrong within the record, and when the record shows it.
pub(super) fn detected(diagnosis: &Diagnosis) -> Option<String> {
    let by_residual = diagnosis.residuals.iter().any(|residual| residual.fired);
    let how = match (by_residual, diagnosis.residuals.is_empty()) {
        (true, _) => "",
        (false, true) => {
            ", by the fit: the sensors of this rig allow no residuals (`isolability` names some that would)"
        }
        (false, false) => ", by the fit: no residual raised an alarm",
    };
    when(diagnosis.onset_s, diagnosis.detected_at_s, how)
}

/// A beginning within the record and a detection, s, and by what.
fn when(onset: Option<f64>, detected: Option<f64>, how: &str) -> Option<String> {
    let Some(at) = detected else { return onset.map(|onset| format!("Begins at {onset:.2} s.")) };
    let begins = onset.map_or("Detected".to_owned(), |onset| format!("Begins at {onset:.2} s; detected"));
    Some(format!("{begins} at {at:.2} s{how}."))
}

/// Findings that a page tells one by one.
pub(super) const TOLD: usize = 12;

/// What of the record the fit does not have, in words, the first `most` one by one.
pub fn left_out<'a>(findings: impl IntoIterator<Item = &'a Finding>, most: usize) -> Vec<String> {
    let findings: Vec<&Finding> = findings.into_iter().collect();
    let mut words = told(findings.iter().copied());
    if findings.iter().any(|finding| finding.doubt == Doubt::MissingRows) {
        words.push("where rows are missing the model continues, with inputs as their `hold` says".to_owned());
    }
    let more = words.len().saturating_sub(most);
    words.truncate(most);
    if more > 0 {
        words.push(format!("and {more} more, which `check` lists"));
    }
    words
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_fault_that_begins_within_the_record_says_when() {
        let told = [
            when(Some(16.0), Some(16.25), ", by the fit"),
            when(None, Some(0.5), ""),
            when(Some(16.0), None, ""),
            when(None, None, ""),
        ];
        assert_eq!(
            told.map(Option::unwrap_or_default),
            ["Begins at 16.00 s; detected at 16.25 s, by the fit.", "Detected at 0.50 s.", "Begins at 16.00 s.", ""]
        );
    }

    #[test]
    fn a_sensor_that_is_explained_above_its_noise_says_why() {
        let one = |name: &str, times_noise: f64, adequate: bool| ChannelReport {
            name: name.to_owned(),
            unit: "bar".to_owned(),
            rmse: times_noise,
            noise_sigma: 1.0,
            times_noise,
            samples: 100,
            chi2_reduced: 1.0,
            events_chi2: None,
            adequate,
            within_noise: adequate,
            ratio_to_healthy: None,
        };
        assert_eq!(weighed_down(&[one("p_A", 1.4, true), one("p_B", 6.0, false)]), None);
        let told = weighed_down(&[one("p_A", 1.6, true), one("p_B", 6.04, true)]).unwrap();
        assert!(
            told.starts_with("Above the noise and explained all the same: p_B 6x, p_A 1.6x; within the tolerance"),
            "{told}"
        );
    }

    #[test]
    fn a_value_that_is_not_believed_is_told_with_its_distance() {
        let one = |id: &str, value: f64| UncertainReport {
            id: id.to_owned(),
            value,
            unit: "mPa.s".to_owned(),
            nominal: 31.14,
            sigma_before: 1.557,
            sigma_after: None,
        };
        assert_eq!(far_off(&[one("fluid.viscosity", 37.3)]), None);
        let told = far_off(&[one("fluid.viscosity", 21.798), one("other", 31.0)]).unwrap();
        assert!(
            told.starts_with(
                "This explanation has fluid.viscosity at 21.8 mPa.s, 6.0 standard deviations from 31.14 mPa.s (the end of its search):"
            ),
            "{told}"
        );
    }
}
