//! Random effects that samples have in common, as orthonormal directions with the share that each takes away.

use nalgebra::{DMatrix, Dyn, SymmetricEigen};

use crate::numeric::{dot, take_along};

/// Square of a size that shows nowhere: it takes away half a millionth of a misfit.
const UNSEEN: f64 = 1e-6;
/// Share of the largest square, and of the most that two effects can have in common, that is rounding.
const ROUNDING: f64 = 1e-12;

/// What samples have in common by random effects, as what it takes away of their misfits.
#[derive(Debug, Clone, Default)]
pub(super) struct Directions {
    /// Orthonormal, over the samples.
    directions: Vec<Vec<f64>>,
    /// Share of each direction that is taken away, `1 - 1/sqrt(1 + size²)`.
    taken: Vec<f64>,
}

impl Directions {
    /// For effects `G` (columns): orthonormal `U` and shares `f` with `(I + G G')^(-1/2) = I - U diag(f) U'`.
    pub fn of(effects: &[Vec<f64>]) -> Self {
        let all: Vec<&[f64]> = effects.iter().map(Vec::as_slice).collect();
        if all.is_empty() {
            return Self::default();
        }
        // G = U S V' from the small matrix G'G = V S² V'.
        let eigen = SymmetricEigen::new(gram(&all));
        if eigen.eigenvalues.iter().chain(eigen.eigenvectors.iter()).all(|value| value.is_finite()) {
            return directions(&all, &eigen);
        }
        // Most parts of a large rig do next to nothing in a phase, and its square is none.
        let unseen = UNSEEN / all.len() as f64;
        let seen: Vec<&[f64]> = all.into_iter().filter(|effect| dot(effect, effect) > unseen).collect();
        if seen.is_empty() {
            return Self::default();
        }
        directions(&seen, &SymmetricEigen::new(without_rounding(gram(&seen))))
    }

    pub fn is_empty(&self) -> bool {
        self.directions.is_empty()
    }

    /// Each direction with the share that is taken away of it.
    pub fn iter(&self) -> impl Iterator<Item = (&[f64], f64)> + Clone {
        self.directions.iter().map(Vec::as_slice).zip(self.taken.iter().copied())
    }

    /// Takes away of samples what they have in common.
    pub fn take_from(&self, samples: &mut [f64]) {
        self.iter().for_each(|(direction, taken)| take_along(samples, direction, taken));
    }

    /// Effects that have these directions, each of its own.
    pub fn effects(&self) -> impl Iterator<Item = Vec<f64>> {
        self.iter().map(|(direction, taken)| {
            let size = ((1.0 - taken).powi(-2) - 1.0).sqrt();
            direction.iter().map(|value| size * value).collect()
        })
    }
}

/// `G'G`.
fn gram(effects: &[&[f64]]) -> DMatrix<f64> {
    DMatrix::from_fn(effects.len(), effects.len(), |i, j| dot(effects[i], effects[j]))
}

/// The same, what two effects have in common by rounding alone taken as nothing.
fn without_rounding(mut gram: DMatrix<f64>) -> DMatrix<f64> {
    let sizes: Vec<f64> = gram.diagonal().iter().map(|square| square.sqrt()).collect();
    for (i, j) in (0..sizes.len()).flat_map(|i| (0..sizes.len()).map(move |j| (i, j))) {
        if gram[(i, j)].abs() <= ROUNDING * sizes[i] * sizes[j] {
            gram[(i, j)] = 0.0;
        }
    }
    gram
}

/// The directions of effects, `U = G V / S`, and their shares.
fn directions(effects: &[&[f64]], eigen: &SymmetricEigen<f64, Dyn>) -> Directions {
    let largest = eigen.eigenvalues.max();
    let (mut directions, mut taken) = (Vec::new(), Vec::new());
    for (index, &square) in eigen.eigenvalues.iter().enumerate() {
        // Below this, rounding is all that is left of the direction, and its effect is none.
        if square <= UNSEEN || square <= ROUNDING * largest {
            continue;
        }
        let mut direction = vec![0.0; effects[0].len()];
        for (effect, share) in effects.iter().zip(eigen.eigenvectors.column(index).iter()) {
            for (slot, value) in direction.iter_mut().zip(*effect) {
                *slot += share * value / square.sqrt();
            }
        }
        directions.push(direction);
        taken.push(1.0 - 1.0 / (1.0 + square).sqrt());
    }
    Directions { directions, taken }
}
