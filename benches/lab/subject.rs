//! A scene as builders see it, and trees that are known to be valid.

use bvh_lab::build::{Brake, BuildOptions, Builder, Input};
use bvh_lab::bvh::{Bvh, tree_hash, validate_parts};
use bvh_lab::geom::Aabb;
use bvh_lab::scene::Scene;

/// A scene.
pub struct Subject {
    pub scene: Scene,
    pub boxes: Vec<Aabb>,
}

impl Subject {
    pub fn load(name: &str) -> Self {
        let scene = Scene::load(name).expect("generated scenes can always be had");
        let boxes = scene.boxes();
        Self { scene, boxes }
    }

    /// The whole build from triangles, boxes included.
    pub fn build(&self, builder: &Builder, options: &BuildOptions) -> Bvh {
        let boxes = builder.boxes(&self.scene.triangles, options);
        (builder.timed)(Input::of_triangles(&self.scene.triangles, &boxes), options, &mut Brake::default())
            .expect("the benchmark asks for what builders offer")
    }

    /// A tree that is valid and comes out the same twice.
    pub fn verified(&self, builder: &Builder, options: &BuildOptions) -> Bvh {
        let bvh = self.build(builder, options);
        validate_parts(&bvh, &self.scene.triangles, &self.boxes, &builder.limits(options))
            .unwrap_or_else(|v| panic!("{}: {v}", builder.id));
        assert_eq!(tree_hash(&bvh), tree_hash(&self.build(builder, options)), "{}", builder.id);
        bvh
    }
}
