//! A stretch of steady motion: means of the sensors and residuals, and sizes of faults that follow from one component.

use borescope::Record;
use borescope::Rig;
use borescope::internals::model::InputSignals;
use borescope::internals::residual::{Detection, Gate, Variant, estimator::Healthy, generators};

pub const LPM: f64 = 1e-3 / 60.0;

/// Means, SI, pressures gauge.
#[derive(Debug, Clone)]
pub struct Steady {
    pub p_pump: f64,
    pub p_p: f64,
    pub p_a: f64,
    pub p_b: f64,
    pub q_p: f64,
    pub q_a: f64,
    pub q_b: f64,
    pub speed: f64,
    residuals: Vec<(String, Variant, f64)>,
}

/// Times of the first outstroke at which the piston passes two positions (m), s.
pub fn between(record: &Record, from: f64, to: f64) -> (f64, f64) {
    let x = &record.channel("x").unwrap().values;
    let passes = |position: f64| record.time[x.iter().position(|x| *x > position).unwrap()];
    (passes(from), passes(to))
}

impl Steady {
    /// From `from` to `to`, s.
    pub fn of(rig: &Rig, record: &Record, from: f64, to: f64) -> Self {
        let rows = record.time.partition_point(|t| *t < from)..record.time.partition_point(|t| *t <= to);
        let mean = |name: &str| {
            let values = &record.channel(name).unwrap().values[rows.clone()];
            values.iter().sum::<f64>() / values.len() as f64
        };
        // Least-squares slope of the position.
        let (t, x) = (&record.time[rows.clone()], &record.channel("x").unwrap().values[rows.clone()]);
        let (middle, centre) = (t.iter().sum::<f64>() / t.len() as f64, mean("x"));
        let slope = t.iter().zip(x).map(|(t, x)| (t - middle) * (x - centre)).sum::<f64>()
            / t.iter().map(|t| (t - middle).powi(2)).sum::<f64>();
        let drive = InputSignals::from_record(rig, record).unwrap();
        let residual = |generator: borescope::internals::residual::Generator| {
            let series = generator.blocks(rig, record, &drive, Detection::default().window).unwrap();
            let within =
                |&at: &usize| series.start[at] >= from && series.time[at] <= to && series.gate[at] == Gate::Open;
            let values: Vec<f64> = (0..series.time.len()).filter(within).map(|at| series.value[at]).collect();
            (generator.id, generator.variant, values.iter().sum::<f64>() / values.len() as f64)
        };
        Self {
            p_pump: mean("p_pump"),
            p_p: mean("p_P"),
            p_a: mean("p_A"),
            p_b: mean("p_B"),
            q_p: mean("q_P"),
            q_a: mean("q_A"),
            q_b: mean("q_B"),
            speed: slope,
            residuals: generators(rig).into_iter().map(residual).collect(),
        }
    }

    /// Mean of a residual over the windows that count, SI.
    pub fn residual(&self, id: &str, variant: Variant) -> f64 {
        let found = self.residuals.iter().find(|(own, own_variant, _)| own == id && *own_variant == variant);
        let value = found.unwrap_or_else(|| panic!("no residual {id}")).2;
        assert!(value.is_finite(), "{id} has no window that counts");
        value
    }

    /// Diametral clearance in m at which the concentric gap passes this flow (m³/s).
    pub fn clearance(&self, rig: &Rig, leakage: f64) -> f64 {
        let of = |id: &str| rig.parameters[rig.parameter(id).unwrap()].value;
        let wide = std::f64::consts::PI * of("cylinder.bore");
        let friction = 12.0 * of("fluid.viscosity") * of("cylinder.land_length");
        let passes = |clearance: f64| {
            let gap = 0.5 * clearance;
            wide * gap.powi(3) * (self.p_a - self.p_b) / friction - 0.5 * wide * gap * self.speed
        };
        // The wall drags more than the pressure pushes through the narrowest gaps, so the search begins above them.
        bisect(0.05e-3, 0.5e-3, |clearance| passes(clearance) - leakage)
    }

    /// Diameter in m at which the flow control valve passes what is measured at the measured pressures.
    pub fn diameter(&self, rig: &Rig) -> f64 {
        let index = rig.parameter("flow_control.orifice_diameter").unwrap();
        bisect(0.5e-3, 6e-3, |diameter| {
            let mut parameters = rig.nominal();
            parameters[index] = diameter;
            Healthy::of(rig, &parameters).unwrap().blockage(self.p_pump, self.p_p, self.q_p)
        })
    }
}

/// Zero of a rising function.
fn bisect(mut low: f64, mut high: f64, function: impl Fn(f64) -> f64) -> f64 {
    for _ in 0..60 {
        let middle = f64::midpoint(low, high);
        if function(middle) < 0.0 { low = middle } else { high = middle }
    }
    high
}
