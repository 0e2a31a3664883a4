//! Every form that a logger may give a record, and the way back to a file.

use std::fs;

use borescope::Unit;
use borescope::internals::complaint::Kind;
use borescope::internals::record::{Channel, Record, Sampling};

const EXCERPT: &str = "\
time [s],valve_command [-],p_pump [bar],p_P [bar],p_A [bar],p_B [bar],q_P [L/min],q_A [L/min],q_B [L/min],x [mm],F_load [N],T_oil [degC]
0.0040,0.00,101.60,101.90,12.15,0.35,-0.050,0.060,0.020,-0.005,1481,39.9
0.0080,0.00,102.25,102.15,12.40,0.25,0.020,-0.030,0.010,0.015,1488,39.9
0.0120,1.00,101.75,101.60,11.80,0.10,-0.005,-0.005,0.025,-0.035,1486,40.0
";

fn read(text: &str) -> Record {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("record.csv");
    fs::write(&path, text).unwrap();
    Record::read(&path).unwrap_or_else(|complaint| panic!("{complaint}\nfor:\n{text}"))
}

fn written(record: &Record) -> String {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("record.csv");
    record.write(&path).unwrap_or_else(|complaint| panic!("{complaint}"));
    fs::read_to_string(&path).unwrap()
}

#[test]
fn values_are_in_si_and_written_back_as_they_were() {
    let record = read(EXCERPT);
    assert_eq!(record.time, [0.004, 0.008, 0.012]);
    assert_eq!(record.channels.len(), 11);
    let values = |name: &str| record.channel(name).unwrap().values.clone();
    assert_eq!(values("p_pump")[0], 101.60 * 1e5);
    assert_eq!(values("F_load"), [1481.0, 1488.0, 1486.0]);
    assert!((values("T_oil")[2] - 313.15).abs() < 1e-12);
    assert!((values("q_A")[0] - 1e-6).abs() < 1e-20);
    assert!(record.channel("p_C").is_none());
    assert_eq!(written(&record), EXCERPT);
}

#[test]
fn every_form_reads_as_the_same_record() {
    let plain = read("time [s],p [bar]\n0.0,1.5\n0.5,-2.5\n");
    for text in [
        "time [s],p [bar]\r\n0.0,1.5\r\n0.5,-2.5\r\n",
        "time [s],p [bar]\r0.0,1.5\r0.5,-2.5",
        "\u{feff}time [s],p [bar]\n0.0,1.5\n0.5,-2.5",
        "time [s];p [bar]\n0.0;1.5\n0.5;-2.5\n",
        "time [s];p [bar]\n0,0;1,5\n0,5;-2,5\n",
        "time [s]\tp [bar]\n0.0\t1.5\n0.5\t-2.5\n",
        "time [s]\tp [bar]\n0,0\t1,5\n0,5\t-2,5\n",
        "time [s],p [bar]\n\"0,0\",\"1,5\"\n\"0,5\",\"-2,5\"\n",
        "\"time [s]\",\"p [bar]\"\n\"0.0\",\"1.5\"\n0.5,-2.5\n",
        "\"time\n[s]\",\"p\r\n[bar]\"\n0.0,1.5\n0.5,-2.5\n",
        " time  [s] , p [ bar ] \n 0.0 , 1.5 \n 0.5 , -2.5 \n",
        "time [ms],p [bar]\n0.0,1.5\n500.0,-2.5\n",
        "# logger 7, 250 Hz; \"rig\n\ntime [s],p [bar]\n# start\n0.0,1.5\n\n  \n0.5,-2.5\n# end\n",
        "time[s],p[bar]\n0.0,1.5\n+0.5,-2.5\n",
    ] {
        let record = read(text);
        assert_eq!(record.time, plain.time, "for:\n{text}");
        assert_eq!(record.channels, plain.channels, "for:\n{text}");
    }
}

#[test]
fn a_name_may_hold_brackets_and_separators() {
    let record = read("time [s],\"p (rod, B) [bar]\",a[1] [mm]\n0,1,2\n");
    let names: Vec<&str> = record.channels.iter().map(|channel| channel.name.as_str()).collect();
    assert_eq!(names, ["p (rod, B)", "a[1]"]);
    let again = read(&written(&record));
    assert_eq!(again.channels, record.channels);
}

