//! Inputs for the driver that needs no fuzzer: random bytes, and whole files with a few things wrong.

use crate::loader::{ENDINGS, SCENE};
use bvh_lab::build::{Brake, BuildOptions, Input, find};
use bvh_lab::bvh::file;
use bvh_lab::geom::Triangle;
use rand_pcg::Pcg64Mcg;
use rand_pcg::rand_core::Rng;
use std::io::Write;

const OBJ: &str = "mtllib none.mtl\no one\nv 0 0 0\nv 1 0 0.5\nv 1 1 -2e-3\nv 0 1 nan\nvt 0 0.5\nvn 0 0 1\ng a b\nusemtl red\n\
    f 1/1/1 2/1/1 3/1/1\nf 1//1 2//1 -1//1\nf -4 -3 -2 -1\nl 1 2\np 1\ns off\n";
const PLY: &str = "ply\nformat ascii 1.0\ncomment none\nelement vertex 4\nproperty float x\nproperty double y\nproperty float z\n\
    element face 2\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\n1 1 0\n0 1 0\n3 0 1 2\n4 0 1 2 3\n";
const STL: &str = "solid one\n facet normal 0 0 1\n  outer loop\n   vertex 0 0 0\n   vertex 1 0 0\n   vertex 1 1 0\n  \
    endloop\n endfacet\nendsolid one\n";
const GLTF: &str = r#"{"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[0]}],"nodes":[{"mesh":0,"scale":[1,2,1],"children":[1]},
    {"camera":0,"translation":[0,0,3]}],"cameras":[{"type":"perspective","perspective":{"yfov":0.7,"znear":0.1}}],
    "materials":[{"pbrMetallicRoughness":{"baseColorFactor":[1,0,0,0.5]},"alphaMode":"BLEND"}],
    "meshes":[{"primitives":[{"attributes":{"POSITION":0},"indices":1,"material":0}]}],
    "accessors":[{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3","min":[0,0,0],"max":[1,1,0]},
    {"bufferView":1,"componentType":5123,"count":3,"type":"SCALAR"}],
    "bufferViews":[{"buffer":0,"byteOffset":0,"byteLength":36},{"buffer":0,"byteOffset":36,"byteLength":6}],
    "buffers":[{"byteLength":42,"uri":"data:application/octet-stream;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAACAPwAAgD8AAAAAAAABAAIA"}]}"#;

/// Whole files, each behind the byte that names its ending.
pub fn files() -> Vec<Vec<u8>> {
    let packed = |bytes: &[u8]| {
        let mut gz = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::fast());
        gz.write_all(bytes).unwrap();
        gz.finish().unwrap()
    };
    let tri = bytemuck::cast_slice::<Triangle, u8>(&SCENE[..4]).to_vec();
    let mut stl = vec![0; 80];
    stl.extend(2u32.to_le_bytes());
    stl.extend((0..100).map(|i| if i % 4 == 3 { 0x40 } else { 0 }));
    let binary_ply = PLY.replace("ascii", "binary_little_endian").split("end_header\n").next().unwrap().to_string();
    let mut ply = (binary_ply + "end_header\n").into_bytes();
    ply.extend((0..4u8).flat_map(|i| [[i; 16]]).flatten());
    ply.extend([3, 0, 0, 0, 0, 1, 0, 0, 0, 2, 0, 0, 0, 3, 0, 0, 0, 0, 3, 0, 0, 0, 2, 0, 0, 0]);
    let mut glb = b"glTF\x02\0\0\0".to_vec();
    let json = GLTF.replace('\n', " ") + " ".repeat((4 - GLTF.len() % 4) % 4).as_str();
    glb.extend((20 + json.len() as u32).to_le_bytes());
    glb.extend((json.len() as u32).to_le_bytes());
    glb.extend(b"JSON");
    glb.extend(json.as_bytes());
    let boxes: Vec<_> = SCENE.iter().map(Triangle::aabb).collect();
    let tree = |id: &str, arity: usize| {
        let (builder, options) = (find(id).unwrap(), BuildOptions { arity, ..BuildOptions::default() });
        let bvh = (builder.timed)(Input::of_triangles(&SCENE, &boxes), &options, &mut Brake::default()).unwrap();
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("tree.bvh");
        file::write(&path, &bvh, &builder.limits(&options), &SCENE).unwrap();
        std::fs::read(path).unwrap()
    };
    let all = [
        ("obj", OBJ.into()),
        ("tri", tri),
        ("ply", PLY.into()),
        ("ply", ply),
        ("stl", STL.into()),
        ("stl", stl),
        ("gltf", GLTF.into()),
        ("glb", glb),
        ("obj.gz", packed(OBJ.as_bytes())),
        ("ply.zst", vec![0x28, 0xb5, 0x2f, 0xfd, 0x20, 0x04, 0x21, 0, 0, b'p', b'l', b'y', b'\n']),
        ("bvh", tree("binned-sah", 2)),
        ("bvh", tree("sbvh", 8)),
    ];
    let behind = |(ending, bytes): (&str, Vec<u8>)| {
        let place = ENDINGS.iter().position(|e| *e == ending).unwrap() as u8;
        std::iter::once(place).chain(bytes).collect()
    };
    all.into_iter().map(behind).collect()
}

/// Words that mean something to one of the formats.
const WORDS: [&str; 16] = [
    "nan",
    "-inf",
    "1e39",
    "4294967295",
    "-1",
    "0",
    "f ",
    "v ",
    "\n",
    " ",
    "\"",
    "}",
    "[",
    "element",
    "\\\n",
    "99999999999999999999",
];

/// A copy of some file with one to eight places changed.
pub fn damaged(files: &[Vec<u8>], random: &mut Pcg64Mcg) -> Vec<u8> {
    let mut below = |n: usize| random.next_u32() as usize % n.max(1);
    let mut bytes = files[below(files.len())].clone();
    for _ in 0..1 + below(8) {
        // The first byte stays: it names the format.
        let at = 1 + below(bytes.len() - 1).min(bytes.len() - 1);
        let end = (at + below(16)).min(bytes.len());
        match below(7) {
            0 if at < bytes.len() => bytes[at] ^= 1 << below(8),
            1 if at < bytes.len() => bytes[at] = [0, 1, 0x7f, 0x80, 0xff, b'\n', b'9', b'-'][below(8)],
            2 => drop(bytes.drain(at.min(end)..end)),
            3 => bytes.truncate(at.max(2)),
            4 => {
                let some = bytes[at.min(end)..end].to_vec();
                bytes.splice(at..at, some.repeat(1 + below(3)));
            }
            5 => drop(bytes.splice(at..at, WORDS[below(WORDS.len())].bytes())),
            _ => {
                let other = &files[below(files.len())];
                let from = below(other.len());
                let some = other[from..(from + below(24)).min(other.len())].to_vec();
                drop(bytes.splice(at..at, some));
            }
        }
        if bytes.len() < 2 {
            break;
        }
    }
    bytes
}

/// Random bytes, as many as an execution may want; some of them all alike, so that numbers tie.
pub fn random(random: &mut Pcg64Mcg) -> Vec<u8> {
    let mut bytes = vec![0; 8 + random.next_u32() as usize % 1200];
    random.fill_bytes(&mut bytes);
    if random.next_u32().is_multiple_of(4) {
        let some = bytes.len() / 2;
        let period = 1 + random.next_u32() as usize % 24;
        for i in some.max(period)..bytes.len() {
            bytes[i] = bytes[i - period];
        }
    }
    bytes
}
