//! The store and the history through the library: what is kept comes back, trends and forecasts hold.

use std::fs;
use std::path::Path;

use borescope::Rig;
use borescope::internals::complaint::Kind;
use borescope::internals::diagnosis::{Diagnosis, DiagnosisOptions, FaultReport, FitReport, SCHEMA, Verdict};
use borescope::internals::estimation::Identifiable;
use borescope::internals::history::forecast::{State, passing};
use borescope::internals::history::regression::{Line, Point, bend};
use borescope::internals::history::{Axis, By, History, history};
use borescope::internals::store::{Dated, Moment, NewRun, RigIdentity, Store, export_csv};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use rand_distr::{Distribution, StandardNormal};

const RIG: &str = "fixtures/two_tanks/rig.toml";

/// The two tanks with a limit to the clogging of the outlet.
fn rig() -> Rig {
    let text = fs::read_to_string(RIG).unwrap();
    let text = text.replace("bounds = [\"2 mm\", \"9 mm\"] }", "bounds = [\"2 mm\", \"9 mm\"], limit = \"6.5 mm\" }");
    Rig::parse(RIG, text).unwrap_or_else(|complaint| panic!("{complaint}"))
}

fn diagnosis(record: &str, value: f64, half: f64) -> Diagnosis {
    Diagnosis {
        schema: SCHEMA,
        rig: RIG.to_owned(),
        record: record.to_owned(),
        verdict: Verdict::Faulty,
        common_cause: None,
        missing_effect: None,
        off_data_sheet: None,
        undeclared: Vec::new(),
        dynamics: Vec::new(),
        rival_effects: Vec::new(),
        times_noise: 1.0,
        times_noise_weighed: 1.0,
        detected_at_s: Some(0.5),
        onset_s: None,
        ambiguity: Vec::new(),
        alike: Vec::new(),
        faults: vec![FaultReport {
            id: "upper_outlet.diameter".to_owned(),
            meaning: "diameter".to_owned(),
            value,
            unit: "mm".to_owned(),
            healthy: 8.0,
            healthy_sigma: 0.0,
            bounds: [2.0, 9.0],
            limit: Some(6.5),
            ci95: [Some(value - half), Some(value + half)],
            change95: None,
            present: true,
            probability: 0.99,
            identifiable: Identifiable::Bounded,
            remark: None,
            biased: false,
        }],
        hypotheses: Vec::new(),
        residuals: Vec::new(),
        fit: FitReport {
            chi2_reduced: 1.0,
            iterations: 1,
            solves: 2,
            stopped_because: "it did".to_owned(),
            parameters: Vec::new(),
            correlation: Vec::new(),
            profiles: Vec::new(),
        },
        channels: Vec::new(),
        uncertain: Vec::new(),
        taken_as_exact: Vec::new(),
        as_new: Vec::new(),
        below_vacuum: None,
        at_odds: Vec::new(),
        unfilled: 0,
        left_out: Vec::new(),
    }
}

struct Bench {
    store: Store,
    identity: RigIdentity,
    rig: Rig,
    folder: tempfile::TempDir,
}

impl Bench {
    fn new() -> Self {
        let folder = tempfile::tempdir().unwrap();
        let store = Store::open(folder.path().join("runs.store")).unwrap();
        let rig = rig();
        Self { store, identity: RigIdentity::new(&rig), rig, folder }
    }

    fn add(&self, digest: &str, at: &str, diagnosis: &Diagnosis) -> i64 {
        let run = NewRun {
            rig: &self.identity,
            record_digest: digest,
            measured_at: at.parse().unwrap(),
            dated: Dated::Given,
            diagnosed_at: Moment::now(),
            options: &DiagnosisOptions::default(),
            diagnosis,
        };
        self.store.add(&run).unwrap()
    }

    fn history(&self, by: By) -> History {
        history(&self.rig, "runs.store", &self.store.runs_of(&self.identity.key).unwrap(), by)
    }
}