#[test]
fn any_values_come_back_to_the_last_digit_without_given_decimals() {
    let units = ["bar", "L/min", "mm", "degC", "-", "%", "um", "rev/min", "N.s/m", "cSt"];
    let mut state = 7_u64;
    let mut next = || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
        (state >> 11) as f64 / (1_u64 << 53) as f64
    };
    let rows = 500;
    let time: Vec<f64> = (0..rows).map(|row| row as f64 / 300.0).collect();
    let channels = units
        .iter()
        .map(|symbol| {
            let unit = Unit::parse(symbol).unwrap();
            let values = (0..rows).map(|_| unit.to_si((next() - 0.5) * 10f64.powf(12.0 * next() - 6.0))).collect();
            Channel::new(format!("in {symbol}"), unit, values)
        })
        .collect();
    let record = Record::new("simulated", time, channels);
    let again = read(&written(&record));
    assert_eq!(again.time, record.time);
    for (channel, before) in again.channels.iter().zip(&record.channels) {
        assert_eq!(channel.name, before.name);
        for (value, expected) in channel.values.iter().zip(&before.values) {
            // An offset or an odd factor may cost the last digit, in the unit's own scale.
            let scale = expected.abs().max(before.unit.offset);
            assert!((value - expected).abs() <= f64::EPSILON * scale, "{}", channel.name);
        }
    }
}

#[test]
fn decimals_are_those_given_and_short_texts_stay_short() {
    let bar = Unit::parse("bar").unwrap();
    let mm = Unit::parse("mm").unwrap();
    let record = Record::new(
        "simulated",
        vec![0.0, 0.1, 0.2],
        vec![
            Channel::new("p", bar, vec![101.649e5, -0.3e5, 0.0]).with_decimals(1),
            Channel::new("x", mm, vec![0.3e-3, 1e-9, 170e-3]),
        ],
    );
    assert_eq!(written(&record), "time [s],p [bar],x [mm]\n0,101.6,0.3\n0.1,-0.3,1e-6\n0.2,0.0,170\n");
    let mut coarse = record;
    coarse.time_decimals = Some(0);
    assert!(written(&coarse).contains("\n0.1,"), "rounded times would repeat");
}

#[test]
fn a_record_that_could_not_be_read_back_is_not_written() {
    let mm = || Unit::parse("mm").unwrap();
    let channel = |name: &str, values: &[f64]| Channel::new(name, mm(), values.to_vec());
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("out.csv");
    for (time, channels, kind, what) in [
        (vec![], vec![channel("x", &[])], Kind::Empty, "a record without rows or channels is not written"),
        (vec![0.0, 0.0], vec![channel("x", &[1.0, 2.0])], Kind::Order, "the time does not rise to 0 s"),
        (vec![0.0, 1.0], vec![channel("x", &[1.0])], Kind::Shape, "the column `x` has 1 values for 2 times"),
        (vec![0.0, 1.0], vec![channel("x", &[1.0, f64::NAN])], Kind::Number, "the column `x` is NaN at 1 s"),
        (vec![0.0], vec![channel("x", &[1.0]), channel("x", &[1.0])], Kind::Duplicate, "the column `x` appears twice"),
        (vec![0.0], vec![channel(" ", &[1.0])], Kind::MissingEntry, "channel 1 has no name"),
    ] {
        let complaint = Record::new("simulated", time, channels).write(&path).unwrap_err();
        assert_eq!((complaint.kind, complaint.what.as_str()), (kind, what));
        assert!(!path.exists());
    }
}

#[test]
fn sampling_is_regular_but_for_rounding() {
    let of = |time: &[f64], decimals| Sampling::of(time, decimals).unwrap();
    assert_eq!(Sampling::of(&[1.0], None), None);
    assert!((of(&[0.0, 0.004, 0.008], Some(4)).interval - 0.004).abs() < 1e-15);
    assert!(of(&[0.0, 0.004, 0.008], None).regular);
    // A third of a hundredth of a second, written with four decimals.
    assert!(of(&[0.0, 0.0033, 0.0067, 0.01], Some(4)).regular);
    assert!(!of(&[0.0, 0.0033, 0.0067, 0.01], None).regular);
    // A missing row shows, however coarse the last decimal is.
    let gap = of(&[0.0, 0.001, 0.002, 0.004, 0.005], Some(3));
    assert!(!gap.regular);
    assert!((gap.longest - 0.002).abs() < 1e-15 && (gap.shortest - 0.001).abs() < 1e-15);
}
