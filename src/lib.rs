//! A laboratory for bounding volume hierarchies (BVHs) for ray tracing: how they are built, what a build costs,
//! and what the tree is worth.
//!
//! Data flows one way: [`geom`] ← [`scene`], [`bvh`] ← [`cost`], [`build`], [`refine`], [`trace`] ← [`render`] ← [`lab`] → [`rows`] ← [`report`].
//! A figure cannot recompute a result: the code that draws it sees rows and nothing else.
//!
//! A tree as the thesis' program built it, and what it is worth (`examples/build_and_trace.rs` goes on to trace a ray):
//!
//! ```
//! use bvh_lab::build::top_down::{Published, published_literal};
//! use bvh_lab::bvh::{Limits, validate};
//! use bvh_lab::cost::{SahParams, sah};
//! use bvh_lab::scene::Scene;
//!
//! let scene = Scene::load("thesis:tiny")?;
//! let boxes = scene.boxes();
//! let bvh = published_literal::build(&boxes, &Published::at_arity(4), &mut ())?;
//! validate(&bvh, &boxes, &Limits::default())?;
//! let cost = sah(&bvh, SahParams::default()).expect("the scene has an area");
//! assert!(cost < 8.0);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

pub mod build;
pub mod bvh;
pub mod cost;
pub mod geom;
pub mod lab;
pub mod refine;
pub mod render;
pub mod report;
pub mod rows;
pub mod scene;
pub mod simd;
pub mod trace;

/// The README's Rust code, compiled and run as a test.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
pub struct Readme;
