//! Long records: the cycle of a rig over and over, with noise that never repeats, and a fault from some cycle on.

use std::fs::File;
use std::io::{BufWriter, Write};
use std::path::Path;

use borescope::Quantity;
use borescope::internals::model::{Before, InputSignals, Model, Onset, Outputs, input_columns, recording};
use borescope::internals::rig::{Cycle, Rig};

/// Writes a record of so many healthy cycles and as many with a fault, which begins with the first of them, and gives its rows.
pub fn write(path: &Path, rig: &str, [healthy, faulty]: [usize; 2], (fault, value): (&str, &str)) -> usize {
    let rig = Rig::read(rig).unwrap_or_else(|complaint| panic!("{complaint}"));
    let cycle = rig.cycle.clone().unwrap();
    let rows = (cycle.duration() / cycle.interval).round() as usize;
    // The second of two cycles begins as the first one ends, and so would all that follow.
    let phases = vec![cycle.phases.clone(); 4].concat();
    let index = rig.parameter(fault).unwrap();
    let mut parameters = rig.nominal();
    let before = vec![(index, Before::Value(parameters[index]))];
    parameters[index] = Quantity::parse(value).unwrap().value;
    let onset = Onset { time: 2.0 * cycle.duration(), before };
    let drive = InputSignals::from_cycle(&rig, &Cycle { phases, ..cycle.clone() }).with_onset(onset);
    let times: Vec<f64> = (1..=4 * rows).map(|row| row as f64 * cycle.interval).collect();
    let outputs = Model::new(rig.clone()).solve(&parameters, &drive, &times).unwrap();
    let inputs = input_columns(&rig, &drive, &times);
    let mut file = BufWriter::new(File::create(path).unwrap());
    for number in 0..healthy + faulty {
        let kind = if number < healthy { number.min(1) } else { 2 + (number - healthy).min(1) };
        let part = kind * rows..(kind + 1) * rows;
        let cut = |columns: &[Vec<f64>]| columns.iter().map(|column| column[part.clone()].to_vec()).collect::<Vec<_>>();
        let read = Outputs { values: cut(&outputs.values), effort: outputs.effort };
        let times = (1..=rows).map(|row| (number * rows + row) as f64 * cycle.interval).collect();
        let record = recording(&rig, "", times, cut(&inputs), &read, Some(number as u64));
        if number == 0 {
            let names = record.channels.iter().map(|channel| format!(",{} [{}]", channel.name, channel.unit));
            writeln!(file, "time [s]{}", names.collect::<String>()).unwrap();
        }
        for (row, time) in record.time.iter().enumerate() {
            write!(file, "{time:.4}").unwrap();
            for channel in &record.channels {
                let (value, decimals) = (channel.unit.from_si(channel.values[row]), channel.decimals.unwrap_or(1));
                write!(file, ",{value:.decimals$}").unwrap();
            }
            writeln!(file).unwrap();
        }
    }
    file.flush().unwrap();
    rows * (healthy + faulty)
}
