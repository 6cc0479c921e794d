//! A laboratory for bounding volume hierarchies (BVHs) for ray tracing: how they are built, what a build costs,
//! and what the tree is worth.
//!
//! Data flows one way: [`geom`] ← [`scene`], [`bvh`] ← [`cost`], [`build`], [`refine`], [`trace`] ← [`lab`] → [`rows`] ← [`report`].
//! A figure cannot recompute a result: the code that draws it sees rows and nothing else.

pub mod build;
pub mod bvh;
pub mod cost;
pub mod geom;
pub mod lab;
pub mod refine;
pub mod report;
pub mod rows;
pub mod scene;
pub mod trace;

/// The README's Rust code, compiled and run as a test.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
pub struct Readme;
