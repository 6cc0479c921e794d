//! Tables, figures and pages: reads rows, imports nothing else of this crate.
