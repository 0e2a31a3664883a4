//! Who meets whom: which equations of a circuit check each other, and which faults such checks tell apart.
//!
//! Nothing here knows a number. A [`Structure`] lists equations with the unknowns in each; from it follow the
//! [Dulmage-Mendelsohn decomposition](matching::decompose), the minimal redundant sets ([`mso`], [`mtes`]), what faults
//! can be detected and isolated ([`isolability`]), a small set of tests ([`selection`]) and the sensors that are
//! missing ([`placement`]). [`analyse`] does all of it for a rig.
//!
//! ```
//! use borescope::internals::structure::{Structure, isolability};
//!
//! // Two sensors of one unknown: a fault of either is seen, but the other explains the same.
//! let relations = [["y1", "x", "f1"], ["y2", "x", "f2"]];
//! let twice = Structure::from_lists(&["x"], &["f1", "f2"], &["y1", "y2"], &relations, &[])?;
//! let isolation = isolability::isolation(&twice);
//! assert_eq!(isolation.detectable, [true, true]);
//! assert!(isolation.explained_by[0][1]);
//! # Ok::<(), borescope::internals::structure::UnknownName>(())
//! ```

mod analysis;
mod bits;
mod from_rig;
mod incidence;
pub mod isolability;
mod lumped;
pub mod matching;
pub mod mso;
pub mod mtes;
pub mod placement;
mod probe;
pub mod selection;
mod text;

pub use analysis::{Count, FaultPair, Isolability, StructuralTest, analyse};
pub use from_rig::from_rig;
pub use incidence::Structure;
#[cfg(feature = "internals")]
pub use incidence::{Equation, Unknown, UnknownName};

/// Sets of equations that a search found.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Search {
    /// Indices of the equations of each.
    pub sets: Vec<Vec<usize>>,
    /// `false` where the search stopped at its limit, or where the structure is too large to begin.
    pub complete: bool,
}
