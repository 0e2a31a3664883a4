//! The rooms of the crate, for its own tests, benches and fuzz targets. No part of what the library promises.

#[cfg(feature = "cli")]
pub use crate::cli::schemas::schemas;

/// A public room beside each private one, with the same items.
macro_rules! rooms {
    ($($(#[$condition:meta])? $room:ident),* $(,)?) => {
        $($(#[$condition])? pub mod $room { pub use crate::$room::*; })*
    };
}

rooms! {
    calibration,
    campaign,
    check,
    complaint,
    context,
    diagnosis,
    draft,
    estimation,
    expression,
    files,
    finding,
    #[cfg(feature = "store")]
    history,
    isolability,
    learn,
    model,
    number,
    numeric,
    physics,
    record,
    report,
    residual,
    rig,
    settings,
    simulation,
    #[cfg(feature = "store")]
    store,
    structure,
    units,
}
