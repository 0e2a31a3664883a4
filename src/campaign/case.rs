//! One rig, one case: drawn, simulated, diagnosed.

use std::time::Instant;

use super::Campaign;
use super::disturb::{Disturbed, disturb, of_record};
use super::draw::{Injected, Run};
use super::measured::measured;
use super::random::{Purpose, Stream};
use super::row::Row;
use crate::calibration;
use crate::complaint::Complaint;
use crate::diagnosis::expected::expected;
use crate::diagnosis::{self, Diagnosed, diagnose};
use crate::model::{Model, Outputs};
use crate::number::{difference_in_unit, in_unit, rounded};
use crate::physics::ATMOSPHERE;
use crate::physics::card::{PortKind, Role};
use crate::physics::fluid::{self, Fluid};
use crate::physics::ports::{PortFlows, PortVariables};
use crate::record::Record;
use crate::rig::{Quantity, Rig, Target};

/// Draws after which a rig or case is given up.
const DRAWS: usize = 100;
/// Healthy records from which each rig is calibrated.
const RECORDS: usize = 2;
/// The pressure difference of a case is the one that this share of its rows stays below.
const PRESSED: f64 = 0.9;

/// A disturbed rig with what its healthy records have taught.
pub struct Prepared {
    pub disturbed: Disturbed,
    /// Of the disturbed rig.
    simulated: Model,
    /// Of the data sheet, calibrated; the message of what went wrong otherwise.
    pub model: Result<Model, String>,
    /// Whether the calibrated model explains the healthy records; `None` without one.
    pub adequate: Option<bool>,
    /// The healthy records.
    pub records: Vec<Record>,
    /// How often it was drawn anew because a simulation came to no end.
    pub redrawn: usize,
}

impl Prepared {
    /// Writes a table of all parameters: of the data sheet `rig`, of the disturbed rig, and as calibrated, each in the
    /// unit of the rig file. What the model leaves out has no data sheet.
    ///
    /// # Errors
    /// Those of the writer.
    pub fn write_truth(&self, rig: &Rig, out: &mut dyn std::io::Write) -> std::io::Result<()> {
        let mut table = csv::Writer::from_writer(out);
        table.write_record(["parameter", "unit", "data_sheet", "true", "calibrated", "calibrated_sigma"])?;
        for real in &self.disturbed.rig.parameters {
            let shown = |value: f64| in_unit(value, &real.unit).to_string();
            let of = |rig: &Rig| rig.parameter(&real.id).map(|index| rig.parameters[index].clone());
            let (sheet, calibrated) = (of(rig), self.model.as_ref().ok().and_then(|model| of(&model.rig)));
            table.write_record([
                real.id.clone(),
                real.unit.symbol.clone(),
                sheet.map_or(String::new(), |own| shown(own.value)),
                shown(real.value),
                calibrated.as_ref().map_or(String::new(), |own| shown(own.value)),
                calibrated.map_or(String::new(), |own| difference_in_unit(own.sigma, &real.unit).to_string()),
            ])?;
        }
        table.flush()
    }
}

/// One case with all that a reader may want to see.
pub struct Replay {
    pub row: Row,
    /// `None` where nothing could be simulated.
    #[cfg_attr(not(feature = "cli"), expect(dead_code, reason = "the command writes it"))]
    pub record: Option<Record>,
    /// `None` where the case failed.
    #[cfg_attr(not(feature = "cli"), expect(dead_code, reason = "the command shows it"))]
    pub diagnosed: Option<Diagnosed>,
}

impl Campaign {
    /// The rig with this number, drawn and calibrated by the first who asks; a message where it could not be simulated.
    #[doc(hidden)]
    pub fn prepared(&self, rig: usize) -> Result<&Prepared, &str> {
        let message = "there is no such rig";
        let slot = self.rigs.get(rig).ok_or(message)?;
        slot.get_or_init(|| self.prepare(rig).map_err(|complaint| complaint.to_string()))
            .as_ref()
            .map_err(String::as_str)
    }

