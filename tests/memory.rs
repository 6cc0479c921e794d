//! What builders hold while they build, counted by the allocator: on one thread, the same number on every machine.

use bvh_lab::build::{BUILDERS, Brake, BuildOptions, Builder, Input};
use bvh_lab::geom::{Aabb, Triangle};
use bvh_lab::lab::{MeteredAllocator, peak_of};
use bvh_lab::scene::Scene;

#[global_allocator]
static ALLOCATOR: MeteredAllocator = MeteredAllocator;

/// Bytes a triangle beyond the triangles, boxes (24) and tree included: measured over 200,000 triangles of spheres, rounded up.
/// Asked for over 10⁷ are 200. Scenes differ by their trees: spatial splits may double the references, and other builders
/// have more nodes where fewer leaves are worth more than one triangle.
const PROMISES: &[(&str, f64)] = &[
    ("agglo-local", 163.0),
    ("agglo-kd", 189.0),
    ("sweep-sah", 133.0),
    ("binned-sah", 157.0),
    ("sbvh", 146.0),
    ("kway-sah", 167.0),
    ("kway-slab", 167.0),
    ("lbvh", 96.0),
    ("hlbvh", 104.0),
    ("ploc", 127.0),
];

/// Bytes a triangle for subtrees that one thread has grown and that wait for those before them on another: if that
/// one is held up, all there are in this small scene, with room for two nodes a triangle, and one more spare on each thread.
/// In a large scene it is a batch of them, however many triangles there are.
const WAITING: f64 = 64.0 + 11.0;

/// Builders whose subtrees wait.
const WITH_WAITING: [&str; 4] = ["sweep-sah", "binned-sah", "kway-sah", "kway-slab"];

/// The most bytes that a build holds, for each triangle.
fn peak(builder: &Builder, triangles: &[Triangle], threads: usize) -> f64 {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
    let options = BuildOptions::default();
    let (tree, peak) = peak_of(|| {
        pool.install(|| {
            let boxes = builder.boxes(triangles, &options);
            let input = Input::of_triangles(triangles, &boxes);
            (builder.timed)(input, &options, &mut Brake::default()).unwrap()
        })
    });
    let peak = peak.expect("this program's allocator counts");
    let tree = tree.nodes.len() * size_of::<bvh_lab::bvh::Node>() + tree.triangle_ids.len() * size_of::<u32>();
    assert!(peak >= tree + triangles.len() * size_of::<Aabb>(), "{}: boxes and tree are held at least", builder.id);
    peak as f64 / triangles.len() as f64
}

// One test: the count is of the whole process.
#[test]
fn builders_hold_no_more_than_promised() {
    let scene = Scene::load("gen:spheres:200000").unwrap();
    for builder in BUILDERS.iter().filter(|b| b.presets.is_empty()) {
        let (_, most) = PROMISES.iter().find(|(id, _)| *id == builder.id).unwrap_or_else(|| panic!("{}", builder.id));
        let one = peak(builder, &scene.triangles, 1);
        let two = peak(builder, &scene.triangles, 2);
        println!("{:12} {one:6.1} bytes a triangle on one thread, {two:6.1} on two", builder.id);
        assert!(one <= *most, "{}: {one:.1} bytes a triangle", builder.id);
        // Threads have their own tables.
        let waiting = if WITH_WAITING.contains(&builder.id) { WAITING } else { 0.0 };
        assert!(two <= 1.1 * most + waiting, "{}: {two:.1} bytes a triangle on two threads", builder.id);
        // Something is made once only, such as a thread's own data.
        let again = peak(builder, &scene.triangles, 1);
        assert!((again - one).abs() < 0.1, "{}: {one} and {again} bytes a triangle on one thread", builder.id);
    }
    // Half of the triangles take half of it.
    let half = Scene::load("gen:spheres:100000").unwrap();
    let builder = BUILDERS.iter().find(|b| b.id == "binned-sah").unwrap();
    let ratio = peak(builder, &half.triangles, 1) / peak(builder, &scene.triangles, 1);
    assert!((0.9..1.1).contains(&ratio), "{ratio}");
    // What is there before does not count, what grows in place counts twice.
    let before = vec![1u8; 1 << 20];
    let (_, peak) = peak_of(|| {
        let mut grown = Vec::with_capacity(1000);
        grown.resize(1000, before[0]);
        grown.reserve_exact(2000);
        grown
    });
    let peak = peak.unwrap();
    assert!((4000..5000).contains(&peak), "{peak}");
}
