//! The laboratory: jobs, budgets, verification, measurement. The only place that writes rows.

mod build_cell;
mod decisions;
mod job;
mod lock;
mod machine;
mod measure;
mod picture;
pub mod projection;
mod replay;
mod study;
mod text;
mod trace_cell;
mod twin;

pub use build_cell::{BuildCell, Built, Measured, measure_build};
pub use machine::{commit, machine, version};
pub use measure::{Repeats, repeat, spread};
pub use picture::{PictureError, figure3};
pub use replay::original_work;
pub use study::{DEFAULT_BUDGET, SCENES, Scope, Study, StudyError, Watch};
pub use text::human_seconds;
pub use trace_cell::{Stage, Traced};