    fn prepare(&self, rig: usize) -> Result<Prepared, Complaint> {
        let mut last = String::new();
        for redrawn in 0..DRAWS {
            let mut random = Stream::of(self.options.seed, Purpose::Rig(rig, redrawn));
            let disturbed = disturb(&self.rig, self.options.disturbance, &mut random)?;
            let simulated = Model::new(disturbed.rig.clone());
            let healthy = disturbed.rig.nominal();
            let records = (0..RECORDS).map(|number| {
                let run = Run::draw(&self.rig, &self.cycle, &mut random);
                let seed = random.seed();
                let mut parameters = healthy.clone();
                of_record(&disturbed.rig, &mut parameters, self.options.disturbance, &mut random);
                let outputs = simulated.solve(&parameters, &run.drive_of(&disturbed.rig), &run.times)?;
                let name = format!("rig_{rig}_healthy_{}.csv", number + 1);
                Ok(measured(&disturbed, name, &run.drive, &run.times, run.interval, &outputs, seed))
            });
            match records.collect::<Result<Vec<Record>, crate::model::SimulationError>>() {
                Ok(records) => {
                    let options = calibration::CalibrationOptions::default();
                    let calibrated = calibration::calibrate_rig(&self.rig, &records, &options);
                    let adequate = calibrated.as_ref().ok().map(|(_, report)| report.adequate);
                    let model = calibrated.map(|(rig, _)| Model::new(rig)).map_err(|complaint| complaint.what);
                    return Ok(Prepared { disturbed, simulated, model, adequate, records, redrawn });
                }
                Err(error) => last = error.to_string(),
            }
        }
        Err(Complaint::new(
            crate::complaint::Kind::Computation,
            format!("rig {rig} could not be simulated in {DRAWS} draws: {last}"),
        )
        .in_file(&self.rig.path)
        .help("try the cycle with `borescope simulate`, or a smaller `--disturbance`"))
    }

    /// Runs one case with `count` faults.
    pub(super) fn case(&self, case: usize, count: usize) -> Replay {
        let rig = self.rig_of(case);
        let prepared = match self.prepared(rig) {
            Ok(prepared) => prepared,
            Err(message) => return self.unprepared(case, rig, count, message),
        };
        let mut last = String::new();
        for redrawn in 0..DRAWS {
            let mut random = Stream::of(self.options.seed, Purpose::Case(case, redrawn));
            let run = Run::draw(&self.rig, &self.cycle, &mut random);
            let injected = Injected::draw(&prepared.disturbed, &run, count, &mut random);
            let drive = injected.drive(&prepared.disturbed.rig, &prepared.disturbed.healthy, &run);
            let mut parameters = injected.parameters(&prepared.disturbed);
            of_record(&prepared.disturbed.rig, &mut parameters, self.options.disturbance, &mut random);
            let outputs = match prepared.simulated.solve(&parameters, &drive, &run.times) {
                Ok(outputs) => outputs,
                Err(error) => {
                    last = error.to_string();
                    continue;
                }
            };
            let mut row = Row::new(case, rig, count, &prepared.disturbed, &injected);
            (row.redrawn, row.rig_redrawn, row.motion_s) = (redrawn, prepared.redrawn, run.first_motion(&self.rig));
            row.rig_adequate = prepared.adequate;
            for fault in 0..row.faults.len() {
                if row.faults[fault].injected {
                    row.faults[fault].flow_l_min = leakage(&prepared.disturbed, &parameters, fault, &outputs);
                }
            }
            let name = format!("case_{case}.csv");
            let disturbed = &prepared.disturbed;
            let record = measured(disturbed, name, &run.drive, &run.times, run.interval, &outputs, random.seed());
            let diagnosed = match &prepared.model {
                Ok(model) => {
                    let context = self.rig.context();
                    context.on_threads(|| tell_beforehand(&mut row, model, disturbed, &injected, &run, &record));
                    let begin = Instant::now();
                    let diagnosed = diagnose(model, &record, &diagnosis::DiagnosisOptions::default());
                    row.seconds = begin.elapsed().as_secs_f64();
                    diagnosed.map_err(|complaint| complaint.what)
                }
                Err(message) => Err(message.clone()),
            };
            match &diagnosed {
                Ok(diagnosed) => row.take(&diagnosed.diagnosis),
                Err(message) => row.failure = Some(message.clone()),
            }
            let diagnosed = diagnosed.ok();
            return Replay { row, record: Some(record), diagnosed };
        }
        let nothing = Injected { faults: Vec::new(), onset: None };
        let mut row = Row::new(case, rig, count, &prepared.disturbed, &nothing);
        (row.redrawn, row.rig_redrawn) = (DRAWS, prepared.redrawn);
        row.failure = Some(format!("the case could not be simulated in {DRAWS} draws: {last}"));
        Replay { row, record: None, diagnosed: None }
    }

