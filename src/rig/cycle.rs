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

    /// The cycle with each input times its factor, and each phase as long as `length` times its duration, called in their
    /// order, but of whole rows: a logger knows between which of them its own commands changed.
    #[must_use]
    pub fn scaled(&self, factors: &[f64], mut length: impl FnMut() -> f64) -> Self {
        let phases = self.phases.iter().map(|phase| {
            let rows = (phase.duration * length() / self.interval).round().max(1.0);
            let input =
                |(profile, factor): (&Profile, &f64)| Profile { from: profile.from * factor, to: profile.to * factor };
            Phase { duration: rows * self.interval, inputs: phase.inputs.iter().zip(factors).map(input).collect() }
        });
        Self { interval: self.interval, phases: phases.collect() }
    }
}
