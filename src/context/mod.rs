//! What a computation runs in: who hears of its progress, who may end it early, on which threads it works, and with which thresholds.
//!
//! A [`Context`] comes with the [rig](crate::rig::Rig) and so reaches every computation on it. There is nothing of it that the
//! whole program shares: two diagnoses in one program have their own progress, cancellation and threads.

mod crew;
mod progress;

use std::fmt;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};

use rayon::{ThreadPool, ThreadPoolBuilder};

use crate::complaint::{Complaint, Kind};
use crate::settings::Settings;
pub(crate) use crew::work_off;
pub use progress::Progress;
pub(crate) use progress::{Count, Listener};

/// The progress listener, the cancellation flag, the threads, the effort and the settings of a computation. Clones share all of them.
///
/// ```
/// use borescope::Context;
/// use borescope::Rig;
///
/// let context = Context::new().with_threads(2)?.with_progress(|progress| eprintln!("{progress}"));
/// let rig = Rig::read("fixtures/telescopic/rig.toml")?.with_context(&context);
/// // From another thread, or before the work begins: it then ends with a complaint of the kind `Interrupted`.
/// context.cancel();
/// # assert!(rig.context().is_cancelled());
/// # Ok::<(), borescope::Complaint>(())
/// ```
#[derive(Clone, Default)]
pub struct Context {
    listener: Option<Listener>,
    first_look: Option<Hearer>,
    cancelled: Arc<AtomicBool>,
    threads: Option<Arc<ThreadPool>>,
    effort: Arc<Effort>,
    settings: Arc<Settings>,
    scratch: Option<Arc<Path>>,
}

/// Who hears what a first look shows.
type Hearer = Arc<dyn Fn(&str) + Send + Sync>;

/// What has been solved so far in a context and its clones.
#[derive(Debug, Default)]
pub struct Effort {
    simulations: AtomicU64,
    linearisations: AtomicU64,
}

impl Effort {
    /// Simulations without derivatives.
    pub fn simulations(&self) -> u64 {
        self.simulations.load(Ordering::Relaxed)
    }

    /// Simulations with derivatives by parameters, however many those are.
    pub fn linearisations(&self) -> u64 {
        self.linearisations.load(Ordering::Relaxed)
    }
}

/// A computation that was cancelled before its end.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Interrupted;

impl Context {
    /// Without listener, not cancelled, on the threads of the caller: those of rayon's pool that the call is made in.
    pub fn new() -> Self {
        Self::default()
    }

