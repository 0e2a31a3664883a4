//! Alarms that belong together, and which window of them is worth a diagnosis.

use super::result::{Episode, FiredResidual};
use crate::residual::Fired;

/// The episodes of a record, in windows of one length.
#[derive(Debug, Default)]
pub(super) struct Episodes {
    pub all: Vec<Running>,
    /// Length of a window, s.
    length: f64,
}

/// An episode that may go on.
#[derive(Debug)]
pub(super) struct Running {
    pub episode: Episode,
    /// Number of the window of the first alarm, and whether it holds the onset too.
    first: usize,
    begun_inside: bool,
    /// Whether residuals fire in the window behind that.
    next: bool,
    /// Whether a diagnosis was tried.
    pub settled: bool,
}

impl Episodes {
    pub fn new(length: f64) -> Self {
        Self { all: Vec::new(), length }
    }

    /// Takes the next alarm, which lies in this window, and its onset in that.
    ///
    /// It belongs to an episode if its sum has grown since no later than a window behind the last alarm there, and if its
    /// residual has fired there before or began to leave zero within a window of the first one; otherwise something has changed.
    pub fn take(&mut self, fired: Fired, window: usize, onset: usize) {
        let length = self.length;
        let known = self.all.last_mut().filter(|running| {
            let episode = &running.episode;
            let has = episode.residuals.iter().any(|residual| residual.id == fired.id);
            fired.onset_s <= episode.last_alarm_s + length && (has || fired.onset_s <= episode.onset_s + length)
        });
        match known {
            Some(running) => running.add(fired, window),
            None => self.all.push(Running::new(fired, window, onset)),
        }
    }
}

impl Running {
    fn new(fired: Fired, window: usize, onset: usize) -> Self {
        let episode = Episode {
            onset_s: fired.onset_s,
            first_alarm_s: fired.at_s,
            last_alarm_s: fired.at_s,
            alarms: 0,
            residuals: Vec::new(),
            diagnosed_s: None,
            diagnosis: None,
            not_diagnosed: None,
        };
        let mut running = Self { episode, first: window, begun_inside: onset == window, next: false, settled: false };
        running.add(fired, window);
        running
    }

    fn add(&mut self, fired: Fired, window: usize) {
        let episode = &mut self.episode;
        episode.alarms += 1;
        episode.last_alarm_s = fired.at_s;
        episode.onset_s = episode.onset_s.min(fired.onset_s);
        self.next |= window == self.first + 1;
        match episode.residuals.iter_mut().find(|residual| residual.id == fired.id) {
            Some(residual) => residual.alarms += 1,
            None => episode.residuals.push(FiredResidual {
                id: fired.id,
                first_alarm_s: fired.at_s,
                onset_s: fired.onset_s,
                direction: fired.direction,
                phase: fired.phase,
                alarms: 1,
            }),
        }
    }

    /// The window to diagnose, once all alarms up to the end of window `judged` are known: the first one that lies behind the
    /// onset as a whole; that of the first alarm if the episode is over by then.
    pub fn window(&self, judged: usize) -> Option<usize> {
        let wanted = match (self.settled, self.begun_inside) {
            (true, _) => return None,
            (false, true) if judged > self.first => self.first + usize::from(self.next),
            (false, true) => return None,
            (false, false) => self.first,
        };
        (judged >= wanted).then_some(wanted)
    }
}
