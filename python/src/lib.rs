//! The command within Python: one call that runs a command line, lets other threads of Python work meanwhile, and ends at Ctrl-C.

use std::ffi::OsString;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::PathBuf;
use std::sync::mpsc::{self, RecvTimeoutError};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

use borescope::{Complaint, Context};
use pyo3::prelude::*;

/// How often signals and progress are looked at: Ctrl-C is to end a call within a fifth of a second.
const LOOK: Duration = Duration::from_millis(50);

/// What went wrong: what, file, line, remedy, and the whole text.
type Wrong = (String, Option<String>, Option<usize>, Option<String>, String);

fn wrong(complaint: &Complaint) -> Wrong {
    let place = complaint.places.last();
    (
        complaint.what.clone(),
        place.map(|place| place.file.display().to_string()),
        place.and_then(|place| place.line),
        complaint.help.clone(),
        complaint.with_lines(),
    )
}

/// The latest progress: stage, how many pieces of it are done, and of how many.
type Latest = Option<(String, usize, Option<usize>)>;

/// Runs a command line without the name of the program.
///
/// Gives what the command writes to standard output, what went wrong, and its notes. `progress` is called with the stage, how many pieces of it
/// are done, and of how many (or None), now and then, by the thread that called. Results name files in the folder `scratch` without it.
#[pyfunction]
#[pyo3(signature = (arguments, progress=None, threads=None, scratch=None))]
fn call(
    py: Python<'_>,
    arguments: Vec<OsString>,
    progress: Option<Py<PyAny>>,
    threads: Option<usize>,
    scratch: Option<PathBuf>,
) -> PyResult<(String, Vec<Wrong>, Vec<String>)> {
    let seen: Arc<Mutex<Latest>> = Arc::default();
    let latest = Arc::clone(&seen);
    let threads = threads.unwrap_or_else(|| std::thread::available_parallelism().map_or(1, usize::from));
    // Threads of the call alone: none are left that a fork would lose.
    let context = Context::new().with_threads(threads).map_err(refused)?.with_progress(move |now| {
        *latest.lock().unwrap_or_else(PoisonError::into_inner) = Some((now.stage.to_owned(), now.done, now.of));
    });
    let context = match &scratch {
        Some(folder) => context.with_scratch(folder),
        None => context,
    };
    let (give, take) = mpsc::channel();
    // What waits without Python's lock has to be of no thread.
    let take = Mutex::new(take);
    let theirs = context.clone();
    let worker = std::thread::spawn(move || {
        let (mut out, mut notes) = (Vec::new(), Vec::new());
        let program = std::iter::once(OsString::from("borescope"));
        let ran =
            catch_unwind(AssertUnwindSafe(|| borescope::call(program.chain(arguments), &theirs, &mut out, &mut notes)));
        // Whoever waits for it is there until it comes.
        let _ = give.send((ran, out, notes));
    });
    let mut interrupted = None;
    let (ran, out, notes) = loop {
        match py.detach(|| take.lock().unwrap_or_else(PoisonError::into_inner).recv_timeout(LOOK)) {
            Ok(done) => break done,
            Err(RecvTimeoutError::Disconnected) => {
                return Err(pyo3::exceptions::PyRuntimeError::new_err("the work ended without a result"));
            }
            Err(RecvTimeoutError::Timeout) => {}
        }
        if interrupted.is_some() {
            continue;
        }
        let told = py.check_signals().and_then(|()| match &progress {
            None => Ok(()),
            Some(progress) => {
                let now = seen.lock().unwrap_or_else(PoisonError::into_inner).take();
                now.map_or(Ok(()), |now| progress.call1(py, now).map(drop))
            }
        });
        if let Err(error) = told {
            context.cancel();
            interrupted = Some(error);
        }
    };
    // It has sent its result, and ends.
    let _ = worker.join();
    if let Some(error) = interrupted {
        return Err(error);
    }
    let out = String::from_utf8_lossy(&out).into_owned();
    match ran {
        Ok(Ok(_)) => Ok((out, Vec::new(), notes)),
        Ok(Err(complaints)) => Ok((out, complaints.iter().map(wrong).collect(), notes)),
        Err(_) => Err(pyo3::exceptions::PyRuntimeError::new_err(
            "a mistake of the borescope itself; please report it with what you called",
        )),
    }
}

fn refused(complaint: Complaint) -> PyErr {
    pyo3::exceptions::PyValueError::new_err(complaint.to_string())
}

/// Runs the command as a program does, with its standard output and its signals; gives the exit status.
#[pyfunction]
fn command(py: Python<'_>, arguments: Vec<OsString>) -> u8 {
    py.detach(|| borescope::command(arguments))
}

// Nothing here is shared between calls, so the free-threaded Python may run several at once.
#[pymodule(gil_used = false)]
fn _borescope(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add("__version__", env!("CARGO_PKG_VERSION"))?;
    module.add_function(wrap_pyfunction!(call, module)?)?;
    module.add_function(wrap_pyfunction!(command, module)?)
}
