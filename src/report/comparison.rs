//! The comparison of a model with a record in a few lines: the verdict first, the next command last.

use super::brief::{few, next_line, wrapped};
use super::caveats::{OFF_NAMED, far_from_stated, off_sheet, unsure_file};
use super::learn::{adequate, goes_with, multiple, named_fault, times};
use super::table::{Head, aligned};
use crate::diagnosis::CLEARLY_ABOVE_NOISE;
use crate::finding::{Consequence, argument};
use crate::learn::comparison::{ChannelComparison, Comparison, MisfitPlace, PresentFault, WithFaults};
use crate::number::{rounded, text, with_unit};

/// Sensors that the short text shows.
const FEW: usize = 3;
/// Faults that it shows where they do not explain the record, and where they do.
const NOT_ENOUGH: usize = 1;
const EXPLAINING: usize = 4;

/// The comparison for people, beside that of an older rig file where there is one; with `all` its sensors, else the worst.
pub fn brief(comparison: &Comparison, events: &[Consequence], all: bool) -> String {
    let before = comparison.before.as_ref();
    let mut lines = headline(comparison);
    // Faults that explain the record say more than the place where the model without them is off.
    let explained = comparison.with_faults.as_ref().is_some_and(|with| with.adequate);
    if let Some(place) = comparison.place.as_ref().filter(|_| !explained) {
        lines.extend(located(place, all));
    }
    lines.extend(read(events).iter().flat_map(|words| wrapped(words, "  ")));
    if let Some(with_faults) = &comparison.with_faults {
        let (heading, faults) = explained_by(with_faults);
        let faults: Vec<&str> = faults.iter().map(String::as_str).collect();
        if all || (with_faults.adequate && faults.len() <= EXPLAINING) {
            lines.push(heading);
            lines.extend(faults.iter().map(|fault| format!("  {fault}")));
        } else {
            let shown = if with_faults.adequate { EXPLAINING } else { NOT_ENOUGH };
            lines.extend(wrapped(&format!("{heading} {}.", few(&faults, shown)), "  "));
        }
    }
    if let Some(before) = before {
        let with = before.with_faults.as_ref();
        let with = with.map_or_else(String::new, |with| format!(", with faults {}", multiple(with.times_noise)));
        lines.extend(wrapped(&format!("Before ({}): {}{with}.", before.rig, times(before.times_noise)), "  "));
    }
    lines.extend(stated(comparison).filter(|_| all).iter().flat_map(|words| wrapped(words, "  ")));
    lines.extend(far(comparison).iter().flat_map(|words| wrapped(words, "  ")));
    lines.extend(of_the_file(comparison).iter().flat_map(|words| wrapped(words, "  ")));
    lines.push(String::new());
    let (heads, mut rows) = table(comparison);
    let hidden = if all { Vec::new() } else { beyond(comparison) };
    let mut places = 0..;
    rows.retain(|_| places.next().is_none_or(|place| !hidden.contains(&place)));
    lines.extend(aligned(&heads, &rows));
    if let Some(most) = hidden.iter().map(|&place| comparison.channels[place].times_noise).reduce(f64::max) {
        lines.push(format!("  and {} more, at most {}", hidden.len(), multiple(most)));
    }
    // Where a sensor is missed, what others have in tolerance is no question.
    let is_misfit = !comparison.adequate && !all;
    let within = |channel: &ChannelComparison| {
        channel.adequate && channel.samples > 0 && channel.times_noise > CLEARLY_ABOVE_NOISE
    };
    let is_shown = |(place, channel): (usize, &ChannelComparison)| !hidden.contains(&place) && within(channel);
    if !is_misfit && comparison.channels.iter().enumerate().any(is_shown) {
        let told = "in tolerance: more than noise is left, but no more than the rig file allows of sensors and where valves switch.";
        lines.extend(wrapped(told, "  "));
    }
    lines.extend(beyond_events(comparison));
    if !all {
        lines.push("`--all` shows every sensor, phase and fault, chi-square and the NRMSE fit.".to_owned());
    }
    lines.push(next_line(&next(comparison)));
    lines.join("\n") + "\n"
}

/// What is read off the record beside the model.
pub(super) fn read(events: &[Consequence]) -> Option<String> {
    let texts: Vec<&str> = events.iter().map(|event| event.text.as_str()).collect();
    (!texts.is_empty()).then(|| format!("Measured against your model: {}.", texts.join("; ")))
}