    /// The case of a rig that could not be prepared.
    fn unprepared(&self, case: usize, rig: usize, count: usize, message: &str) -> Replay {
        let healthy = self.rig.faults.iter().map(|fault| fault.healthy).collect();
        let disturbed = Disturbed { rig: self.rig.clone(), healthy };
        let mut row = Row::new(case, rig, count, &disturbed, &Injected { faults: Vec::new(), onset: None });
        row.failure = Some(message.to_owned());
        Replay { row, record: None, diagnosed: None }
    }
}

/// Enters whether the faults are identifiable at their size, by the model that diagnoses and without noise.
fn tell_beforehand(
    row: &mut Row,
    model: &Model,
    disturbed: &Disturbed,
    injected: &Injected,
    run: &Run,
    record: &Record,
) {
    let rig = &model.rig;
    // As far from the healthy value that the model knows as the truth is from its own.
    let moved = |&(index, value): &(usize, f64)| {
        let fault = &rig.faults[index];
        let bounds = rig.parameters[fault.parameter].bounds;
        (index, (fault.healthy + value - disturbed.healthy[index]).clamp(bounds.0, bounds.1))
    };
    let faults: Vec<(usize, f64)> = injected.faults.iter().map(moved).collect();
    let healthy: Vec<f64> = rig.faults.iter().map(|fault| fault.healthy).collect();
    let drive = Injected { faults: faults.clone(), onset: injected.onset }.drive(rig, &healthy, run);
    if faults.is_empty() {
        return;
    }
    // Where the model cannot be solved, nothing is known.
    let Ok(expected) = expected(model, record, &drive, &faults) else { return };
    row.identifiable = Some(expected.identifiable.iter().all(|known| *known));
    if let Some(rival) = expected.rival {
        row.rival = rival.faults.iter().filter_map(|&fault| Some(row.faults.get(fault)?.id.clone())).collect();
        row.mistaken = Some(rounded(rival.mistaken, 6));
    }
}

/// Leakage in L/min that a clearance makes, the part at rest, at the difference of the measured pressures at its ends that
/// [`PRESSED`] of the rows stay below; `None` for other faults, and where these pressures are not measured.
fn leakage(disturbed: &Disturbed, parameters: &[f64], fault: usize, outputs: &Outputs) -> Option<f64> {
    let rig = &disturbed.rig;
    let parameter = rig.faults[fault].parameter;
    let component = rig.components.iter().find(|component| component.owns(parameter))?;
    let own = parameter - component.first_parameter;
    if component.card.parameters.get(own)?.role != Role::Clearance {
        return None;
    }
    let [a, b] = [pressure(rig, outputs, component.ports[0])?, pressure(rig, outputs, component.ports[1])?];
    let mut differences: Vec<f64> = a.iter().zip(b).map(|(a, b)| (a - b).abs()).collect();
    differences.sort_by(f64::total_cmp);
    let difference = *differences.get((PRESSED * differences.len() as f64) as usize)?;
    let flow = |clearance: f64| {
        let fluid = Fluid::new(&parameters[..fluid::CARD.parameters.len()]);
        let mut seen = PortVariables::default();
        let hydraulic = component.card.ports.iter().filter(|port| port.kind == PortKind::Hydraulic).count();
        seen.z[..hydraulic].fill(ATMOSPHERE);
        seen.z[0] += difference;
        let mut answers = PortFlows::default();
        component
            .law(|index| if index == parameter { clearance } else { parameters[index] }, &fluid)?
            .evaluate(&seen, &mut answers);
        Some(answers.through[0])
    };
    const L_PER_MIN: f64 = 60e3;
    let leak = (flow(parameters[parameter])? - flow(disturbed.healthy[fault])?) * L_PER_MIN;
    Some(rounded(leak, 9))
}

/// What the pressure sensor at a node reads without noise, Pa.
fn pressure<'a>(rig: &Rig, outputs: &'a Outputs, node: usize) -> Option<&'a [f64]> {
    let sits =
        |sensor: &crate::rig::Sensor| sensor.target == Target::Node(node) && sensor.quantity == Quantity::Pressure;
    outputs.values.get(rig.sensors.iter().position(sits)?).map(Vec::as_slice)
}
