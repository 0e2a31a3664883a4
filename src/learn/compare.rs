//! Where the model fails.
