//! The desk: a page on this machine that shows a model beside its records, and lets its effects and faults be switched, moved,
//! looked for, fitted, judged and saved.
//!
//! | file | what it is for |
//! |---|---|
//! | `state` | the rig, its records and where the sliders stand; what the tabs share |
//! | `trace` | a record beside the model: gauges, and curves as a page draws them |
//! | `message` | the state as the page reads it |
//! | `task` | the long work: find, fit, judge |
//! | `save` | the rig file as the desk leaves it |
//! | `server` | one page and its messages on the loopback |
//! | `guard` | who may ask |

mod guard;
mod message;
mod save;
mod server;
mod state;
mod task;
mod trace;

pub use server::Server;
pub use state::Desk;