/// The sensors beyond the few that are missed most, by their places.
fn beyond(comparison: &Comparison) -> Vec<usize> {
    let mut places: Vec<usize> = (0..comparison.channels.len()).collect();
    places.sort_by(|&a, &b| comparison.channels[b].times_noise.total_cmp(&comparison.channels[a].times_noise));
    places.split_off(FEW.min(places.len()))
}

/// The error with nothing fitted, where it is another: what other commands say of the values of the rig file.
pub(super) fn stated(comparison: &Comparison) -> Option<String> {
    let stated = comparison.as_stated.as_ref()?.times_noise;
    (multiple(stated) != multiple(comparison.times_noise)).then(|| {
        let why = if stated < comparison.times_noise {
            " (less: a fit counts samples for little where valves switch)"
        } else {
            ""
        };
        format!(
            "Your model is the healthy one, with uncertain values fitted to this record; with all values as the rig file has them it is {} off{why}.",
            multiple(stated)
        )
    })
}

/// What the healthy model has otherwise than stated, farther than chance, where it explains the record: one that does not is bent in its
/// values for what is missing elsewhere.
pub(super) fn far(comparison: &Comparison) -> Option<String> {
    let far = comparison.far_off().filter(|_| comparison.adequate)?;
    let told = far_from_stated(&far.id, [far.value, far.nominal], &far.unit, far.deviations());
    let end = if far.is_at_end { " (the end of its search)" } else { "" };
    Some(format!("Your model has {told}{end}: that value, or the model, is other than stated."))
}

/// What the rig file leaves open, where a misfit may be its doing.
pub(super) fn of_the_file(comparison: &Comparison) -> Option<String> {
    let explained = comparison.adequate || comparison.with_faults.as_ref().is_some_and(|with| with.adequate);
    unsure_file(comparison.unfilled, comparison.taken_as_exact, explained)
}

/// What `NO (events)` means, where a sensor has it.
fn beyond_events(comparison: &Comparison) -> Vec<String> {
    let with_faults = comparison.with_faults.as_ref().map_or(&[][..], |with| &with.channels);
    let is_explained = |name: &str| with_faults.iter().any(|with| with.name == name && with.adequate);
    let is_by_events =
        |channel: &&ChannelComparison| !channel.adequate && channel.within_noise && !is_explained(&channel.name);
    let asked = comparison.channels.iter().filter(is_by_events).filter_map(|channel| channel.events_chi2);
    let most = asked.fold(0.0, f64::max);
    if most == 0.0 {
        return Vec::new();
    }
    let times = text(rounded(most.sqrt(), 2));
    let told = format!(
        "NO (events): switchings would have to differ by {times} times what the rig file leaves open of them, or more (lags, loads, \
         timing)."
    );
    wrapped(&told, "  ")
}

fn headline(comparison: &Comparison) -> Vec<String> {
    let error = times(comparison.times_noise);
    let line = match &comparison.with_faults {
        _ if comparison.adequate => adequate(comparison),
        Some(with) if with.adequate => {
            let what = match (with.faults.as_slice(), &with.off_data_sheet) {
                ([], _) => "parts as far off their data sheets as parts are",
                (_, None) => "the faults below",
                (_, Some(_)) => "the faults below, and parts as far off their data sheets as parts are,",
            };
            format!("MISFIT: your model does not explain the record, {error}; with {what} it does.")
        }
        _ => format!("MISFIT: your model does not explain the record, {error}."),
    };
    wrapped(&line, "  ")
}

/// Where the misfit is largest, and with `all` what it correlates with.
fn located(place: &MisfitPlace, all: bool) -> Vec<String> {
    let goes = match goes_with(place) {
        some if all && !some.is_empty() => format!(" Correlates with {some}."),
        _ => String::new(),
    };
    let told = format!(
        "  Largest in {} ({}), {} from {:.2} to {:.2} s.{goes}",
        place.channel, place.equation, place.phase, place.from_s, place.to_s
    );
    wrapped(&told, "  ")
}

