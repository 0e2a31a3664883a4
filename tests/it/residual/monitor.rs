//! Residuals over a record that comes piece by piece are those of the record as a whole, wherever it is cut.

use crate::support::long_record;

use borescope::Rig;
use borescope::internals::model::InputSignals;
use borescope::internals::record::{Channel, Record};
use borescope::internals::residual::{Block, Detection, Evaluated, Fired, Monitor};

const RIG: &str = "fixtures/telescopic/rig.toml";

fn rig() -> Rig {
    Rig::read(RIG).unwrap_or_else(|complaint| panic!("{complaint}"))
}

/// Four healthy cycles and four with a leak.
fn record(rig: &Rig) -> Record {
    let file = tempfile::Builder::new().suffix(".csv").tempfile().unwrap();
    long_record::write(file.path(), RIG, [4, 4], ("cylinder.clearance", "0.1 mm"));
    rig.record(file.path()).unwrap()
}

/// These rows of a record.
fn cut(record: &Record, rows: std::ops::Range<usize>) -> Record {
    let channel = |channel: &Channel| {
        Channel::new(channel.name.clone(), channel.unit.clone(), channel.values[rows.clone()].to_vec())
    };
    Record::new("piece", record.time[rows.clone()].to_vec(), record.channels.iter().map(channel).collect())
}

/// What a monitor says of a record in pieces of these numbers of rows, over and over.
fn watched(rig: &Rig, record: &Record, pieces: &[usize]) -> (Vec<Block>, Vec<Fired>) {
    let mut monitor = Monitor::new(rig, Detection::default());
    let (mut blocks, mut fired) = (Vec::new(), Vec::new());
    let (mut from, mut sizes) = (0, pieces.iter().cycle());
    while from < record.time.len() {
        let to = (from + sizes.next().unwrap()).min(record.time.len());
        let (more, alarms) = monitor.take(cut(record, from..to), to == record.time.len()).unwrap();
        blocks.extend(more);
        fired.extend(alarms);
        from = to;
    }
    (blocks, fired)
}

const CUTS: &[&[usize]] = &[&[3000], &[1875], &[250, 251, 7, 1], &[37], &[1]];

#[test]
fn alarms_do_not_depend_on_where_the_record_is_cut() {
    let rig = rig();
    let record = record(&rig);
    let (blocks, fired) = watched(&rig, &record, &[record.time.len()]);
    assert!(fired.len() > 20, "{} alarms", fired.len());
    for pieces in CUTS {
        assert_eq!(watched(&rig, &record, pieces), (blocks.clone(), fired.clone()), "pieces of {pieces:?} rows");
    }
}

#[test]
fn the_first_alarms_are_those_of_the_whole_record() {
    let rig = rig();
    let record = record(&rig);
    let drive = InputSignals::from_record(&rig, &record).unwrap();
    let detection = Detection::default();
    let reports = Evaluated::of(&rig, &record, &drive, detection.window).unwrap().judge(&detection);
    let (blocks, fired) = watched(&rig, &record, &[700]);
    assert_eq!(
        blocks.iter().map(|block| block.values).sum::<usize>(),
        reports.iter().map(|report| report.windows).sum::<usize>()
    );
    assert!(reports.iter().any(|report| report.fired) && reports.iter().any(|report| !report.fired));
    for report in reports {
        let first = fired.iter().find(|fired| fired.id == report.id);
        assert_eq!(first.map(|fired| fired.at_s), report.alarm_at_s, "{}", report.id);
        assert_eq!(first.map(|fired| fired.onset_s), report.onset_s, "{}", report.id);
        assert_eq!(first.map(|fired| fired.direction), report.direction, "{}", report.id);
        assert_eq!(first.map(|fired| fired.phase), report.phase, "{}", report.id);
    }
}

#[test]
fn nor_where_rows_and_samples_are_missing() {
    let rig = rig();
    let mut record = record(&rig);
    for (name, rows) in [("q_A", 2000..4200), ("F_load", 6000..6400), ("valve_command", 7000..7003), ("x", 9000..9005)]
    {
        let channel = record.channels.iter_mut().find(|channel| channel.name == name).unwrap();
        channel.values[rows].fill(f64::NAN);
    }
    let mut holed = cut(&record, 0..record.time.len());
    let kept = |row: &usize| !(3000..3900).contains(row) && !row.is_multiple_of(97);
    let pick = |values: &[f64]| (0..values.len()).filter(kept).map(|row| values[row]).collect::<Vec<f64>>();
    holed.time = pick(&record.time);
    holed.channels.iter_mut().for_each(|channel| channel.values = pick(&channel.values));
    let (blocks, fired) = watched(&rig, &holed, &[holed.time.len()]);
    assert!(fired.len() > 20 && blocks.iter().any(|block| block.values == 0));
    for pieces in CUTS {
        assert_eq!(watched(&rig, &holed, pieces), (blocks.clone(), fired.clone()), "pieces of {pieces:?} rows");
    }
}
