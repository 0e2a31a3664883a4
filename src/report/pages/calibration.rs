//! The page of a calibration: what healthy records have moved, and how well the calibrated model follows them.

use super::channels::{FOUND, Said, Shown, YOURS};
use super::learn::{curves, most_missed, named, prior_scale};
use crate::calibration::{
    Calibrated, CalibratedDynamics, CalibratedParameter, CalibratedSensor, CalibrationReport, ChannelFit, RecordFit,
};
use crate::complaint::Complaint;
use crate::model::{InputSignals, Model};
use crate::number::{rounded, text};
use crate::record::Record;
use crate::report::digits::plus_minus;
use crate::report::html::{Cell, Column, Mark, Page, Scale, Section, Table};
use crate::report::provenance::Provenance;
use crate::report::style::Tone;
use crate::rig::Rig;

/// The page: what was learnt, parameters on the scale of what was known before, the records beside the model before and after, sensors.
///
/// # Errors
/// Columns that are missing.
pub fn html(rig: &Rig, calibrated: &Calibrated, measured: &[Record]) -> Result<String, Complaint> {
    let report = &calibrated.report;
    let records = report.records.len();
    let lead = format!("{} healthy record{}", records, if records == 1 { "" } else { "s" });
    let mut page = Page::new(format!("Calibration of {}", named(rig)), lead);
    page.provenance(Provenance::of(rig, measured));
    page.section(learnt(report));
    let mut parameters = Section::new("Parameters");
    parameters.table(parameter_table(&report.parameters));
    let silent: Vec<&str> = report.parameters.iter().filter(|one| !one.informed).map(|one| one.id.as_str()).collect();
    if !silent.is_empty() {
        parameters.paragraph(format!("The records hardly determine {}.", silent.join(", ")));
    }
    if !report.dynamics.is_empty() {
        parameters.table(dynamics_table(&report.dynamics));
    }
    page.section(parameters);
    for (number, record) in measured.iter().enumerate() {
        page.section(followed(rig, &calibrated.rig, record, (number, measured.len()))?);
    }
    let mut sensors = Section::new("Sensors");
    sensors.paragraph(
        "Noise: one standard deviation of a sample, from the fast part of the misfit. Tolerance: how far model and sensor differ \
         throughout a phase, beyond noise and what is uncertain.",
    );
    sensors.table(sensor_table(&report.sensors));
    page.section(sensors);
    let mut judged = Section::new("Records");
    judged.paragraph(
        "Mean square of the weighted misfit; 1 is right within noise and tolerance. What is not explained is marked.",
    );
    judged.table(record_table(&report.records));
    page.section(judged);
    Ok(page.html())
}

/// A record beside the model with the values of the data sheet and with those of the calibration; all records but the first are folded.
fn followed(
    sheet: &Rig,
    calibrated: &Rig,
    record: &Record,
    (number, of): (usize, usize),
) -> Result<Section, Complaint> {
    // A model that cannot be solved has no curve.
    let solved = |rig: &Rig| -> Result<Vec<Vec<f64>>, Complaint> {
        let drive = InputSignals::from_record(rig, record)?;
        let solved = Model::new(rig.clone()).solve(&rig.healthy(), &drive, &record.time);
        Ok(solved.map_or_else(|_| Vec::new(), |outputs| outputs.values))
    };
    let (before, after) = (solved(sheet)?, solved(calibrated)?);
    let models = [
        Said { name: "data sheet", outputs: &before, style: YOURS },
        Said { name: "calibrated", outputs: &after, style: FOUND },
    ];
    let group = format!("record {number}");
    let shown = Shown::new(sheet, record, &group, of)?;
    let heading = format!("Measured against the model: {}", record.path.display());
    if number == 0 {
        return Ok(curves(&shown, most_missed(&shown, &before), &models, &heading));
    }
    let mut section = Section::folded(heading);
    shown.charts(&mut section, &models);
    Ok(section)
}

