//! Thresholds of [`crate::suggest`] and what else compares models.

settings! {
    /// Thresholds of [`crate::suggest`] and what else compares models.
    LearningSettings, "learn" {
        // Models compared.
        /// Difference of the information criterion within which two explanations are rivals.
        rival_bic: f64 = 10.0, "BIC",
            "Very strong evidence (Kass and Raftery, Journal of the American Statistical Association 90 (1995)): odds \
             of 150 to 1.";
        /// Rounds of isolation of each fit of a model.
        isolation_rounds: u64 = 4, "rounds",
            "Cost only: rounds end before where they settle.";
        /// What an effect has to explain to be called found.
        explained_share: f64 = 0.8, "share of the error beyond noise",
            "Four fifths of the variance: what is left is less than half of the error, as a standard deviation.";
        /// What an effect that is named as a part of what is missing has to explain on the check record.
        part_share_check: f64 = 1.0 / 3.0, "share of the error beyond noise",
            "Less is what any effect takes that goes a little with the one that is missing.";
        /// What an explanation has to be better by than one with fewer effects, or than one of physics alone.
        clear_share: f64 = 0.03, "share of the error",
            "The standard error of an error of 550 independent samples.";
        /// What an effect has to explain where the model is within its tolerance.
        tolerated_share: f64 = 0.03, "chi-square per sample",
            "3 % of the variance of the noise: what is less is tolerance.";
        /// Most fits of a model with the lack of fit that the one before left.
        weighings: usize = 3, "fits",
            "Cost only: they end before where the lack of fit stays.";
        /// Rows to each side that say whether a misfit lasts.
        lasting_rows: usize = 2, "rows",
            "A median of five: an outlier of one or two rows does not last.";
        /// Ratio of stated to shown noise from which on the record is believed.
        noise_ratio: f64 = 2.0, "ratio",
            "Filtered sensors have a correlation of 0.5 between neighbours, with which second differences show 0.65 \
             of the noise.";
        /// Fewest that show a noise.
        noise_differences: usize = 50, "second differences",
            "Statistics: their median is then known to a fifth.";
        /// Two lacks of fit within this count as the same.
        lack_of_fit_ratio: f64 = 1.25, "ratio",
            "Numerical accuracy: estimates move by less than their standard errors do.";
        // Candidates.
        /// Candidates that are fitted.
        candidates_fitted: usize = 8, "candidates",
            "Cost only: candidates come in the order of what their score promises.";
        /// Candidates that are fitted from the model without faults, and where the model is within its tolerance.
        candidates_fitted_near: usize = 4, "candidates",
            "Cost only.";
        /// Candidates that are fitted though they promise no more than the tolerance of a model that is within it.
        candidates_fitted_tolerated: usize = 2, "candidates",
            "Cost only.";
        /// What a candidate has to promise to be fitted.
        candidate_share: f64 = 0.03, "share of the best score",
            "Cost only: a score is a prediction that holds within a factor of a few, not of thirty.";
        /// Effects of which pairs are fitted where none explains the record alone.
        effects_paired: usize = 5, "effects",
            "Cost only.";
        /// What two effects have to gain one by one for their pair to be fitted.
        pair_gain_share: f64 = 0.1, "share of the error beyond noise",
            "Cost only: together they may gain more.";
        /// Effects that are fitted beside one that explains much but not all.
        effects_beside: usize = 3, "effects",
            "Cost only.";
        /// Ratio of two scores within which the fit has to say which effect explains more.
        score_ratio: f64 = 1.2, "ratio",
            "Cost only.";
        /// What the loaded model has to gain, from where an effect has led, for all to begin again.
        restart_share: f64 = 0.3, "share of the gain",
            "Cost only: with less the candidates stay in order.";
        /// Root sum of squares of the change of the weighted misfits below which a candidate is not excited.
        excited_change: f64 = 0.1, "standard deviations of the noise",
            "Statistics: its size would be known to no better than ten times itself.";
        /// Below this share that others cannot take over a candidate counts as absorbed.
        absorbed_share: f64 = 0.05, "share of the influence",
            "Less than a twentieth of what it changes is its own; the rest is explained by what is estimated anyway.";
        /// Factor on the tried size beyond which the local model is not believed.
        size_factor: f64 = 20.0, "ratio",
            "Cost only: larger sizes are tried themselves.";
        /// Cosine between the changes by two neighbouring sizes below which one between them is tried too.
        neighbour_cosine: f64 = 0.7, "cosine",
            "45 degrees: with less a step along one is no step along the other.";
        /// Ratio of two sizes between which none is tried.
        size_ratio: f64 = 1.03, "ratio",
            "Cost only.";
        /// Most sizes that are tried of one effect.
        sizes: usize = 64, "sizes",
            "Cost only.";
        /// A change that is longer than the misfits by this factor is not tried further.
        change_ratio: f64 = 2.0, "ratio",
            "Geometry: a change longer than twice the misfits raises the cost, however it points.";
        /// Cosine between the changes by two sizes above which they lie on a straight line.
        straight_cosine: f64 = 0.9, "cosine",
            "Numerical accuracy: a score along a line is then right to a fifth.";
        /// Larger sizes are tried where the one before is too small by this factor.
        larger_factor: f64 = 1.5, "ratio",
            "Cost only: sizes stand a factor of 1.7 to 5 apart.";
        // Fits.
        /// Linearisations of a fit that goes on to its end.
        linearisations: usize = 12, "linearisations",
            "Cost only: fits end before where they settle.";
        /// Standard uncertainty of an effect before the record, in typical sizes, or in tried ones if those are larger.
        effect_sigma: f64 = 10.0, "typical sizes",
            "Next to nothing is known: an effect of typical size that a record shows at all is shrunk by less than 1 \
             %.";
        /// Standard uncertainty, before the record, of a parameter that only shapes an effect.
        shape_sigma: f64 = 1.0, "typical sizes",
            "A typical value is known up to its own size; shapes that no record determines stay typical.";
        /// Standard uncertainty of an effect that is refitted, in typical sizes, or in the size that it has if that is
        /// larger.
        revised_sigma: f64 = 10.0, "typical sizes",
            "As of an effect that is fitted first.";
        /// Standard uncertainty of an effect that is added without a record.
        unfitted_sigma: f64 = 3.0, "typical sizes",
            "What an effect may be in practice: typical sizes hold within half an order of magnitude.";
        /// Effects within this of the best one are fitted to their end too.
        close_share: f64 = 0.05, "share of the best gain",
            "Cost only: preliminary fits are within this of their end.";
        /// Effects beside which faults were isolated again are fitted to their end within this of the best one.
        close_share_isolated: f64 = 0.01, "share of the best gain",
            "Cost only: those fits are nearer to their end.";
        /// What a preliminary fit has to keep of what its score promised; otherwise it begins at other starts too.
        kept_share: f64 = 0.5, "share of the score",
            "Cost only.";
        /// Most effects beside which faults are isolated again.
        effects_isolated: usize = 2, "effects",
            "Cost only.";
        /// Most effects whose fit goes on to its end.
        effects_continued: usize = 3, "effects",
            "Cost only.";
        /// What an effect in the place of a fault has to keep, in the local model, to be fitted; what a value that nobody declared has to take
        /// of what an effect takes to be asked about before it.
        rival_share: f64 = 0.8, "share of what a fault explains",
            "At a correlation of 0.9 of both changes, 0.8 is kept.";
        /// Effects that are fitted in place of each fault, or of all of them, and values that nobody declared in place of these.
        rivals_fitted: usize = 2, "effects",
            "Cost only.";
        /// Linearisations of the fit of a rival to what the other predicts.
        experiment_linearisations: usize = 4, "linearisations",
            "Cost only.";
        /// Linearisations of the beginning of that fit, for each experiment on the menu.
        experiment_first_linearisations: usize = 1, "linearisations",
            "Cost only.";
        // Additions.
        /// Most effects that are added.
        additions: usize = 5, "effects",
            "Cost only: the loop ends before where the model is adequate or nothing helps.";
        /// What an addition has to take away on the fit record.
        addition_share_fit: f64 = 0.05, "share of the error beyond noise",
            "Less than a twentieth does not change what the model is good for.";
        /// What an addition has to take away on the check record.
        addition_share_check: f64 = 0.03, "share of the error",
            "As of an explanation that is clearly better.";
        /// What a curve without a formula has to take away on the fit record.
        curve_share_fit: f64 = 0.3, "share of the error beyond noise",
            "A curve has ten times the freedom of a formula and fits almost anything a little.";
        /// What a curve without a formula has to take away on the check record.
        curve_share_check: f64 = 0.1, "share of the error",
            "Three times that of a formula.";
        /// What a pair has to take away of what the best single effect leaves.
        pair_share: f64 = 0.1, "share of the check error",
            "Three times what one effect has to.";
        // Phases and pictures.
        /// What is called switching behind a jump of an input.
        switching_time: f64 = 0.1, "s",
            "Physics: directional valves of sizes 6 to 10 reach their end within 30 to 100 ms.";
        /// Least rows of a switching.
        switching_rows: usize = 10, "rows",
            "Statistics: fewer show no level.";
        /// Rows to each side over which a speed is taken.
        speed_rows: usize = 5, "rows",
            "Statistics: the slope over 11 rows has a fifteenth of the noise of one over two.";
        /// Speed from which on a body moves, in its own noise.
        moving_deviations: f64 = 5.0, "standard deviations",
            "Normal: one standing row in 1.7 million is taken to move.";
        /// Speed from which on a body moves, in the greatest speed of the record.
        moving_share: f64 = 0.02, "share of the greatest speed",
            "Creep of a leaking valve is below this.";
        /// A stretch of fewer rows belongs to that before it.
        phase_rows: usize = 10, "rows",
            "Statistics: fewer show no level.";
        /// From this correlation on a misfit is said to correlate with a quantity.
        named_correlation: f64 = 0.2, "correlation",
            "4 % of its variance; chance makes 0.1 of 400 independent samples, at two standard deviations.";
        /// Other quantities are named too that correlate as much.
        named_share: f64 = 0.9, "share of the greatest correlation",
            "Numerical accuracy of a correlation over the phases of a cycle.";
        /// Standard deviation of the heights of a curve before the record.
        curve_sigma: f64 = 1e4, "typical sizes",
            "Next to nothing is known.";
        /// Influence of a height from which on the record has been there.
        visited_share: f64 = 0.02, "share of the largest influence",
            "A standard error of more than fifty times the least.";
    }
}
