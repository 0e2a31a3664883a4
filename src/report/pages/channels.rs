//! Every sensor: measured, what models say of it, and the misfit below.

use crate::complaint::Complaint;
use crate::diagnosis::{estimate, is_there};
use crate::learn::phase::{Stretch, stretches};
use crate::model::InputSignals;
use crate::record::Record;
use crate::report::html::Section;
use crate::report::plot::{Axis, Band, Chart, Live, Rule, Series};
use crate::rig::Rig;

/// Points of all noisy curves of a page together: what keeps it small enough to be sent.
const POINTS: usize = 150_000;
/// Stretches over which a misfit is averaged.
const STRETCHES: usize = 250;
/// Where a misfit stays in 95 of 100 samples if the model is right, standard deviations.
const USUAL: f64 = 2.0;

/// What a model says of a record.
pub(super) struct Said<'a> {
    pub name: &'a str,
    /// `[sensor][row]`, SI; may be empty where the model cannot be solved.
    pub outputs: &'a [Vec<f64>],
    /// Model minus measured, weighted by noise and tolerance, `[sensor][row]`.
    pub misfit: Vec<&'a [f64]>,
    /// Colour and dash.
    pub style: (usize, usize),
}

/// The weighted misfits of a run, sensor by sensor.
pub(super) fn by_sensor<'a>(misfit: &'a [f64], record: &Record) -> Vec<&'a [f64]> {
    misfit.chunks(record.time.len().max(1)).collect()
}

/// A record with its phases.
pub(super) struct Shown<'a> {
    pub rig: &'a Rig,
    pub record: &'a Record,
    pub stretches: Vec<Stretch>,
    /// Charts of one group share zoom and cursor.
    pub group: &'a str,
    /// Records on the page.
    pub records: usize,
    pub detected_at_s: Option<f64>,
}

impl<'a> Shown<'a> {
    /// A record of a rig.
    ///
    /// # Errors
    /// Columns that are missing.
    pub fn new(rig: &'a Rig, record: &'a Record, group: &'a str, records: usize) -> Result<Self, Complaint> {
        let measured = estimate::measured(rig, record)?;
        let drive = InputSignals::from_record(rig, record)?;
        let stretches = stretches(rig, record, &drive, &measured);
        Ok(Self { rig, record, stretches, group, records, detected_at_s: None })
    }

    /// First and last time of a stretch, s.
    pub fn ends(&self, stretch: &Stretch) -> (f64, f64) {
        let times = &self.record.time;
        let last = times.len().saturating_sub(1);
        (times[stretch.rows.start.min(last)], times[stretch.rows.end.min(last)])
    }

    pub fn time(&self) -> Axis {
        let ends = self.record.time.first().zip(self.record.time.last());
        let axis = Axis::new("time", "s");
        ends.map_or(axis.clone(), |(&first, &last)| axis.over(first, last))
    }

    pub fn live(&self, what: String) -> Live {
        let noisy = self.rig.sensors.len().max(1) * 2 * self.records;
        Live::new(self.group, what).points((POINTS / noisy).clamp(400, 5_000))
    }

    /// Every other phase.
    pub fn bands(&self) -> Vec<Band> {
        let band = |stretch: &Stretch| {
            let (from, to) = self.ends(stretch);
            Band { from, to, label: stretch.name.clone() }
        };
        self.stretches.iter().skip(1).step_by(2).map(band).collect()
    }

    /// Adds the charts of every sensor.
    pub fn charts(&self, section: &mut Section, models: &[Said<'_>]) {
        let (bands, record) = (self.bands(), self.record);
        for (index, sensor) in self.rig.sensors.iter().enumerate() {
            let Some(channel) = record.channel(&sensor.column) else { continue };
            let unit = self.rig.sensor_unit(sensor);
            let points = |values: &[f64]| -> Vec<(f64, f64)> {
                let pairs = record.time.iter().zip(values).filter(|(_, si)| !si.is_nan());
                pairs.map(|(time, si)| (*time, unit.from_si(*si))).collect()
            };
            let mut series = vec![Series::line("measured", points(&channel.values)).styled(5, 0)];
            for model in models {
                let Some(output) = model.outputs.get(index) else { continue };
                series.push(Series::line(model.name, points(output)).styled(model.style.0, model.style.1));
            }
            let value = Axis::new(&sensor.name, &unit.symbol);
            let mut chart = Chart::new(&sensor.name, self.time(), value, series).high(190.0);
            chart.bands.clone_from(&bands);
            if let Some(x) = self.detected_at_s {
                chart.rules.push(Rule::Vertical { x, label: "detected".to_owned() });
            }
            section.chart(&chart, &self.live(format!("{} over time: measured and model", sensor.name)));
            let mut chart = misfit(&record.time, models, index, &sensor.name, self.time());
            chart.bands.clone_from(&bands);
            section.chart(&chart, &self.live(format!("misfit of {} over time", sensor.name)));
        }
    }
}

/// Measured minus model of one sensor, in standard deviations: of one model every sample and the mean of each stretch, of
/// several the means.
fn misfit(times: &[f64], models: &[Said<'_>], sensor: usize, name: &str, time: Axis) -> Chart {
    let told = || models.iter().filter_map(|model| Some((model, *model.misfit.get(sensor)?)));
    let count = told().count();
    let mut series = Vec::new();
    for (model, misfit) in told() {
        let rows = misfit.len().div_ceil(STRETCHES).max(1);
        let mean = |(times, misfit): (&[f64], &[f64])| {
            let there = misfit.iter().filter(|r| is_there(**r));
            let count = there.clone().count();
            (count > 0).then(|| (times[times.len() / 2], -there.sum::<f64>() / count as f64))
        };
        let means: Vec<(f64, f64)> = times.chunks(rows).zip(misfit.chunks(rows)).filter_map(mean).collect();
        if count == 1 {
            let pairs = times.iter().zip(misfit).filter(|(_, r)| is_there(**r));
            let every = pairs.map(|(time, r)| (*time, -r)).collect();
            series.push(Series::line("samples", every).styled(5, 0));
            series.push(Series::line("mean", means).styled(1, 0));
        } else {
            series.push(Series::line(model.name, means).styled(model.style.0, model.style.1));
        }
    }
    let title = format!("misfit of {name}");
    let mut chart = Chart::new(title, time, Axis::new("", "standard deviations"), series).high(110.0);
    for y in [-USUAL, USUAL] {
        chart.rules.push(Rule::Horizontal { y, label: String::new() });
    }
    chart
}
