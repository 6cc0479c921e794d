//! Tests of the kernels together: exactness, the published order of visits, and the thesis' study.

mod exact;
mod hand_made;
mod study;
