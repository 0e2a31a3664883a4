//! Thresholds of [`crate::calibrate`].

settings! {
    /// Thresholds of [`crate::calibrate`].
    CalibrationSettings, "calibration" {
        // Fit.
        /// Parameters are searched so far to both sides.
        search_reach: f64 = 5.0, "standard deviations of the data sheet",
            "Normal: one parameter in 1.7 million is beyond.";
        /// A positive value is searched down to this.
        least_share: f64 = 0.1, "share of the stated value",
            "Physics: no healthy part has a tenth of its stated volume or stiffness; keeps laws away from zero.";
        /// A weighted misfit of more pulls with constant force only (Huber).
        huber_width: f64 = 3.0, "standard deviations of the noise",
            "One normal sample in 400 is beyond; estimates lose less than 0.2 % of their precision.";
        /// Width of the loss while the parameters are still those of the data sheet.
        first_loss_width: f64 = 10.0, "standard deviations of the noise",
            "Cost only: twice an outlier, so that the first fits are led by all samples.";
        /// An error of measured minus model that is named although the weighted misfit is explained: it lies where the record is steep, or may be another in each switching.
        plain_error: f64 = 5.0, "times noise and tolerance",
            "24 of 25 parts of the error are left to samples that count for little: nobody would call that followed.";
        /// Relative decrease that ends the first fits.
        first_decrease: f64 = 0.002, "share of the cost",
            "Cost only: fits with weights of their own follow.";
        /// Relative decrease that ends each fit.
        decrease: f64 = 1e-5, "share of the cost",
            "Numerical accuracy: far below a rise of 1 in chi-square of up to 100,000 samples.";
        /// Steps after which derivatives are taken again.
        iterations: u64 = 3, "steps",
            "Cost only.";
        /// Change of a noise below which rounds are settled.
        settled_noise: f64 = 0.05, "relative change",
            "The standard error of a noise of 200 independent samples.";
        /// Change of a tolerance below which rounds are settled.
        settled_tolerance: f64 = 0.25, "relative change",
            "The standard error of a tolerance of 8 phases.";
        /// Change of a parameter below which rounds are settled.
        settled_deviation: f64 = 0.3, "standard errors",
            "Numerical accuracy: 0.3 standard errors add 4 % to the width of an interval.";
        /// Derivatives are taken again where a parameter has moved by more.
        moved_share: f64 = 0.25, "share of the uncertainty before",
            "Numerical accuracy: laws bend over such a distance by less than a hundredth, which moves the optimum by \
             less than a hundredth of a standard error.";
        /// Linearisations at which other dynamics of the spools are asked for.
        dynamics_rounds: usize = 4, "linearisations",
            "Cost only: each where the fit with those before has led.";
        // Noise.
        /// Rows over which a straight line is taken off.
        noise_rows: usize = 40, "rows",
            "Long against the memory of a sensor, short against that of a circuit; a line of 40 rows takes 5 % of the \
             variance.";
        /// Least rows of such a stretch.
        noise_rows_least: usize = 10, "rows",
            "Statistics: a line takes a fifth of the variance of 10 rows.";
        /// Stretches that must be there before the noise of a sensor is estimated.
        noise_stretches: usize = 5, "stretches",
            "Statistics: 50 to 200 rows determine a noise to 5 to 10 %.";
        /// What an event may add to the variance of a sample that counts as quiet.
        quiet_share: f64 = 0.1, "share of the variance",
            "Biases a noise by no more than 5 %.";
        /// Largest correlation of neighbours that is believed.
        correlation_most: f64 = 0.9, "correlation",
            "Twenty rows of memory, half a stretch: a larger one is drift, which tolerance stands for.";
        /// Noise is taken as no less.
        noise_floor_resolution: f64 = 0.1, "share of the resolution",
            "Rounding alone has a standard deviation of 0.29 of the resolution.";
        /// Noise is taken as no less, in the noise that the rig file states.
        noise_floor_stated: f64 = 0.02, "share of the stated noise",
            "A sensor is not fifty times better than stated: such a record is dead.";
        // Tolerance and report.
        /// Phases that determine the size of a tolerance.
        tolerance_phases: usize = 8, "phases",
            "Statistics: a variance of 8 values has a relative standard error of a half, `sqrt(2/n)`, its root of a \
             quarter.";
        /// A tolerance is taken as no less.
        least_tolerance_share: f64 = 0.02, "share of the noise",
            "Averages out below the noise of 2,500 samples, more than a phase has.";
        /// Of the half-t prior of a tolerance.
        tolerance_freedom: f64 = 4.0, "degrees of freedom",
            "Gelman, Bayesian Analysis 1 (2006): heavy enough to be overruled, with a finite variance.";
        /// What remains of a sample without the levels of its phase counts as no more.
        level_outlier_misfit: f64 = 3.0, "standard deviations of the noise",
            "One normal sample in 400 is beyond.";
        /// Records determine a parameter if less is left of its uncertainty.
        informed_share: f64 = 0.7, "share of the uncertainty before",
            "Half of its variance.";
        /// Beyond this a parameter is not believed to be that of a healthy part.
        implausible_deviations: f64 = 3.0, "standard deviations of the data sheet",
            "Normal: one healthy parameter in 370.";
        /// A tolerance so many times the stated one, and as large as the noise, hides something.
        coarse_tolerance: f64 = 3.0, "ratio",
            "Statistics: 8 phases determine a tolerance to a quarter, so a factor of three is no chance.";
    }
}