fn learnt(report: &CalibrationReport) -> Section {
    let informed = report.parameters.iter().filter(|one| one.informed).count();
    let rows: usize = report.records.iter().map(|record| record.rows).sum();
    let mut section = Section::new("Calibration result");
    section.notice(
        if report.warnings.is_empty() { Tone::Good } else { Tone::Caution },
        format!(
            "{informed} of {} parameters identified from {rows} rows; reduced chi-square {}.",
            report.parameters.len(),
            text(rounded(report.chi2_reduced, 3))
        ),
    );
    if !report.warnings.is_empty() {
        section.subheading("Caveats: signs that the records are not healthy");
        section.list(report.warnings.clone());
    }
    section
}

fn parameter_table(parameters: &[CalibratedParameter]) -> Table {
    let row = |one: &CalibratedParameter| -> Vec<Cell> {
        vec![
            one.id.clone().into(),
            plus_minus(one.before, one.sigma_before).into(),
            plus_minus(one.after, one.sigma_after).into(),
            one.unit.clone().into(),
            Cell::Scale(scale(one)),
        ]
    };
    Table::new(
        "Before and after, +- one standard deviation; before the records a value is that of the data sheet, a margin nothing. On each \
         scale: wide bar two standard deviations before, tick the value before; point and narrow bar the calibrated value with two of its own",
        vec![
            Column::text("parameter"),
            Column::number("before", ""),
            Column::number("calibrated", ""),
            Column::text("unit"),
            Column::text("after against before"),
        ],
        parameters.iter().map(row).collect(),
    )
}

fn dynamics_table(dynamics: &[CalibratedDynamics]) -> Table {
    let number = |value: f64| -> Cell { text(rounded(value, 4)).into() };
    let row = |one: &CalibratedDynamics| -> Vec<Cell> {
        vec![
            one.id.clone().into(),
            number(one.before),
            number(one.after),
            one.unit.clone().into(),
            one.meaning.clone().into(),
        ]
    };
    let columns = vec![
        Column::text("dynamics"),
        Column::number("data sheet", ""),
        Column::number("calibrated", ""),
        Column::text("unit"),
        Column::text("meaning"),
    ];
    Table::new(
        "Found by search among whole switchings, without a standard deviation",
        columns,
        dynamics.iter().map(row).collect(),
    )
}

/// What was known of a value before, and upon it what is known with the records.
fn scale(one: &CalibratedParameter) -> Scale {
    let mut scale = prior_scale(one.after, (one.before, one.sigma_before), "value before");
    let behind = scale.marks.len().saturating_sub(1);
    scale.marks.insert(behind, Mark::Interval(one.after - 2.0 * one.sigma_after, one.after + 2.0 * one.sigma_after));
    scale
}

fn sensor_table(sensors: &[CalibratedSensor]) -> Table {
    let number = |value: f64| -> Cell { text(rounded(value, 3)).into() };
    let row = |one: &CalibratedSensor| -> Vec<Cell> {
        vec![
            one.name.clone().into(),
            number(one.noise_before),
            number(one.noise),
            number(one.tolerance_before),
            number(one.tolerance),
            one.unit.clone().into(),
            one.noise_correlation.map_or("-".into(), number),
        ]
    };
    let columns = vec![
        Column::text("sensor"),
        Column::number("noise before", ""),
        Column::number("noise", ""),
        Column::number("tolerance before", ""),
        Column::number("tolerance", ""),
        Column::text("unit"),
        Column::number("correlation of neighbouring samples", ""),
    ];
    Table::new("Noise and tolerance", columns, sensors.iter().map(row).collect())
}

/// A row for each record, a column for each sensor.
fn record_table(records: &[RecordFit]) -> Table {
    let channel = |one: &ChannelFit| -> Cell {
        let shown = text(rounded(one.chi2_reduced, 3));
        if one.adequate { shown.into() } else { Cell::Shade(format!("{shown}, not explained"), 0.5) }
    };
    let row = |one: &RecordFit| -> Vec<Cell> {
        let whole: [Cell; 3] =
            [one.record.clone().into(), one.rows.to_string().into(), text(rounded(one.chi2_reduced, 3)).into()];
        whole.into_iter().chain(one.channels.iter().map(channel)).collect()
    };
    let names = records.first().map_or(&[][..], |record| &record.channels).iter();
    let columns = vec![Column::text("record"), Column::number("rows", ""), Column::number("all", "")];
    let columns = columns.into_iter().chain(names.map(|one| Column::number(&one.name, ""))).collect();
    Table::new("How the calibrated model follows each sensor", columns, records.iter().map(row).collect())
}
