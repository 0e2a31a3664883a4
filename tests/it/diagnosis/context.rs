//! Progress, cancellation and threads belong to a computation, not to the program.

use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

use borescope::Context;
use borescope::Model;
use borescope::Record;
use borescope::Rig;
use borescope::internals::complaint::{Complaint, Kind};
use borescope::internals::diagnosis::{Diagnosed, DiagnosisOptions, diagnose};
use borescope::internals::learn::suggest::suggest;

use crate::support::cycle::Run;

const TANKS: &str = "fixtures/two_tanks/rig.toml";
const TELESCOPIC: &str = "fixtures/telescopic/rig.toml";
/// How soon a cancelled computation has to be over, on cores that other tests use too. The command, which promises 0.2 s, does
/// not rely on it: see `cli::interrupt`.
const SOON: Duration = Duration::from_millis(600);

/// Stages with the number of threads that they ran on.
type Heard = Arc<Mutex<Vec<(String, usize)>>>;

/// A record of the cycle of a rig, the blade of its upper outlet half closed.
fn record(rig: &Rig) -> Record {
    Run::of(&Model::new(rig.clone())).with(&[("upper_outlet.diameter", 6.5e-3)]).record("tanks.csv")
}

/// A context with so many threads, and what is heard of it.
fn listening(threads: usize) -> (Context, Heard) {
    let heard = Heard::default();
    let listen = Arc::clone(&heard);
    let context = Context::new().with_threads(threads).unwrap().with_progress(move |progress| {
        listen.lock().unwrap().push((progress.stage.to_owned(), rayon::current_num_threads()));
    });
    (context, heard)
}

fn diagnosis(rig: &Rig, context: &Context, record: &Record) -> Result<Diagnosed, Complaint> {
    diagnose(&Model::new(rig.clone().with_context(context)), record, &DiagnosisOptions::default())
}

#[test]
fn two_diagnoses_at_once_have_their_own_progress_and_threads() {
    let rig = Rig::read(TANKS).unwrap();
    let record = record(&rig);
    let ((one, heard_of_one), (two, heard_of_two)) = (listening(1), listening(2));
    let [first, second] = std::thread::scope(|scope| {
        let (rig, record) = (&rig, &record);
        let running =
            [&one, &two].map(|context| scope.spawn(move || diagnosis(rig, context, record).unwrap().diagnosis));
        running.map(|thread| thread.join().unwrap())
    });
    assert_eq!(serde_json::to_string(&first).unwrap(), serde_json::to_string(&second).unwrap());
    let (of_one, of_two) = (heard_of_one.lock().unwrap(), heard_of_two.lock().unwrap());
    assert!(of_one.iter().any(|(stage, _)| stage == "intervals of the faults"), "{of_one:?}");
    assert!(of_one.iter().all(|(_, threads)| *threads == 1), "{of_one:?}");
    assert!(of_two.iter().all(|(_, threads)| *threads == 2), "{of_two:?}");
    let stages = |heard: &[(String, usize)]| heard.iter().map(|(stage, _)| stage.clone()).collect::<Vec<_>>();
    assert_eq!(stages(&of_one), stages(&of_two));
}

#[test]
fn a_context_cancelled_before_leaves_another_alone() {
    let rig = Rig::read(TANKS).unwrap();
    let record = record(&rig);
    let cancelled = Context::new();
    cancelled.clone().cancel();
    assert_eq!(diagnosis(&rig, &cancelled, &record).unwrap_err().kind, Kind::Interrupted);
    assert!(diagnosis(&rig, &Context::new(), &record).is_ok());
}

/// Runs `work` with a context that is cancelled after `after`; how long it took from there to its end.
fn cancelled_after(after: Duration, work: impl FnOnce(&Context) -> Option<Complaint>) -> Duration {
    let context = Context::new().with_threads(1).unwrap();
    let (cancel, begin) = (context.clone(), Instant::now());
    let waiting = std::thread::spawn(move || {
        std::thread::sleep(after);
        cancel.cancel();
        Instant::now()
    });
    let complaint = work(&context);
    let end = Instant::now();
    let cancelled = waiting.join().unwrap();
    assert!(complaint.is_some_and(|complaint| complaint.kind == Kind::Interrupted), "{:?}", begin.elapsed());
    end.saturating_duration_since(cancelled)
}

#[test]
fn a_cancelled_diagnosis_ends_soon_wherever_it_is() {
    let rig = Rig::read(TELESCOPIC).unwrap();
    let record = rig.record("fixtures/telescopic/leak_020.csv").unwrap();
    let begin = Instant::now();
    diagnosis(&rig, &Context::new().with_threads(1).unwrap(), &record).unwrap();
    let whole = begin.elapsed();
    for share in [0.02, 0.25, 0.5, 0.7] {
        let took = cancelled_after(whole.mul_f64(share), |context| diagnosis(&rig, context, &record).err());
        assert!(took < SOON, "cancelled after {share} of {whole:?}, it went on for {took:?}");
    }
}

#[test]
fn a_first_look_tells_the_verdict_before_the_intervals() {
    let told = Arc::new(Mutex::new(Vec::new()));
    let hear = |told: &Arc<Mutex<Vec<String>>>| {
        let told = told.clone();
        move |shows: &str| told.lock().unwrap().push(shows.to_owned())
    };
    let context = Context::new().with_first_look(hear(&told));
    let rig = Rig::read(TELESCOPIC).unwrap();
    for name in ["leak_020", "healthy_1"] {
        diagnosis(&rig, &context, &rig.record(format!("fixtures/telescopic/{name}.csv")).unwrap()).unwrap();
    }
    assert_eq!(*told.lock().unwrap(), ["faulty, cylinder.clearance 0.2 mm", "healthy"]);
}

#[test]
fn a_cancelled_suggestion_ends_soon_wherever_it_is() {
    let rig = Rig::read("fixtures/learning/stroke_5335.toml").unwrap();
    let record = rig.record("fixtures/learning/line_fit.csv").unwrap();
    for after in [300, 1800, 3500] {
        let took = cancelled_after(Duration::from_millis(after), |context| {
            suggest(&rig.clone().with_context(context), &record, None).err()
        });
        assert!(took < SOON, "cancelled after {after} ms, it went on for {took:?}");
    }
}
