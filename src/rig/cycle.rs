//! The cycle that `simulate` runs where no record gives commands and loads.

/// How an input runs over one phase.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Profile {
    /// SI.
    pub from: f64,
    /// SI; equal to `from` where the input stands still.
    pub to: f64,
}

#[derive(Debug, Clone)]
pub struct Phase {
    /// s.
    pub duration: f64,
    /// One per input of the rig.
    pub inputs: Vec<Profile>,
}

#[derive(Debug, Clone)]
pub struct Cycle {
    /// Time between samples, s.
    pub interval: f64,
    pub phases: Vec<Phase>,
}

impl Cycle {
    /// s.
    pub fn duration(&self) -> f64 {
        self.phases.iter().map(|phase| phase.duration).sum()
    }
}
