//! Leakage past the land between P and A of a directional control valve.

use super::Effect;
use super::edge_leakage::past_land;

pub const EFFECT: Effect = past_land(
    "edge-leakage-to-a",
    "Leakage past the land that shuts P from A: a worn or scored edge.",
    "q = G_PA (p_P - p_A)",
    &[super::edge_leakage::conductance("leak_PA")],
);
