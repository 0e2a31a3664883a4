//! Leakage past the land between P and B of a directional control valve.

use super::Effect;
use super::edge_leakage::past_land;

pub const EFFECT: Effect = past_land(
    "edge-leakage-to-b",
    "Leakage past the land that shuts P from B: a worn or scored edge.",
    "q = G_PB (p_P - p_B)",
    &[super::edge_leakage::conductance("leak_PB")],
);
