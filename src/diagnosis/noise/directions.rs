//! Random effects that samples have in common, as orthonormal directions with the share that each takes away.

use nalgebra::{DMatrix, Dyn, SymmetricEigen};

use crate::numeric::dot;

/// Square of a size that shows nowhere: it takes away half a millionth of a misfit.
const UNSEEN: f64 = 1e-6;
/// Share of the largest square, and of the most that two effects can have in common, that is rounding.
const ROUNDING: f64 = 1e-12;

/// For effects `G` (columns): orthonormal `U` and shares `f` with `(I + G G')^(-1/2) = I - U diag(f) U'`.
pub(super) fn random_directions(effects: &[Vec<f64>]) -> (Vec<Vec<f64>>, Vec<f64>) {
    let all: Vec<&[f64]> = effects.iter().map(Vec::as_slice).collect();
    if all.is_empty() {
        return (Vec::new(), Vec::new());
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
        return (Vec::new(), Vec::new());
    }
    directions(&seen, &SymmetricEigen::new(without_rounding(gram(&seen))))
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
fn directions(effects: &[&[f64]], eigen: &SymmetricEigen<f64, Dyn>) -> (Vec<Vec<f64>>, Vec<f64>) {
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
    (directions, taken)
}
