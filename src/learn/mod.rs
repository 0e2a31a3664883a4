//! Learning: where the model fails, which physical effect it lacks, and what adding it buys.
//!
//! | module | question |
//! |---|---|
//! | [`compare`] | where, when and at which states does the model miss the record |
//! | [`with_faults`] | which faults explain what the model misses, and what is then left |
//! | [`phase`] | what the circuit does over each stretch of a record |
//! | [`candidate`], `scoring` | which effects might be missing, and how much of the misfit could each explain (score test) |
//! | `trial_steps` | at which sizes and levels each is tried |
//! | `small_tries` | which may take the place of a fault, tried where what they do is straight |
//! | [`run`] | a record simulated with given parameters, and how far it is missed |
//! | [`fitted_model`] | what a record says once an effect is in the model, everything else fitted along |
//! | [`suggest`] | which effect is missing, judged on a second record |
//! | `spools` | how spools follow their commands, asked where a model has learnt what it lacks |
//! | `lack_of_fit` | what a record is weighed by while the model lacks something |
//! | `screening` | effects fitted and judged, as far as they could still win |
//! | [`warning`] | what speaks against an effect as fitted |
//! | `verdict` | the one word on a record |
//! | `form` | whether the law that explains a record has the right form |
//! | `free_curve` | a curve without a formula beside everything fitted, to first order |
//! | [`separate`] | which experiment would tell two explanations apart |
//! | [`result`] | the suggestion as programs read it |
//! | `acting` | what an effect adds to a circuit at the states of a run |
//! | `law_on_axis` | the law of an effect, over the axis of such a picture |
//! | [`missing`] | what a missing flow or force looks like over the states |
//! | `states` | the states that a record visits, along the axis of such a picture |
//! | [`add`] | the rig file with an effect more |
//! | [`addition`] | what was added, as programs read it |
//! | `opened` | effects that a record is to say the size of, whatever the rig file says |
//! | `revise` | effects of a rig file set, taken out or refitted by hand |
//! | [`behind`] | which faults are there beside an effect that the model lacks |
//! | `outright` | whether one effect explains by itself what the declared faults miss |
//! | `rivals` | which effects explain a record as well as a fault does |
//! | [`improve`] | the whole loop with its ledger |

#[cfg(feature = "cli")]
pub(crate) mod acting;
pub mod add;
#[cfg(feature = "cli")]
pub mod addition;
pub mod behind;
pub mod candidate;
pub mod compare;
pub mod comparison;
mod departure;
pub mod evaluated;
pub mod fitted_model;
mod form;
#[cfg_attr(not(feature = "cli"), expect(dead_code, reason = "pictures draw what only its fall is asked of here"))]
mod free_curve;
mod highest;
pub mod improve;
mod lack_of_fit;
#[cfg(feature = "cli")]
pub mod law_on_axis;
#[cfg(feature = "cli")]
pub mod missing;
pub mod opened;
mod outright;
pub mod phase;
mod refit;
pub mod result;
#[cfg(feature = "cli")]
pub mod revise;
mod rivals;
pub mod run;
mod scoring;
mod screening;
pub mod separate;
mod small_tries;
mod spools;
#[cfg(feature = "cli")]
mod states;
pub mod suggest;
mod trial_steps;
mod verdict;
pub mod warning;
mod with_faults;
