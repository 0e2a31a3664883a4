//! Simulation by an explicit method of another library: for circuits that are not stiff, and as an independent check.

use std::cell::RefCell;

use ode_solvers::{DVector, Dopri5, OutputType, System as ExplicitSystem};

use super::super::assembly::{Assembly, Inputs};
use super::super::drive::InputSignals;
use super::super::start;
use super::{Model, Outputs, SimulationError, SolverEffort};
use crate::numeric::System;

/// Most steps between two rows: a circuit that needs more is stiff.
const STEPS: u32 = 20_000;
/// The library's defaults.
const SAFETY: f64 = 0.9;
const STABILISATION: f64 = 0.04;
const SHRINK: f64 = 0.2;
const GROW: f64 = 10.0;

/// The equations in states divided by their typical magnitudes, since the library has one absolute tolerance for all.
struct Scaled<'a, 'b, const N: usize> {
    assembly: &'a RefCell<Assembly<'b, f64>>,
    scales: &'a [f64; N],
}

impl<const N: usize> ExplicitSystem<f64, DVector<f64>> for Scaled<'_, '_, N> {
    fn system(&self, t: f64, scaled: &DVector<f64>, rate: &mut DVector<f64>) {
        let mut y = [0.0; N];
        for ((y, scaled), scale) in y.iter_mut().zip(scaled.iter()).zip(self.scales) {
            *y = scaled * scale;
        }
        let mut dydt = [0.0; N];
        self.assembly.borrow_mut().derivative(t, &y, &mut dydt);
        for ((rate, dydt), scale) in rate.iter_mut().zip(dydt).zip(self.scales) {
            *rate = dydt / scale;
        }
    }
}

impl Model {
    /// As [`Model::solve`], by the explicit Dormand-Prince method 5(4) of the library `ode_solvers`, at the same
    /// tolerance. It serves circuits that are not stiff, such as open reservoirs; on stiff ones, such as short lines of
    /// oil, it takes very many steps or gives up. Every row and every jump of an input ends a run of its own.
    ///
    /// # Errors
    /// More than 20 000 steps from one row to the next, or a step that comes to nothing: the circuit is stiff, or the
    /// parameters have no physical sense.
    #[doc(hidden)]
    pub fn solve_explicitly(
        &self,
        parameters: &[f64],
        drive: &InputSignals,
        times: &[f64],
    ) -> Result<Outputs, SimulationError> {
        with_states!(self.layout.states, N => self.run_explicitly::<N>(parameters, drive, times))
    }

    fn run_explicitly<const N: usize>(
        &self,
        parameters: &[f64],
        drive: &InputSignals,
        times: &[f64],
    ) -> Result<Outputs, SimulationError> {
        let acting = drive.with_dead_times(&self.rig, parameters);
        let drive = acting.as_ref();
        let mut values = vec![vec![0.0; times.len()]; self.rig.sensors.len()];
        let mut effort = SolverEffort::default();
        let assembly = RefCell::new(Assembly::new(&self.rig, &self.layout, parameters));
        let mut scales = [1.0; N];
        scales[..self.layout.states].copy_from_slice(&self.layout.scales);
        let mut y = [0.0; N];
        let mut raw = vec![0.0; self.rig.sensors.len()];
        let mut rows = times.iter().copied().enumerate().peekable();
        let mut emit = |row: usize, t: f64, y: &[f64; N]| {
            assembly.borrow_mut().raw_values(t, y, &mut raw);
            for ((sensor, raw), values) in self.rig.sensors.iter().zip(&raw).zip(&mut values) {
                values[row] = raw * parameters[sensor.first_parameter + 1] + parameters[sensor.first_parameter];
            }
        };
        for (index, piece) in drive.pieces.iter().enumerate() {
            assembly.borrow_mut().inputs = Inputs::of(piece, drive.begun);
            if index == 0 {
                let mut assembly = assembly.borrow_mut();
                start::start(&self.rig, &self.layout, &mut assembly, parameters, drive, piece.start, &mut y);
            }
            let last = index + 1 == drive.pieces.len();
            let system = |y: &[f64; N], from: f64, to: f64, effort: &mut SolverEffort| {
                self.leap(&Scaled { assembly: &assembly, scales: &scales }, y, from, to, effort)
            };
            let mut t = piece.start;
            while let Some((row, time)) = rows.next_if(|(_, time)| *time <= piece.end || last) {
                let next = time.clamp(t, piece.end);
                y = system(&y, t, next, &mut effort)?;
                t = next;
                emit(row, t, &y);
            }
            y = system(&y, t, piece.end, &mut effort)?;
        }
        self.read_by_effects(parameters, drive, times, &mut values);
        Ok(Outputs { values, effort })
    }

    /// The states at `to`, s.
    fn leap<const N: usize>(
        &self,
        system: &Scaled<'_, '_, N>,
        y: &[f64; N],
        from: f64,
        to: f64,
        effort: &mut SolverEffort,
    ) -> Result<[f64; N], SimulationError> {
        self.rig.context().check()?;
        let length = to - from;
        // Rows and knots that differ by rounding only are one.
        if length <= 1e-12 * to.abs().max(1.0) {
            return Ok(*y);
        }
        let scaled = DVector::from_iterator(N, y.iter().zip(system.scales).map(|(y, scale)| y / scale));
        let own = Scaled { assembly: system.assembly, scales: system.scales };
        let (rtol, atol) = (self.tolerance.relative, self.tolerance.absolute);
        let mut solver = Dopri5::from_param(
            own,
            from,
            to,
            length,
            scaled,
            rtol,
            atol,
            SAFETY,
            STABILISATION,
            SHRINK,
            GROW,
            length,
            0.0,
            STEPS,
            1000,
            OutputType::Sparse,
        );
        let stats =
            solver.integrate().map_err(|error| SimulationError::Explicit { t: from, reason: error.to_string() })?;
        effort.steps += stats.accepted_steps as usize;
        effort.rejected += stats.rejected_steps as usize;
        let mut end = *y;
        if let Some(reached) = solver.y_out().last() {
            for ((end, reached), scale) in end.iter_mut().zip(reached.iter()).zip(system.scales) {
                *end = reached * scale;
            }
        }
        Ok(end)
    }
}