    /// The same with a listener. It is called by any of the threads, several at a time, and should return at once.
    pub fn with_progress(self, listener: impl Fn(Progress<'_>) + Send + Sync + 'static) -> Self {
        Self { listener: Some(Arc::new(listener)), ..self }
    }

    /// The same with a hearer of what long work shows at first look, in one line: a verdict before its intervals, an error before its
    /// cause. The result replaces it.
    #[must_use]
    pub fn with_first_look(self, hearer: impl Fn(&str) + Send + Sync + 'static) -> Self {
        Self { first_look: Some(Arc::new(hearer)), ..self }
    }

    /// The same without listener and hearer; whoever cancels one cancels the other.
    pub fn without_progress(self) -> Self {
        Self { listener: None, first_look: None, ..self }
    }

    /// The same with so many threads of its own, 1 or more. Results do not depend on how many there are.
    ///
    /// # Errors
    /// No threads, or more than the system gives.
    pub fn with_threads(self, threads: usize) -> Result<Self, Complaint> {
        if threads == 0 {
            return Err(Complaint::new(Kind::Bounds, "no threads to work with").help("give a number above 0"));
        }
        let pool = ThreadPoolBuilder::new().num_threads(threads).build().map_err(|error| {
            Complaint::new(Kind::Bounds, format!("{threads} threads cannot be started: {error}")).help("ask for fewer")
        })?;
        Ok(Self { threads: Some(Arc::new(pool)), ..self })
    }

    /// The same where files of this folder were written for the call alone: results name them without it.
    #[must_use]
    pub fn with_scratch(self, folder: &Path) -> Self {
        Self { scratch: Some(folder.into()), ..self }
    }

    /// What results call a file.
    #[cfg_attr(not(feature = "store"), expect(dead_code, reason = "only commands and stores name files"))]
    pub(crate) fn name_of(&self, path: &Path) -> PathBuf {
        let within = self.scratch.as_deref().and_then(|folder| path.strip_prefix(folder).ok());
        within.unwrap_or(path).to_path_buf()
    }

    /// The same with other thresholds.
    #[must_use]
    pub fn with_settings(self, settings: Settings) -> Self {
        Self { settings: Arc::new(settings), ..self }
    }

    /// The thresholds of diagnosis, learning and calibration.
    pub fn settings(&self) -> &Settings {
        &self.settings
    }

    /// What has been solved so far in this context and its clones.
    #[doc(hidden)]
    pub fn effort(&self) -> &Effort {
        &self.effort
    }

    /// Counts a simulation, with derivatives or without.
    pub(crate) fn solved(&self, with_derivatives: bool) {
        let counter = if with_derivatives { &self.effort.linearisations } else { &self.effort.simulations };
        counter.fetch_add(1, Ordering::Relaxed);
    }

    /// Ends what runs in this context or a clone of it: it returns [`Interrupted`], as a complaint of
    /// [`Kind::Interrupted`], as soon as it looks: at every step of the integrator and every round of a search. There is no way
    /// back.
    pub fn cancel(&self) {
        self.cancelled.store(true, Ordering::Relaxed);
    }

    /// Whether [`Context::cancel`] was called.
    pub fn is_cancelled(&self) -> bool {
        self.cancelled.load(Ordering::Relaxed)
    }

    /// Where a long loop looks whether it is still wanted.
    ///
    /// # Errors
    /// [`Context::cancel`] was called.
    pub fn check(&self) -> Result<(), Interrupted> {
        if self.is_cancelled() { Err(Interrupted) } else { Ok(()) }
    }

    /// Reports that a stage has begun whose length nobody knows.
    pub(crate) fn stage(&self, stage: &str) {
        self.report(Progress { stage, done: 0, of: None });
    }

    /// Tells what a first look shows, if anybody hears. What was cancelled meanwhile may be half a look.
    pub(crate) fn first_look(&self, shows: impl FnOnce() -> String) {
        if let Some(hearer) = self.first_look.as_ref().filter(|_| !self.is_cancelled()) {
            hearer(&shows());
        }
    }

    /// Begins a stage of so many equal pieces.
    pub(crate) fn count(&self, stage: &'static str, of: usize) -> Count<'_> {
        Count::new(self, stage, of)
    }

    fn report(&self, progress: Progress<'_>) {
        if let Some(listener) = &self.listener {
            listener(progress);
        }
    }

    /// How many threads it works on: without threads of its own as many as the machine has.
    #[cfg(feature = "cli")]
    pub(crate) fn threads(&self) -> usize {
        let of_machine = || std::thread::available_parallelism().map_or(1, usize::from);
        self.threads.as_ref().map_or_else(of_machine, |pool| pool.current_num_threads())
    }

    /// Does `work` on the threads of this context.
    pub(crate) fn on_threads<T: Send>(&self, work: impl FnOnce() -> T + Send) -> T {
        match &self.threads {
            Some(pool) => pool.install(work),
            None => work(),
        }
    }

    /// Does the whole of a computation on the threads of this context. What comes of one that was cancelled meanwhile is
    /// thrown away: its fits may lack the simulations that were cut short.
    pub(crate) fn run<T: Send>(&self, work: impl FnOnce() -> Result<T, Complaint> + Send) -> Result<T, Complaint> {
        self.check()?;
        let result = self.on_threads(work);
        self.check()?;
        result
    }
}

impl fmt::Debug for Context {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Context")
            .field("listens", &self.listener.is_some())
            .field("hears", &self.first_look.is_some())
            .field("cancelled", &self.is_cancelled())
            .field("threads", &self.threads.as_ref().map(|pool| pool.current_num_threads()))
            .finish()
    }
}

impl fmt::Display for Interrupted {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("interrupted")
    }
}

impl std::error::Error for Interrupted {}

impl From<Interrupted> for Complaint {
    fn from(interrupted: Interrupted) -> Self {
        Self::new(Kind::Interrupted, interrupted.to_string())
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Mutex;

    use super::*;

    #[test]
    fn a_listener_hears_its_own_stages_only() {
        let heard = Arc::new(Mutex::new(Vec::new()));
        let listen = Arc::clone(&heard);
        let context = Context::new().with_progress(move |progress| listen.lock().unwrap().push(progress.to_string()));
        context.clone().count("intervals", 2).one();
        Context::new().stage("of another");
        context.stage("fit");
        assert_eq!(*heard.lock().unwrap(), ["intervals: 0 of 2", "intervals: 1 of 2", "fit"]);
    }

    #[test]
    fn what_was_cancelled_has_no_result() {
        let context = Context::new();
        let cancelled = context.run(|| {
            context.clone().cancel();
            Ok(1)
        });
        assert_eq!(cancelled.unwrap_err().kind, Kind::Interrupted);
        assert_eq!(context.run(|| Ok(2)).unwrap_err().kind, Kind::Interrupted);
        assert_eq!(Context::new().run(|| Ok(3)), Ok(3));
    }

    #[test]
    fn work_is_done_on_the_threads_asked_for() {
        let context = Context::new().with_threads(3).unwrap();
        assert_eq!(context.on_threads(rayon::current_num_threads), 3);
        assert_eq!(Context::new().with_threads(0).unwrap_err().kind, Kind::Bounds);
    }
}
