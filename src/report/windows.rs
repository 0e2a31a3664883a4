//! A record that was watched window by window, for people.

use super::caveats::{TOLD, caveats, left_out};
use super::diagnosis_tables::{FAULT_HEADS, fault_rows};
use super::headline::{self, headline};
use super::style::{Style, Tone};
use super::table::{Head, aligned};
use crate::diagnosis::Diagnosis;
use crate::diagnosis::watch::{Episode, Watched, WatchedVerdict};
use crate::number::{rounded, text};

const RESIDUAL_HEADS: [Head; 5] =
    [("residual", false), ("onset", true), ("first alarm", true), ("alarms", true), ("phase", false)];

/// The whole as a page of text.
pub fn write_styled(watched: &Watched, style: Style) -> String {
    let (quiet, alarmed, blind) = watched.counts();
    let count = watched.windows.len();
    let mut lines = vec![style.painted(&told(watched), tone(watched.conclusion)), String::new()];
    lines.extend([format!("rig     {}", watched.rig), format!("record  {}", watched.record)]);
    lines.push(format!("{} rows from {} to {}", watched.rows, seconds(watched.from_s), seconds(watched.to_s)));
    lines.push(format!("{count} windows of {}: {quiet} quiet, {alarmed} with alarms", seconds(watched.window_s)));
    if blind > 0 {
        lines.push(format!("{blind} more cannot be judged: no residual applies there"));
    }
    if let Some(sample) = &watched.sample {
        lines.push(String::new());
        lines.extend(of_stretch(sample.diagnosed_s, &sample.diagnosis, style));
    }
    for (number, episode) in watched.episodes.iter().enumerate() {
        lines.push(String::new());
        lines.extend(of_episode(number + 1, episode, style));
    }
    lines.push(String::new());
    lines.join("\n")
}

/// The conclusion in one line.
fn told(watched: &Watched) -> String {
    let count = match watched.episodes.len() {
        0 => {
            let verdict = match watched.conclusion {
                WatchedVerdict::Healthy => return "HEALTHY: no residual raised an alarm in any window.".to_owned(),
                WatchedVerdict::Faulty => "FAULTY",
                WatchedVerdict::ModelInadequate | WatchedVerdict::NotDiagnosed => "MODEL INADEQUATE",
            };
            return format!("{verdict}: no residual raised an alarm, a window diagnosed in full does.");
        }
        1 => "1 episode".to_owned(),
        several => format!("{several} episodes"),
    };
    match watched.conclusion {
        WatchedVerdict::Healthy => {
            format!("HEALTHY: residuals raised alarms in {count}; their diagnoses found no fault.")
        }
        WatchedVerdict::Faulty => format!("FAULTY: residuals raised alarms in {count}."),
        WatchedVerdict::ModelInadequate => {
            format!("MODEL INADEQUATE: residuals raised alarms in {count}, which no faults of this rig explain.")
        }
        WatchedVerdict::NotDiagnosed => {
            format!("NOT DIAGNOSED: residuals raised alarms in {count}; the cause is not known.")
        }
    }
}

fn tone(conclusion: WatchedVerdict) -> Tone {
    match conclusion {
        WatchedVerdict::Healthy => Tone::Good,
        WatchedVerdict::Faulty => Tone::Alert,
        WatchedVerdict::ModelInadequate | WatchedVerdict::NotDiagnosed => Tone::Caution,
    }
}

fn seconds(value: f64) -> String {
    format!("{} s", text(rounded(value, 8)))
}

fn of_episode(number: usize, episode: &Episode, style: Style) -> Vec<String> {
    let (onset, first, last) = (episode.onset_s, episode.first_alarm_s, episode.last_alarm_s);
    let alarms = if episode.alarms == 1 { "1 alarm".to_owned() } else { format!("{} alarms", episode.alarms) };
    let mut lines = vec![format!(
        "Episode {number}: onset {}, {alarms} from {} to {}",
        seconds(onset),
        seconds(first),
        seconds(last)
    )];
    let rows: Vec<Vec<String>> = episode
        .residuals
        .iter()
        .map(|residual| {
            let (since, alarm) = (seconds(residual.onset_s), seconds(residual.first_alarm_s));
            vec![residual.id.clone(), since, alarm, residual.alarms.to_string(), residual.phase.to_owned()]
        })
        .collect();
    lines.extend(aligned(&RESIDUAL_HEADS, &rows));
    if let (Some(diagnosis), Some(stretch)) = (&episode.diagnosis, episode.diagnosed_s) {
        lines.extend(of_stretch(stretch, diagnosis, style));
    }
    lines.extend(episode.not_diagnosed.iter().map(|why| format!("  not diagnosed: {why}")));
    lines
}

/// The diagnosis of a stretch, s.
fn of_stretch([from, to]: [f64; 2], diagnosis: &Diagnosis, style: Style) -> Vec<String> {
    let tone = headline::tone(diagnosis.verdict);
    let mut lines = vec![format!("  diagnosed from {} to {}", seconds(from), seconds(to))];
    lines.push(format!("  {}", style.painted(&headline(diagnosis), tone)));
    lines.extend(caveats(diagnosis).into_iter().map(|caveat| format!("  {caveat}")));
    let left_out = left_out(&diagnosis.left_out, TOLD);
    lines.extend(left_out.into_iter().map(|words| format!("  left out of the fit: {words}")));
    let present: Vec<bool> = diagnosis.faults.iter().map(|fault| fault.present).collect();
    let rows: Vec<Vec<String>> =
        fault_rows(diagnosis).into_iter().zip(present).filter_map(|(row, present)| present.then_some(row)).collect();
    if !rows.is_empty() {
        lines.extend(aligned(&FAULT_HEADS, &rows));
    }
    lines
}
