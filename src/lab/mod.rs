//! The laboratory: jobs, budgets, verification, measurement. The only place that writes rows.

mod accuracy;
mod aside;
mod build_cell;
mod closed_form;
mod compare;
mod decisions;
mod job;
mod leaf_counts;
mod lock;
mod machine;
mod measure;
mod memory;
mod picture;
pub mod projection;
mod replay;
mod scaling;
mod study;
mod text;
mod trace_cell;
mod twin;
mod work;

pub use accuracy::{ACCURACY_BUDGET, ACCURACY_SCENES, AccuracyStudy, Part};
pub use build_cell::{BuildCell, Built, EPO_LIMIT, Measured, measure_build};
pub use closed_form::{LiteralWork, literal_work};
pub use compare::{Comparison, Contestant, standard_recipes};
pub use leaf_counts::{RAY_SEED, leaf_count_rays};
pub use machine::{commit, machine, version};
pub use measure::{Repeats, repeat, spread};
pub use memory::keep_freed_memory;
pub use picture::{PictureError, figure3};
pub use replay::{original_work, sampled_work};
pub use scaling::{EXACT_BUDGET, LITERAL_BUDGET, ScalingStudy, sizes_up_to};
pub use study::{DEFAULT_BUDGET, SCENES, Scope, Study, StudyError, Watch};
pub use text::human_seconds;
pub use trace_cell::{Stage, Traced};
