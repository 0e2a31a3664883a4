//! Detection, isolation and identification: what is wrong, how large, how sure.

pub mod estimate;
pub mod noise;
pub mod problem;
