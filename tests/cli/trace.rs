//! `trace`: the same hits from every tree, every number of threads and every way to give the rays.

use crate::support::{Lab, check_spread, has_fields, number, word};
use bvh_lab::geom::{Ray, WatertightRay};
use bvh_lab::scene::Scene;
use bvh_lab::trace::{brute_force, primary_rays, write_rays};
use glam::Vec3;

const FIELDS: [&str; 16] = [
    "scene",
    "triangles",
    "dropped",
    "builder",
    "arity",
    "preset",
    "engine",
    "threads",
    "kernel",
    "rays",
    "mrays_per_s",
    "hits",
    "hit_hash",
    "nodes_per_ray",
    "box_tests_per_ray",
    "tri_tests_per_ray",
];

/// The records of a `--hits-out` file.
fn records(bytes: &[u8]) -> Vec<(u32, f32)> {
    let (records, rest) = bytes.as_chunks::<8>();
    assert!(rest.is_empty());
    let word = |b: &[u8]| u32::from_le_bytes([b[0], b[1], b[2], b[3]]);
    records.iter().map(|r| (word(&r[..4]), f32::from_bits(word(&r[4..])))).collect()
}

#[test]
fn every_field_is_there() {
    let lab = Lab::new();
    for rays in ["primary", "diffuse", "any"] {
        let report = lab.json(&format!("trace thesis:tiny --rays {rays} --size 24x16 --runs 2"));
        has_fields(&report, &FIELDS);
        assert_eq!(check_spread(&report["mrays_per_s"]), 2);
        assert_eq!(report["ray_kind"], rays);
        if rays == "primary" {
            assert_eq!(report["rays"], 24 * 16);
        }
        assert!(0.0 < number(&report, "hits") && number(&report, "hits") < number(&report, "rays"), "{report}");
        assert!(number(&report, "nodes_per_ray") >= 1.0 && number(&report, "tri_tests_per_ray") > 0.0, "{report}");
        let hash = lab.json("build thesis:tiny --runs 1")["tree_hash"].clone();
        assert_eq!(report["tree_hash"], hash, "trace and build speak of the same tree");
    }
}

#[test]
fn hits_do_not_depend_on_the_tree_and_work_does() {
    let lab = Lab::new();
    for rays in ["primary", "diffuse", "any"] {
        let trees =
            ["-b top-down", "-b bottom-up -k 4", "-b bottom-up -k 8 --preset walter", "-k 8 --q8 off --candidates 9"];
        let reports =
            trees.map(|tree| lab.json(&format!("trace gen:spheres:300 {tree} --rays {rays} --size 40x40 --runs 1")));
        let answers = |i: usize| ["rays", "hits", "hit_hash"].map(|f| reports[i][f].clone());
        for other in 1..trees.len() {
            assert_eq!(answers(0), answers(other), "{rays} {}", trees[other]);
            assert_ne!(reports[0]["nodes_per_ray"], reports[other]["nodes_per_ray"], "{rays} {}", trees[other]);
        }
    }
}

#[test]
fn threads_change_nothing_but_their_number() {
    let lab = Lab::new();
    for kernel in ["scalar", "scalar-fast", "first-leaf"] {
        let reports = [1, 2, 7].map(|threads| {
            let words = format!("trace thesis:tiny --kernel {kernel} --size 64x48 --runs 1 --threads {threads}");
            let report = lab.json(&words);
            assert_eq!(report["threads"], threads);
            ["tree_hash", "hit_hash", "hits", "nodes_per_ray", "box_tests_per_ray", "tri_tests_per_ray"]
                .map(|f| report[f].clone())
        });
        assert!(reports[0] == reports[1] && reports[0] == reports[2], "{kernel}: {reports:?}");
    }
}

#[test]
fn rays_from_a_file_see_what_the_same_rays_from_the_camera_see() {
    let lab = Lab::new();
    let scene = Scene::load("thesis:tiny").unwrap();
    let rays = primary_rays(&scene.camera, 40, 30);
    write_rays(&lab.path("camera.rays"), &rays).unwrap();
    let ours = lab.json("trace thesis:tiny --size 40x30 --runs 1 --hits-out ours.hits");
    let theirs = lab.json("trace thesis:tiny --rays-file camera.rays --runs 1 --hits-out theirs.hits");
    assert_eq!(theirs["ray_kind"], "file");
    for field in ["rays", "hits", "hit_hash", "nodes_per_ray", "box_tests_per_ray", "tri_tests_per_ray"] {
        assert_eq!(ours[field], theirs[field], "{field}");
    }
    let bytes = lab.read("ours.hits");
    assert_eq!(bytes, lab.read("theirs.hits"));
    let hash = blake3::hash(&bytes).to_hex();
    assert!(hash.starts_with(&word(&ours, "hit_hash")), "the hash is that of the file");
    // Brute force over all triangles, ray by ray.
    let records = records(&bytes);
    assert_eq!(records.len(), rays.len());
    for (ray, (id, t)) in rays.iter().zip(&records) {
        match brute_force::<WatertightRay>(&scene.triangles, ray) {
            Some(hit) => assert_eq!((*id, *t), (hit.triangle, hit.t)),
            None => assert_eq!(*id, u32::MAX),
        }
    }
    let hits = records.iter().filter(|r| r.0 != u32::MAX).count();
    assert_eq!(ours["hits"].as_u64(), Some(hits as u64));
}

#[test]
fn odd_rays_miss_and_are_counted_and_no_rays_are_refused() {
    let lab = Lab::new();
    let towards = Ray::new(Vec3::new(0.0, 0.0, 50.0), Vec3::NEG_Z);
    let odd = [
        Ray { origin: Vec3::NAN, ..towards },
        Ray { direction: Vec3::ZERO, ..towards },
        Ray { direction: Vec3::splat(f32::INFINITY), ..towards },
        Ray { t_min: 2.0, t_max: 1.0, ..towards },
        Ray { t_max: f32::NAN, ..towards },
    ];
    write_rays(&lab.path("odd.rays"), &odd).unwrap();
    for kernel in ["scalar", "scalar-fast", "first-leaf"] {
        let report = lab.json(&format!("trace thesis:tiny --rays-file odd.rays --kernel {kernel} --runs 1"));
        assert_eq!((&report["rays"], &report["hits"]), (&odd.len().into(), &0.into()), "{kernel}");
        assert_eq!(report["untraceable_rays"], odd.len(), "{kernel}");
    }
    lab.write("none.rays", "");
    let line = lab.refuse("trace thesis:tiny --rays-file none.rays", 1);
    assert!(line.contains("no rays"), "{line}");
}

#[test]
fn switches_of_the_thesis_kernel() {
    let lab = Lab::new();
    let trace = |words: &str| {
        let words = format!("trace thesis:tiny -k 4 --size 60x60 --runs 1 --kernel first-leaf {words}");
        let report = lab.json(&words);
        (report["hit_hash"].clone(), number(&report, "nodes_per_ray"), number(&report, "tri_tests_per_ray"))
    };
    let plain = trace("");
    assert_eq!(plain, trace("--linear-lookup"), "the lookup costs time and nothing else");
    assert_eq!(plain, trace("--tie-slip on"));
    let exact = lab.json("trace thesis:tiny -k 4 --size 60x60 --runs 1");
    assert_ne!(plain.0, exact["hit_hash"], "the first leaf is not always the closest");
    // The slip enters nodes that need not be entered, some of them twice.
    assert!(trace("--tie-slip off").1 < plain.1);
}
