//! Detection, isolation and identification: what is wrong, how large, how sure.

pub mod noise;
pub mod problem;
