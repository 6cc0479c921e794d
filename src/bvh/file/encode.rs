//! From a tree to bytes.

use super::{MAGIC, NODE, Q8, SCENE_CHECKSUM, SPATIAL, SceneMark, VERSION};
use crate::bvh::{Bvh, Limits, Node};
use std::io::{self, Write};

/// Writes the whole file into `out`; the same tree gives the same bytes.
pub(super) fn encode(out: &mut dyn Write, bvh: &Bvh, limits: &Limits, scene: &SceneMark) -> io::Result<()> {
    let mut out = Summed { out, crc: crc32fast::Hasher::new() };
    let word = |n: usize| u32::try_from(n).expect("a tree's numbers have 32 bits");
    assert!(!bvh.nodes.is_empty(), "a tree has a root");
    let flags = [(limits.spatial, SPATIAL), (limits.q8, Q8), (scene.checksum.is_some(), SCENE_CHECKSUM)];
    out.put(&MAGIC)?;
    for number in [
        VERSION,
        flags.iter().filter(|f| f.0).map(|f| f.1).sum(),
        word(bvh.arity),
        word(limits.max_leaf),
        word(bvh.nodes.len()),
        word(bvh.nodes.iter().filter(|n| n.is_leaf()).count()),
        word(bvh.triangle_ids.len()),
        word(scene.triangles),
        scene.checksum.unwrap_or(0),
        0,
    ] {
        out.put(&number.to_le_bytes())?;
    }
    let mut bytes = Vec::new();
    for nodes in bvh.nodes.chunks(1024) {
        bytes.clear();
        nodes.iter().for_each(|n| bytes.extend_from_slice(&node(n)));
        out.put(&bytes)?;
    }
    for ids in bvh.triangle_ids.chunks(8192) {
        bytes.clear();
        bytes.extend(ids.iter().flat_map(|id| id.to_le_bytes()));
        out.put(&bytes)?;
    }
    let checksum = out.crc.clone().finalize();
    out.put(&checksum.to_le_bytes())
}

fn node(node: &Node) -> [u8; NODE] {
    let corners = [node.aabb.min, node.aabb.max].map(|p| p.to_array().map(f32::to_bits));
    let numbers = corners.into_iter().flatten().chain([node.first, node.tagged_count]);
    let mut bytes = [0; NODE];
    for (place, number) in bytes.as_chunks_mut::<4>().0.iter_mut().zip(numbers) {
        *place = number.to_le_bytes();
    }
    bytes
}

/// A writer that keeps the checksum of what went through it.
struct Summed<'a> {
    out: &'a mut dyn Write,
    crc: crc32fast::Hasher,
}

impl Summed<'_> {
    fn put(&mut self, bytes: &[u8]) -> io::Result<()> {
        self.crc.update(bytes);
        self.out.write_all(bytes)
    }
}
