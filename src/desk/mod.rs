//! The desk: a page on this machine that shows a model beside its records, and lets its effects and faults be switched, moved,
//! looked for, fitted, judged and saved.
//!
//! | file | what it is for |
//! |---|---|
//! | `state` | the rig, its records and where the sliders stand; what the tabs share |
//! | `trace` | a record beside the model: gauges, and curves as a page draws them |
//! | `message` | the state as the page reads it |
//! | `running` | what takes longer than a moment: which task, and how far it is |
//! | `task` | the long work: find, fit, judge |
//! | `shared` | the desk as its threads share it |
//! | `save` | the rig file as the desk leaves it |
//! | `server` | one page and its messages on the loopback |
//! | `guard` | who may ask |

mod guard;
mod message;
mod running;
mod save;
mod server;
mod shared;
mod state;
mod task;
mod trace;

pub use server::Server;
pub use state::Desk;