/// What the faults that explain a record best leave, and each of them with its size.
pub(super) fn explained_by(with_faults: &WithFaults) -> (String, Vec<String>) {
    let enough = if with_faults.adequate { "" } else { "; not enough" };
    let left = times(with_faults.times_noise);
    let heading = match with_faults.faults.as_slice() {
        [] => format!("With parts off their data sheets, {left}{enough}; the furthest:"),
        _ => format!("With the faults that explain it best, {left}{enough}:"),
    };
    let furthest = with_faults.off_data_sheet.iter().flat_map(|off| off.values.iter().take(OFF_NAMED).map(off_sheet));
    (heading, with_faults.faults.iter().map(fault).chain(furthest).collect())
}

fn fault(fault: &PresentFault) -> String {
    format!("{} (new: {})", named_fault(fault), with_unit(rounded(fault.healthy, 4), &fault.unit))
}

/// What the model with faults, or with parts off their data sheets, is in a column.
fn of_the_other(with_faults: &WithFaults) -> &'static str {
    if with_faults.faults.is_empty() { "off data sheets" } else { "with faults" }
}

/// Sensor by sensor: your model, with faults, and the same of an older rig file.
pub(super) fn table(comparison: &Comparison) -> (Vec<Head>, Vec<Vec<String>>) {
    let with_faults = comparison.with_faults.as_ref();
    let before = comparison.before.as_ref();
    let before_with = before.and_then(|before| before.with_faults.as_ref());
    let mut heads: Vec<Head> = vec![("sensor", false), ("rms misfit", true), ("unit", false), ("x noise", true)];
    heads.extend(with_faults.map(|with| (of_the_other(with), true)));
    heads.extend(before.map(|_| ("before", true)));
    heads.extend(before_with.map(|_| ("before, with faults", true)));
    heads.push(("explained", false));
    let rows = comparison.channels.iter().map(|channel| {
        let same = |channels: &[ChannelComparison]| channels.iter().find(|other| other.name == channel.name).cloned();
        let of =
            |channels: &[ChannelComparison]| same(channels).map_or_else(|| "-".to_owned(), |one| times_noise(&one));
        let misfit = if channel.samples == 0 { "-".to_owned() } else { text(rounded(channel.rmse, 3)) };
        let mut row = vec![channel.name.clone(), misfit, channel.unit.clone(), times_noise(channel)];
        row.extend(with_faults.map(|with_faults| of(&with_faults.channels)));
        row.extend(before.map(|before| of(&before.channels)));
        row.extend(before_with.map(|with_faults| of(&with_faults.channels)));
        let with = with_faults.and_then(|with_faults| same(&with_faults.channels));
        row.push(match with {
            Some(with) if with.adequate && !channel.adequate => with_faults.map_or("", of_the_other).to_owned(),
            _ => super::diagnosis_tables::explained(
                channel.adequate,
                (channel.samples, channel.times_noise),
                channel.within_noise,
            )
            .to_owned(),
        });
        row
    });
    (heads, rows.collect())
}

fn times_noise(channel: &ChannelComparison) -> String {
    if channel.samples == 0 { "-".to_owned() } else { text(rounded(channel.times_noise, 2)) }
}