#[test]
fn what_is_kept_comes_back() {
    let bench = Bench::new();
    assert_eq!(bench.add("b", "2026-05-02", &diagnosis("b.csv", 7.5, 0.1)), 1);
    assert_eq!(bench.add("a", "2026-05-01T14:00:00+02:00", &diagnosis("a.csv", 7.5, 0.25)), 2);
    let mut open = diagnosis("c.csv", f64::NAN, 0.1);
    open.faults[0].ci95 = [None, None];
    bench.add("c", "2026-05-03", &open);
    let runs = bench.store.runs().unwrap();
    assert_eq!(runs.iter().map(|run| run.id).collect::<Vec<_>>(), [2, 1, 3], "by time");
    assert_eq!(runs[0].measured_at.to_string(), "2026-05-01T12:00:00.000Z");
    assert_eq!((runs[0].verdict.as_str(), runs[0].record.as_str()), ("faulty", "a.csv"));
    assert_eq!(runs[0].model_version, env!("CARGO_PKG_VERSION"));
    assert!(runs[0].options.contains("\"hours_between_false_alarms\":1000.0"), "{}", runs[0].options);
    let fault = &runs[0].faults[0];
    assert_eq!((fault.value, fault.low, fault.high), (Some(7.5), Some(7.25), Some(7.75)));
    assert_eq!(runs[2].faults[0].value, None);
    assert!(bench.store.is_sound().unwrap());
    assert_eq!(bench.store.rigs().unwrap(), ["two tanks"]);
    assert_eq!(bench.store.time_given("a").unwrap().unwrap().to_string(), "2026-05-01T12:00:00.000Z");
    assert_eq!(bench.store.time_given("z").unwrap(), None);
    let mut table = Vec::new();
    export_csv(&runs, &mut table).unwrap();
    let table = String::from_utf8(table).unwrap();
    assert_eq!(table.lines().count(), 4);
    assert!(
        table
            .lines()
            .nth(1)
            .unwrap()
            .ends_with("upper_outlet.diameter,mm,7.5,7.25,7.75,8,true,0.99,false,bounded,6.5,2,9"),
        "{table}"
    );
}

#[test]
fn what_is_no_store_is_refused_and_left_alone() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("file");
    let foreign = folder.path().join("foreign.sqlite");
    rusqlite::Connection::open(&foreign).unwrap().execute_batch("CREATE TABLE t (a)").unwrap();
    fs::write(&path, "time [s],p [bar]\n0,1\n".repeat(100)).unwrap();
    for file in [&path, &foreign] {
        let before = fs::read(file).unwrap();
        for opened in [Store::open(file), Store::open_existing(file)] {
            let complaint = opened.unwrap_err();
            assert_eq!(complaint.kind, Kind::Syntax);
            assert_eq!(complaint.what, "this is no store of diagnoses");
        }
        assert_eq!(fs::read(file).unwrap(), before);
    }
    let newer = folder.path().join("newer.store");
    drop(Store::open(&newer).unwrap());
    rusqlite::Connection::open(&newer).unwrap().pragma_update(None, "user_version", 7).unwrap();
    let complaint = Store::open(&newer).unwrap_err();
    assert_eq!(complaint.what, "the store has version 7 of its tables");
    assert_eq!(Store::open_existing(folder.path().join("none")).unwrap_err().kind, Kind::Missing);
    assert_eq!(Store::open(folder.path().join("no/folder")).unwrap_err().kind, Kind::Missing);
    assert_eq!(Store::open(folder.path()).unwrap_err().kind, Kind::Unwritable);
    assert!(!Path::new("none").exists());
    // What a shop made with `touch` is an empty store to write into, and none to read from.
    let empty = folder.path().join("empty.store");
    fs::write(&empty, "").unwrap();
    assert_eq!(Store::open_existing(&empty).unwrap_err().what, "this is no store of diagnoses");
    assert!(Store::open(&empty).unwrap().runs().unwrap().is_empty());
}

#[test]
fn moments_are_read_with_their_zone_or_refused() {
    for (text, shown) in [
        ("2026-05-01T12:00:00Z", "2026-05-01T12:00:00.000Z"),
        ("2026-05-01T14:00:00.25+02:00", "2026-05-01T12:00:00.250Z"),
        ("2026-05-01", "2026-05-01T00:00:00.000Z"),
    ] {
        assert_eq!(text.parse::<Moment>().unwrap().to_string(), shown);
    }
    for (text, what) in [
        ("2026-05-01T12:00:00", "`2026-05-01T12:00:00` does not say its time zone"),
        ("2026-13-01", "`2026-13-01` is no moment"),
        ("yesterday", "`yesterday` is no moment"),
        ("", "`` is no moment"),
    ] {
        assert_eq!(text.parse::<Moment>().unwrap_err().what, what);
    }
}

