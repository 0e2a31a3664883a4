//! Every sensor: measured, what models say of it, and the misfit below.

use crate::complaint::Complaint;
use crate::diagnosis::{is_there, weighed};
use crate::learn::phase::{Stretch, stretches};
use crate::model::InputSignals;
use crate::record::Record;
use crate::report::html::Section;
use crate::report::plot::{Axis, Band, Chart, Live, Rule, Series};
use crate::rig::{Rig, Sensor};

/// Points of all noisy curves of a page together: what keeps it small enough to be sent.
const POINTS: usize = 150_000;
/// Stretches over which a misfit is averaged.
const STRETCHES: usize = 250;
/// Where a misfit stays in 95 of 100 samples if the model is right, times the noise.
const USUAL: f64 = 2.0;

/// Colour and dash of the user's model, and of the model with what was found, on every page.
pub(super) const YOURS: (usize, usize) = (2, 1);
pub(super) const FOUND: (usize, usize) = (1, 0);

/// What a model says of a record.
pub(super) struct Said<'a> {
    pub name: &'a str,
    /// `[sensor][row]`, SI; may be empty where the model cannot be solved.
    pub outputs: &'a [Vec<f64>],
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
        let measured = weighed::measured(rig, record)?;
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

    /// Measured minus model over the noise of the sensor, row by row; NaN where nothing was measured. Empty where the model could
    /// not be solved.
    pub fn misfit(&self, index: usize, outputs: &[Vec<f64>]) -> Vec<f64> {
        let sensor = &self.rig.sensors[index];
        let (Some(channel), Some(output)) = (self.record.channel(&sensor.column), outputs.get(index)) else {
            return Vec::new();
        };
        let sigma = sensor.stated_noise;
        channel.values.iter().zip(output).map(|(measured, model)| (measured - model) / sigma).collect()
    }

    /// The same of all sensors.
    pub fn misfits(&self, outputs: &[Vec<f64>]) -> Vec<Vec<f64>> {
        (0..self.rig.sensors.len()).map(|index| self.misfit(index, outputs)).collect()
    }

    /// Adds the charts of every sensor.
    pub fn charts(&self, section: &mut Section, models: &[Said<'_>]) {
        for index in 0..self.rig.sensors.len() {
            self.chart(section, index, models);
        }
    }

    /// Adds the charts of one sensor: measured with what the models say of it, and the misfits of these below.
    pub fn chart(&self, section: &mut Section, index: usize, models: &[Said<'_>]) {
        let (bands, record, sensor) = (self.bands(), self.record, &self.rig.sensors[index]);
        let Some(channel) = record.channel(&sensor.column) else { return };
        let unit = self.rig.sensor_unit(sensor);
        let points = |values: &[f64]| -> Vec<(f64, f64)> {
            let pairs = record.time.iter().zip(values).filter(|(_, si)| !si.is_nan());
            pairs.map(|(time, si)| (*time, unit.from_si(*si))).collect()
        };
        let mut series = vec![Series::measured(points(&channel.values))];
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
        let mut chart = self.misfit_chart(models, index, sensor);
        chart.bands = bands;
        section.chart(&chart, &self.live(format!("misfit of {} over time", sensor.name)));
    }

    /// Measured minus model of one sensor, times its noise: every sample, and of one model the mean of each stretch too.
    fn misfit_chart(&self, models: &[Said<'_>], index: usize, sensor: &Sensor) -> Chart {
        let times = &self.record.time;
        let solved = || models.iter().filter(|model| model.outputs.len() > index);
        let alone = solved().count() == 1;
        let mut series = Vec::new();
        for model in solved() {
            let misfit = self.misfit(index, model.outputs);
            let there = times.iter().zip(&misfit).filter(|(_, size)| size.is_finite());
            let every: Vec<(f64, f64)> = there.map(|(time, size)| (*time, *size)).collect();
            let (colour, dash) = model.style;
            if alone {
                let rows = misfit.len().div_ceil(STRETCHES).max(1);
                let means = times.chunks(rows).zip(misfit.chunks(rows)).filter_map(mean).collect();
                series.push(Series::pale("samples", every).styled(colour, 0));
                series.push(Series::line("mean", means).styled(colour, dash));
            } else {
                series.push(Series::line(model.name, every).styled(colour, dash));
            }
        }
        let title = format!("misfit of {}", sensor.name);
        let what = Axis::new("measured minus model, times the noise", "");
        let mut chart = Chart::new(title, self.time(), what, series).high(110.0);
        for y in [-USUAL, USUAL] {
            chart.rules.push(Rule::Horizontal { y, label: String::new() });
        }
        chart
    }

    /// Adds the whitened misfits of a model, sensor by sensor, which the verdict rests on.
    pub fn whitened(&self, section: &mut Section, misfit: &[&[f64]]) {
        section.paragraph(
            "Misfit after noise, switching and tolerance are taken into account, in standard deviations: independent, with variance 1, if the \
             model is right. Verdict and reduced chi-square rest on it. Dotted lines at 2.",
        );
        for (sensor, misfit) in self.rig.sensors.iter().zip(misfit) {
            let pairs = self.record.time.iter().zip(*misfit).filter(|(_, r)| is_there(**r));
            let every = pairs.map(|(time, r)| (*time, -r)).collect();
            let series = vec![Series::line("whitened misfit", every).styled(0, 0)];
            let title = format!("whitened misfit of {}", sensor.name);
            let mut chart = Chart::new(title, self.time(), Axis::new("", "standard deviations"), series).high(110.0);
            for y in [-USUAL, USUAL] {
                chart.rules.push(Rule::Horizontal { y, label: String::new() });
            }
            chart.bands = self.bands();
            section.chart(&chart, &self.live(format!("whitened misfit of {} over time", sensor.name)));
        }
    }
}

/// Middle and mean of a piece; `None` where nothing was measured.
fn mean((times, misfit): (&[f64], &[f64])) -> Option<(f64, f64)> {
    let there = misfit.iter().filter(|size| size.is_finite());
    let count = there.clone().count();
    (count > 0).then(|| (times[times.len() / 2], there.sum::<f64>() / count as f64))
}
