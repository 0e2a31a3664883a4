//! Thresholds of [`crate::diagnose`].

settings! {
    /// Thresholds of [`crate::diagnose`].
    DiagnosisSettings, "diagnosis" {
        // Misfits and verdicts.
        /// A weighted misfit counts as no more than this where misfits are summed for a verdict.
        outlier_misfit: f64 = 5.0, "standard deviations of the noise",
            "One normal value in 1.7 million is beyond, so noise is not touched, and a few outliers do not condemn a \
             model.";
        /// Mean square of the weighted misfits of a sensor up to which the model is adequate.
        adequate_mean_square: f64 = 1.5, "variances of the noise",
            "What is left unexplained is then less than half of the noise of a single sample, in variance: below what \
             a record shows at a glance.";
        /// What chance is given beside the adequate mean square, and beside that of events.
        adequate_deviations: f64 = 4.0, "standard deviations",
            "Normal quantile of a false-alarm rate of one in 30,000 per sensor and record.";
        /// From this probability on a fault is called present, if its interval leaves the healthy value out.
        present_probability: f64 = 0.5, "probability",
            "Bayes' rule where a false alarm and a missed fault cost the same.";
        /// From so many faults at once on, fewer faults from other starts are looked for.
        several_faults: usize = 3, "faults",
            "Of 0.3 expected faults, three at once are present in fewer than one record in 250, so three are more \
             often a wrong explanation.";
        /// How often spools may be found to follow their commands otherwise than the rig file has it.
        dynamics_renewals: usize = 2, "explanations",
            "The second time from an explanation that the first one has led to; bounds the effort.";
        /// A part that is further off its data sheet is not believed to be.
        off_sheet_deviations: f64 = 4.0, "standard deviations of the data sheet",
            "Normal: of 80 parts that are right, one is as far off in half a per cent of machines.";
        /// A calibrated value that a record pulls further off may have changed: it is tried as a fault.
        changed_deviations: f64 = 3.0, "standard deviations of what a right model moves by",
            "Cost only: of 40 values that are right, one is as far off in a tenth of records; evidence decides.";
        /// A weighted misfit of more pulls with constant force only (Huber).
        huber_width: f64 = 3.0, "standard deviations of the noise",
            "One normal sample in 400 is beyond; estimates lose less than 0.2 % of their precision.";
        /// A decrease of the cost of less is not worth a step towards a value that is reported.
        exact_decrease: f64 = 0.02, "chi-square",
            "Numerical accuracy: a decrease of 0.02 moves an estimate by no more than 0.14 of its standard error.";
        /// What is reported is fitted until no step lowers the cost by more: two ways to the same explanation print the same digits.
        final_decrease: f64 = 0.0001, "chi-square",
            "Numerical accuracy: a decrease of 0.0001 moves an estimate by no more than a hundredth of its standard error.";
        /// Where fault combinations are compared, a decrease of the cost of less is not worth a step: what is promised is counted in.
        rough_decrease: f64 = 0.5, "chi-square",
            "Numerical accuracy: a quarter of a nat of evidence, far below what odds of prior and penalty differ by.";
        /// Uncertain parameters are searched so far to both sides of what is known of them.
        search_reach: f64 = 6.0, "standard deviations before the record",
            "Normal: one parameter in 500 million is beyond; a value at this end is called implausible.";
        /// A positive parameter is not estimated below this.
        least_share: f64 = 0.1, "share of the stated value",
            "Physics: no part in use has a tenth of its stated volume or stiffness; keeps laws away from zero.";
        /// How far a value that has not changed may be from what it was before a fault began.
        unchanged_share: f64 = 0.001, "share of the uncertainty",
            "Numerical accuracy: as good as nothing, but more than rounding.";
        /// Strides to each side over which a slope counts as steady.
        steady_strides: usize = 25, "strides",
            "Statistics: a median of 51 slopes is known to a fifth of their spread, and half of them have to be of an \
             event to move it.";
        /// Quiet rows before a bend counts as the start of a new phase, and not as part of the last event.
        quiet_rows: usize = 10, "rows",
            "Statistics: fewer rows determine level and slope of a phase no better than noise allows.";
        /// What an event may differ by counts as no more than this.
        event_outlier_misfit: f64 = 10.0, "standard deviations",
            "Twice what an outlier of a sample counts, so that a single event does not condemn a model.";
        /// So many directions in which events may differ are needed to judge their mean square.
        event_directions: f64 = 8.0, "independent directions",
            "A mean square of 8 has a relative standard error of a half; fewer are ruled by single events.";
        /// Standard uncertainty of the pressures at the start of a run.
        start_pressure_share: f64 = 0.01, "share of the pressure",
            "Class 1 of pressure gauges (EN 837): one per cent.";
        /// A sensor that reads so many times what the healthy model says is asked about.
        odd_ratio: f64 = 5.0, "ratio",
            "Between what faults change (less, but for flows that stop) and what a wrong unit does (psi for bar: 14).";
        /// A sensor is asked about only where so much of what is measured correlates with the model.
        odd_ratio_share: f64 = 0.5, "share of the squares",
            "A correlation of 0.71: what is left has another shape than the model, so that a ratio means nothing.";
        // Which fault combinations.
        /// Most faults of a combination.
        combination_faults: usize = 5, "faults",
            "Of 0.3 expected faults, six at once are present in one record in a million.";
        /// Up to so many faults of a rig all combinations of three are weighed.
        triples_faults: usize = 40, "faults",
            "Cost only: 9,880 combinations take as long as one simulation.";
        /// Pairs from which combinations of three are grown where a rig has more faults.
        triples_pairs: usize = 40, "pairs",
            "Cost only: as many combinations again, of 250 faults.";
        /// Number of faults expected in a record before it is seen.
        expected_faults: f64 = 0.3, "faults",
            "Prior: one record in four has a fault, which is what makes a diagnosis worth while; a factor of two is \
             0.7 nats.";
        /// Steps of each fit in a round of isolation.
        isolation_steps: u64 = 3, "steps",
            "Cost only: what is left is counted as promised, and the next round goes on.";
        /// Isolation ends where the best combination promises no larger decrease.
        isolation_decrease: f64 = 0.1, "chi-square",
            "Numerical accuracy: moves an estimate by no more than a third of its standard error, and an odds by 5 %.";
        /// Combinations within this of the best one, in the local model, are fitted to the record.
        isolation_evidence: f64 = 5.0, "nats",
            "Odds of 150 to 1 that the local model has to be wrong by.";
        /// Most combinations that are fitted in each round.
        isolation_fits: usize = 8, "combinations",
            "Cost only: the others keep what the local model says of them.";
        /// Most combinations that are fitted in each round while the model is far off.
        isolation_fits_far: usize = 3, "combinations",
            "Cost only: the local model of far off is renewed before it decides.";
        /// Mean square of the misfits from which on the model is far off.
        far_mean_square: f64 = 4.0, "variances of the noise",
            "Half of the misfits are then beyond 1.3 standard deviations: what is left is mostly not noise.";
        /// Most combinations that are fitted on where their steps ended before their promise was kept.
        overtaking_fits: usize = 3, "combinations",
            "Cost only.";
        /// Most rounds of isolation.
        isolation_rounds: u64 = 8, "rounds",
            "Cost only: rounds end before where they settle.";
        /// Faults that take each other's place with more probability are an ambiguity group.
        ambiguity_probability: f64 = 0.05, "probability",
            "The usual level of 5 % at which a possibility is named.";
        /// A fault is called identifiable if noise turns the order against each rival in fewer than one record of so many.
        identifiable_records: f64 = 100.0, "records",
            "False-isolation rate of 1 %.";
        // From start to estimate.
        /// Cost per sample from which on a start is taken to have missed; noise alone costs 1/2.
        missed_cost: f64 = 1.0, "half chi-square per sample",
            "Twice the variance of the noise, more than any adequate model leaves.";
        /// Most rounds of isolation and renewed weights.
        weight_renewals: usize = 3, "rounds",
            "Cost only: weights depend on the fit only through when events are, so two are enough unless the start \
             was far.";
        /// Rounds of isolation from the healthy rig.
        healthy_rounds: u64 = 2, "rounds",
            "Cost only: what it takes where faults are small or of sensors; larger ones are looked for from other \
             starts.";
        /// A round that leaves this share of a cost that is far too large is the last.
        stuck_share: f64 = 0.5, "share of the cost",
            "Cost only: other starts do better than a fit that creeps.";
        /// No fault moves by more when the rounds of renewed weights end.
        settled_deviation: f64 = 0.3, "standard errors",
            "Numerical accuracy: 0.3 standard errors add 4 % to the width of an interval.";
        /// What a preliminary fit may still fall by, in decreases by its last local model.
        predicted_decreases: f64 = 10.0, "decreases",
            "Convergence: a sum of decreases that each lose no more than an eleventh.";
        /// Linearisations of the first fit of each of several starts.
        first_linearisations: usize = 2, "linearisations",
            "Cost only: those that could still win go on.";
        /// Steps along one local model where only a neighbourhood is looked for.
        preliminary_steps: u64 = 4, "steps",
            "Cost only: the model is linearised again where it ends.";
        /// A change of the misfits that the local model misses by more is one that it does not foresee.
        unforeseen_share: f64 = 0.1, "share of the squares",
            "Numerical accuracy: a third of the change itself, beyond which a step along the local model is no step \
             downhill.";
        /// Combinations with one fault in place of several that are fitted, the most promising ones.
        replacements_fitted: usize = 3, "combinations",
            "Cost only.";
        /// Linearisations, and steps with each, of such a fit.
        replacement_linearisations: usize = 3, "linearisations",
            "Cost only.";
        /// Least decrease for which a fit goes on from another optimum.
        elsewhere_decrease: f64 = 1.0, "chi-square",
            "Numerical accuracy: half a nat, less than any other optimum differs by.";
        // Starts from few faults.
        /// Width of the loss by which starts are compared (Cauchy).
        start_loss_width: f64 = 10.0, "standard deviations of the noise",
            "Twice an outlier: a sample that is missed counts, hardly by how much.";
        /// A fit of a start widens its loss until this share of the misfits lies within.
        start_share_within: f64 = 0.75, "share of the samples",
            "Numerical accuracy: among misfits that pull with constant force a fit only creeps.";
        /// Cost per sample up to which a start may be the explanation, before events have got their tolerance.
        start_cost_before: f64 = 20.0, "half chi-square per sample",
            "Cost only: 40 times the noise; what events add is an order less.";
        /// Cost per sample up to which a start may be the explanation, when events have their tolerance.
        start_cost_after: f64 = 2.0, "half chi-square per sample",
            "Four times the noise, twice what is taken to have missed: isolation does the rest.";
        /// Cost per sample, with tolerance of events, up to which no further fault is looked for.
        start_cost_sufficient: f64 = 0.8, "half chi-square per sample",
            "The adequate mean square of 1.5 is 0.75.";
        /// Simulations of a single fault between two of its levels.
        bracket_simulations: u64 = 10, "simulations",
            "Cost only.";
        /// Distance of two levels to which the best value between them is found.
        bracket_share: f64 = 0.005, "share of the distance",
            "Numerical accuracy: 1/200 of a bracket is below what a fit moves anyway.";
        /// Most faults of a start.
        start_faults: usize = 3, "faults",
            "As of combinations that are weighed in full.";
        /// How many further faults are fitted at each growth of a start, the most promising ones.
        growth_fits: usize = 3, "faults",
            "Cost only.";
        /// What a further fault has to take away.
        growth_share: f64 = 0.1, "share of the cost",
            "Cost only: starts need not be complete, isolation adds what is small.";
        /// Relative decrease that ends the fit of a start.
        start_fit_decrease: f64 = 0.01, "share of the cost",
            "Cost only: a start is a neighbourhood.";
        /// Iterations of each round of the fit of a start.
        start_fit_iterations: u64 = 4, "iterations",
            "Cost only.";
        /// Rounds of the fit of a start, each with the tolerance of the events where it begins.
        start_fit_rounds: usize = 4, "rounds",
            "Cost only.";
        /// Single faults that are fitted as starts.
        single_starts_fitted: usize = 2, "faults",
            "Cost only.";
        /// Starts of one or two faults that are fitted.
        several_starts_fitted: usize = 6, "starts",
            "Cost only.";
        /// Of those, starts that are grown by further faults.
        several_starts_grown: usize = 2, "starts",
            "Cost only.";
        // Onset.
        /// What an onset has to win beyond the logarithm of the number of rows that it is chosen among.
        onset_evidence: f64 = 5.0, "nats",
            "False-alarm rate: one record in 150 without onset would show one by chance.";
        /// So near to the start of a record, or its first command, no onset is looked for.
        onset_clearance: f64 = 0.2, "s",
            "Physics: faults as old as the record show at once or when the first command excites them, within a \
             settling time of the valves.";
        /// Rounds of isolation for faults as old as the record, from those of an onset.
        onset_rounds_compared: u64 = 3, "rounds",
            "Cost only.";
        /// Moments, evenly over the record, among which the search for the onset starts.
        onset_moments: usize = 50, "moments",
            "Cost only: each is a simulation.";
        /// How often the distance to the next moment tried is divided by three.
        onset_refinements: usize = 5, "divisions by three",
            "Numerical accuracy: 1/12,000 of the record, a row of most records.";
        /// Rounds of moment and faults.
        onset_rounds: usize = 2, "rounds",
            "Numerical accuracy: the second moves a number by up to a quarter of its half width, a third by none.";
        // Intervals.
        /// A fault combination of this probability is held by the intervals too.
        interval_probability: f64 = 0.05, "probability",
            "The complement of the 95 % that an interval holds.";
        /// Steps of a fit along one local model.
        interval_steps: u64 = 6, "steps",
            "Cost only.";
        /// A fit that a relinearisation would lower by less is at its end.
        interval_decrease: f64 = 0.1, "chi-square",
            "Numerical accuracy: 3 % of the rise of 3.84 that ends an interval.";
        /// Most relinearisations of the fit that an interval is drawn around.
        interval_relinearisations: usize = 2, "linearisations",
            "Cost only.";
        /// How often an interval is drawn again around a better fit that was met on the way.
        interval_redraws: usize = 2, "intervals",
            "Cost only.";
        /// How often a better optimum, found on a profile, restarts the fit.
        interval_restarts: usize = 3, "fits",
            "Cost only.";
        /// A restart that lowers the cost by less is the last one, and one that would is not made.
        restart_decrease: f64 = 1.0, "chi-square",
            "Numerical accuracy: half a nat, a quarter of the rise that ends an interval.";
        // Spools, and mistakes in taking a record.
        /// What other dynamics of the spools have to take away.
        dynamics_gain_share: f64 = 0.1, "share of the error beyond noise",
            "Where it is their doing they take most of it, a quarter where false faults stand in for them; where \
             something else is wrong, less than a hundredth.";
        /// Most that may remain with other dynamics of the spools for them to be believed.
        dynamics_left_share: f64 = 0.5, "share of the error beyond noise",
            "With more, most of it has another cause.";
        /// How often the steps of the search for dynamics are halved.
        dynamics_halvings: usize = 4, "halvings",
            "Numerical accuracy: to a sixteenth, a hundredth of lag and damping.";
        /// Most steps of that search.
        dynamics_steps: usize = 40, "steps",
            "Cost only: the search ends before by halving.";
        /// Rate at which the derivative by the rate of the clock is taken.
        clock_rate_tried: f64 = 0.0001, "relative rate",
            "Numerical accuracy: curves shift by less than a row in most records.";
        /// Largest rate that is searched.
        clock_rate_most: f64 = 0.05, "relative rate",
            "Physics: quartz errs by 1e-4; beyond this the sampling interval itself is mistaken, which `check` asks \
             about.";
        /// Most times that the size of a common cause, a clock's rate or an oil's viscosity, is improved.
        cause_improvements: usize = 8, "improvements",
            "Cost only: misfits far beyond the noise pull with constant force, so a large size is reached in several \
             steps.";
        /// Linearisations of the fit without faults from which such a size is estimated.
        cause_linearisations: usize = 3, "linearisations",
            "Cost only.";
        /// Mistakes in taking a record that are explained in full, those that leave least to the healthy model.
        causes_explained: usize = 2, "mistakes",
            "Cost only.";
        /// A rate within this is none: a window begins where all sensors stand.
        standing_deviations: f64 = 3.0, "standard deviations",
            "Normal quantile: one standing sensor in 370 is taken to move.";
    }
}