/// Thirty records, a day apart, of an outlet that clogs by 0.03 mm a day, each value as uncertain as it says.
#[test]
fn thirty_runs_show_the_trend_and_when_it_passes_the_limit() {
    let bench = Bench::new();
    let mut random = ChaCha8Rng::seed_from_u64(30);
    for day in 0..30 {
        let noise: f64 = StandardNormal.sample(&mut random);
        let value = 8.0 - 0.03 * f64::from(day) + 0.02 * noise;
        let at = format!("2026-05-{:02}T12:00:00Z", day + 1);
        bench.add(&day.to_string(), &at, &diagnosis(&format!("{day}.csv"), value, 1.96 * 0.02));
    }
    // A second diagnosis of the last record replaces the first.
    bench.add("29", "2026-05-30T12:00:00Z", &diagnosis("29.csv", 8.0 - 0.03 * 29.0, 1.96 * 0.02));
    let found = bench.history(By::Time);
    assert_eq!(found.runs.len(), 30);
    assert_eq!(found.warnings, ["older diagnoses of records that were diagnosed again, left out: 1"]);
    let fault = &found.faults[0];
    let trend = fault.trend.as_ref().unwrap();
    println!("{trend:?}\n{:?}", fault.forecast);
    assert!(trend.ci95[0] < -0.03 && -0.03 < trend.ci95[1], "{trend:?}");
    assert!(trend.ci95[1] - trend.ci95[0] < 0.004, "{trend:?}");
    let forecast = fault.forecast.as_ref().unwrap();
    assert_eq!(forecast.state, State::WillPass);
    // 1.5 mm at 0.03 mm a day: fifty days behind the first of May.
    let ends: Vec<&str> = forecast.ci95.iter().map(|end| moment(end.as_ref())).collect();
    assert!(ends[0] < "2026-06-20T12" && "2026-06-20T12" < ends[1], "{ends:?}");
    assert!(ends[0] > "2026-06-16" && ends[1] < "2026-06-25", "{ends:?}");
    assert_eq!(bench.history(By::Run).faults[0].trend.as_ref().unwrap().per, "run");
    assert!(bench.folder.path().join("runs.store").exists());
}

fn moment(axis: Option<&Axis>) -> &str {
    match axis {
        Some(Axis::Time(moment)) => moment,
        other => panic!("{other:?}"),
    }
}

#[test]
fn what_cannot_be_fitted_is_said() {
    let bench = Bench::new();
    let fault = |bench: &Bench| bench.history(By::Time).faults[0].clone();
    bench.add("a", "2026-05-01", &diagnosis("a.csv", 7.9, 0.1));
    bench.add("b", "2026-05-02", &diagnosis("b.csv", 7.8, 0.1));
    let mut open = diagnosis("c.csv", 7.7, 0.1);
    open.faults[0].ci95[0] = None;
    bench.add("c", "2026-05-03", &open);
    let told = fault(&bench);
    assert_eq!((told.values.len(), told.trend.is_none(), told.forecast.is_none()), (3, true, true));
    let remark = "1 of 3 runs do not bound it and are left out; a trend takes three runs, and there are 2";
    assert_eq!(told.remark.as_deref(), Some(remark));
    // A value that rests at the end of the search is bounded by it.
    let mut resting = diagnosis("d.csv", 9.0, 0.1);
    resting.faults[0].ci95[1] = None;
    bench.add("d", "2026-05-04", &resting);
    assert_eq!(fault(&bench).trend.unwrap().runs, 3);
    let other = Bench::new();
    for (digest, value) in [("a", 7.9), ("b", 7.8), ("c", 7.7)] {
        other.add(digest, "2026-05-01", &diagnosis(digest, value, 0.1));
    }
    assert!(fault(&other).remark.unwrap().starts_with("all runs have one time"));
    assert!(other.history(By::Run).faults[0].trend.is_some());
}