/// The command that leads further.
pub(super) fn next(comparison: &Comparison) -> String {
    let (rig, record) = (argument(&comparison.rig), argument(&comparison.record));
    match &comparison.with_faults {
        _ if comparison.unfilled > 0 => format!("borescope check {rig} {record}"),
        // What lies within the tolerance may be physics all the same, but first what data sheets are not exact enough to tell.
        _ if comparison.adequate && comparison.times_noise > CLEARLY_ABOVE_NOISE && comparison.taken_as_exact > 0 => {
            format!("borescope calibrate {rig} HEALTHY_RECORD... -o calibrated.toml")
        }
        _ if comparison.adequate && comparison.times_noise > CLEARLY_ABOVE_NOISE => {
            format!("borescope suggest {rig} {record} --check ANOTHER_RECORD")
        }
        _ if comparison.adequate => format!("borescope diagnose {rig} {record}"),
        Some(with) if with.adequate && with.faults.is_empty() => {
            format!("borescope calibrate {rig} HEALTHY_RECORD... -o calibrated.toml")
        }
        Some(with) if with.adequate => format!("borescope diagnose {rig} {record}"),
        _ => format!("borescope suggest {rig} {record} --check ANOTHER_RECORD"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::learn::comparison::Earlier;

    fn channel(name: &str, times_noise: f64) -> ChannelComparison {
        ChannelComparison {
            name: name.to_owned(),
            unit: "bar".to_owned(),
            rmse: 0.25 * times_noise,
            noise_sigma: 0.25,
            times_noise,
            fit_percent: None,
            samples: 100,
            chi2_reduced: times_noise * times_noise,
            events_chi2: None,
            adequate: times_noise < 1.2,
            within_noise: times_noise < 1.2,
            autocorrelation: 0.0,
            goes_with: Vec::new(),
            worst: Vec::new(),
        }
    }

    fn comparison(times_noise: f64) -> Comparison {
        Comparison {
            schema: crate::learn::comparison::SCHEMA,
            rig: "rig.toml".to_owned(),
            record: "record.csv".to_owned(),
            adequate: times_noise < 1.2,
            times_noise,
            chi2_reduced: times_noise * times_noise,
            place: None,
            channels: vec![channel("p_A", times_noise)],
            fitted: Vec::new(),
            as_stated: None,
            with_faults: None,
            unfilled: 0,
            taken_as_exact: 0,
            before: None,
        }
    }

    #[test]
    fn faults_that_explain_the_record_lead_to_the_diagnosis() {
        let fault = PresentFault {
            id: "cylinder.clearance".to_owned(),
            meaning: "clearance of the piston".to_owned(),
            value: 0.200_31,
            unit: "mm".to_owned(),
            healthy: 0.0,
            ci95: [Some(0.199), Some(0.201)],
        };
        let with_faults = WithFaults {
            faults: vec![fault],
            off_data_sheet: None,
            times_noise: 1.02,
            adequate: true,
            channels: vec![channel("p_A", 1.02)],
        };
        let before = Some(Earlier::of(&comparison(51.2)));
        let page = brief(&Comparison { with_faults: Some(with_faults), before, ..comparison(44.7) }, &[], false);
        let lines: Vec<&str> = page.lines().collect();
        assert_eq!(lines[0], "MISFIT: your model does not explain the record, 45x the sensor noise; with the");
        assert_eq!(lines[1], "  faults below it does.");
        assert_eq!(lines[2], "With the faults that explain it best, 1x the sensor noise:");
        assert_eq!(lines[3], "  cylinder.clearance 0.2003 mm (new: 0 mm)");
        assert_eq!(lines[4], "Before (rig.toml): 51x the sensor noise.");
        let row: Vec<&str> = lines[7].split_whitespace().collect();
        assert_eq!(row, ["p_A", "11.2", "bar", "45", "1", "51", "with", "faults"]);
        assert_eq!(lines[8], "`--all` shows every sensor, phase and fault, chi-square and the NRMSE fit.");
        assert_eq!(lines[9], "Next: borescope diagnose rig.toml record.csv");
        assert!(lines.iter().all(|line| line.len() <= 80), "{page}");
    }

    #[test]
    fn a_draft_leads_to_its_open_values() {
        let page = brief(&Comparison { unfilled: 16, ..comparison(610.0) }, &[], false);
        assert!(page.contains("16 values of the rig file are still marked DATA SHEET"), "{page}");
        assert!(page.contains("\nNext: borescope check rig.toml record.csv\n"), "{page}");
    }

    #[test]
    fn values_taken_as_exact_are_doubted_before_physics_is_missing() {
        let page = brief(&Comparison { taken_as_exact: 14, ..comparison(80.0) }, &[], false);
        let text = page.split_whitespace().collect::<Vec<_>>().join(" ");
        assert!(
            text.contains("14 values count as exact; a wrong one looks like missing physics: calibrate."),
            "{page}"
        );
        assert!(page.lines().all(|line| line.len() <= 80), "{page}");
        assert!(!brief(&Comparison { taken_as_exact: 14, ..comparison(1.0) }, &[], false).contains("count as exact"));
    }

    #[test]
    fn what_no_fault_explains_leads_to_the_missing_effect() {
        assert!(
            brief(&comparison(3.0), &[], false)
                .contains("\nNext: borescope suggest rig.toml record.csv --check ANOTHER_RECORD\n")
        );
        // More than the noise and yet adequate: the reader is told why.
        let above = brief(&Comparison { adequate: true, ..comparison(2.1) }, &[], false);
        let above = above.split_whitespace().collect::<Vec<_>>().join(" ");
        assert!(above.starts_with("ADEQUATE only within tolerance: 2.1x the sensor noise is left"), "{above}");
        assert!(
            brief(&comparison(1.0), &[], false)
                .starts_with("ADEQUATE: your model explains the record, 1x the sensor noise.")
        );
    }
}