/// The line of the textbook: y = 1 + 2 x without noise, and its weights.
#[test]
fn a_line_is_weighted_and_its_scatter_found() {
    let point = |x: f64, y: f64, sigma: f64| Point { x, y, sigma };
    let exact = Line::through(&[point(0.0, 1.0, 0.1), point(1.0, 3.0, 0.1), point(3.0, 7.0, 0.2)]).unwrap();
    assert!((exact.slope - 2.0).abs() < 1e-12 && (exact.value(0.0) - 1.0).abs() < 1e-12);
    assert_eq!(exact.scatter, 0.0);
    assert!((exact.t - 12.706_204_736).abs() < 1e-6, "Student's t of one degree of freedom: {}", exact.t);
    // A point that knows nothing changes nothing.
    let loose =
        Line::through(&[point(0.0, 1.0, 0.1), point(1.0, 3.0, 0.1), point(3.0, 7.0, 0.2), point(2.0, 90.0, 1e6)]);
    assert!((loose.unwrap().slope - 2.0).abs() < 1e-6);
    assert_eq!(Line::through(&[point(0.0, 1.0, 0.1), point(1.0, 3.0, 0.1)]), None);
    assert_eq!(Line::through(&[point(1.0, 1.0, 0.1), point(1.0, 3.0, 0.1), point(1.0, 2.0, 0.1)]), None);
    let bent: Vec<Point> = (0..12).map(|k| point(f64::from(k), f64::from(k * k), 1.0)).collect();
    assert!(bend(&bent, &Line::through(&bent).unwrap()).unwrap() > 3.0);
}

/// Of 2,000 made courses, the 95 % intervals of slope, present value and passing hold the truth in 95 %.
#[test]
fn intervals_hold_the_truth_as_often_as_they_say() {
    let mut random = ChaCha8Rng::seed_from_u64(7);
    let mut normal = || -> f64 { StandardNormal.sample(&mut random) };
    let rounds = 2000;
    for between_runs in [0.0, 0.3] {
        let mut held = [0; 3];
        for _ in 0..rounds {
            let points: Vec<Point> = (0..12)
                .map(|k| {
                    let (x, sigma) = (f64::from(k), if k % 3 == 0 { 0.3 } else { 0.1 });
                    Point { x, y: 1.0 + 0.1 * x + sigma * normal() + between_runs * normal(), sigma }
                })
                .collect();
            let line = Line::through(&points).unwrap();
            let [low, high] = line.slope_interval();
            held[0] += usize::from((low..=high).contains(&0.1));
            held[1] += usize::from((line.value(11.0) - 2.1).abs() <= line.half_width(11.0));
            // 4 is passed at x = 30; an open end holds everything.
            let between = passing(&line, 4.0, true, 11.0).between;
            held[2] += usize::from(between[0].is_some_and(|x| x <= 30.0) && between[1].is_none_or(|x| x >= 30.0));
        }
        println!("scatter {between_runs}: held {held:?} of {rounds}");
        // Four standard deviations of the count are 39; scatter that is estimated may make intervals too long, and a little
        // too short.
        for held in held {
            assert!((1861..=1985).contains(&held), "{held} of {rounds} with scatter {between_runs}");
        }
    }
}

#[test]
fn forecasts_know_their_state() {
    let line = |slope: f64, sigma: f64| {
        let points: Vec<Point> = (0..10).map(|k| Point { x: f64::from(k), y: slope * f64::from(k), sigma }).collect();
        Line::through(&points).unwrap()
    };
    let state = |slope: f64, sigma: f64, limit: f64, upwards: bool| passing(&line(slope, sigma), limit, upwards, 9.0);
    let ahead = state(1.0, 0.1, 20.0, true);
    assert_eq!(ahead.state, State::WillPass);
    assert!((ahead.at.unwrap() - 20.0).abs() < 1e-9);
    assert!(ahead.between[0].unwrap() < 20.0 && ahead.between[1].unwrap() > 20.0);
    assert_eq!(state(1.0, 0.1, 5.0, true).state, State::Passed);
    assert!((state(1.0, 0.1, 5.0, true).at.unwrap() - 5.0).abs() < 1e-9);
    assert_eq!(state(1.0, 0.1, 9.05, true).state, State::AtLimit);
    let unsure = state(0.01, 1.0, 20.0, true);
    assert_eq!((unsure.state, unsure.between[1]), (State::MayPass, None));
    assert!(unsure.between[0].unwrap() > 9.0);
    assert_eq!(state(-1.0, 0.1, 20.0, true).state, State::Receding);
    // The same downwards.
    let down = state(-1.0, 0.1, -20.0, false);
    assert_eq!(down.state, State::WillPass);
    assert!(down.between[0].unwrap() < 20.0 && down.between[1].unwrap() > 20.0);
    assert_eq!(state(1.0, 0.1, -20.0, false).state, State::Receding);
}
