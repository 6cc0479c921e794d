//! From bytes to a tree, believing nothing.

use super::error::{FileError, Malformed};
use super::{HEADER, MAGIC, NODE, Q8, SCENE_CHECKSUM, SPATIAL, SceneMark, UnfittedTree, VERSION, WORD};
use crate::bvh::{Bvh, Limits, Node, NodeKind};
use crate::geom::Aabb;
use glam::Vec3;
use std::io::{self, Read};
use std::path::Path;

/// Bytes that are asked for at a time: vectors grow by what came, not by what a header promises.
const BLOCK: usize = 1 << 16;

/// Why there is no tree.
#[derive(Debug)]
pub(super) enum Failure {
    /// The system refused.
    Io(io::Error),
    /// The bytes are not a tree file.
    Malformed(Malformed),
}

impl Failure {
    /// With the path of the file.
    pub(super) fn at(self, path: &Path) -> FileError {
        match self {
            Self::Io(source) => FileError::Read { path: path.into(), source },
            Self::Malformed(reason) => FileError::Malformed { path: path.into(), reason },
        }
    }
}

impl From<Malformed> for Failure {
    fn from(reason: Malformed) -> Self {
        Self::Malformed(reason)
    }
}

/// The numbers of the header.
struct Header {
    flags: u32,
    arity: u32,
    max_leaf: u32,
    nodes: u32,
    leaves: u32,
    slots: u32,
    triangles: u32,
    scene_checksum: u32,
}

/// Reads the whole of `input`. Every child range and slot range of the tree returned is in bounds, children stand behind their
/// parents, ids are below the number of triangles, and boxes are valid (or, of empty leaves, empty).
pub(super) fn decode(input: &mut dyn Read) -> Result<UnfittedTree, Failure> {
    let mut source = Source { input, crc: crc32fast::Hasher::new(), at: 0, size: HEADER as u64 };
    let header = header(&mut source)?;
    source.size =
        (HEADER + WORD) as u64 + NODE as u64 * u64::from(header.nodes) + WORD as u64 * u64::from(header.slots);
    let mut nodes = Vec::new();
    source.records::<NODE>(header.nodes, |bytes| nodes.push(node(bytes)))?;
    let mut triangle_ids = Vec::new();
    source.records::<WORD>(header.slots, |bytes| triangle_ids.push(u32::from_le_bytes(*bytes)))?;
    let computed = source.crc.clone().finalize();
    let mut stored = [0; WORD];
    source.fill(&mut stored)?;
    let stored = u32::from_le_bytes(stored);
    if computed != stored {
        return Err(Malformed::Checksum { stored, computed }.into());
    }
    source.end()?;
    let bvh = Bvh { nodes, triangle_ids, arity: header.arity as usize };
    check(&bvh, &header)?;
    Ok(UnfittedTree {
        bvh,
        limits: Limits {
            max_leaf: header.max_leaf as usize,
            q8: header.flags & Q8 != 0,
            spatial: header.flags & SPATIAL != 0,
        },
        scene: SceneMark {
            triangles: header.triangles as usize,
            checksum: (header.flags & SCENE_CHECKSUM != 0).then_some(header.scene_checksum),
        },
    })
}

fn header(source: &mut Source) -> Result<Header, Failure> {
    let mut magic = [0; MAGIC.len()];
    // A file that is shorter than this is as little a tree file as one that begins otherwise.
    match source.fill(&mut magic) {
        Ok(()) if magic == MAGIC => {}
        Ok(()) | Err(Failure::Malformed(_)) => return Err(Malformed::Magic.into()),
        Err(e) => return Err(e),
    }
    let mut bytes = [[0; WORD]; (HEADER - MAGIC.len()) / WORD];
    source.fill(bytes.as_flattened_mut())?;
    let [version, flags, arity, max_leaf, nodes, leaves, slots, triangles, scene_checksum, reserved] =
        bytes.map(u32::from_le_bytes);
    if version != VERSION {
        return Err(Malformed::Version(version).into());
    }
    let wrong = |field, value, wanted| Err(Malformed::Header { field, value, wanted }.into());
    match () {
        () if flags & !(SPATIAL | Q8 | SCENE_CHECKSUM) != 0 => wrong("flags", flags, "0 to 7 are known"),
        () if arity < 2 => wrong("arity", arity, "at least 2 is wanted"),
        () if max_leaf < 1 => wrong("leaf limit", max_leaf, "at least 1 is wanted"),
        () if nodes < 1 => wrong("number of nodes", nodes, "a tree has a root"),
        () if leaves > nodes => wrong("number of leaves", leaves, "there are fewer nodes than that"),
        () if !(1..1 << 31).contains(&triangles) => wrong("number of triangles", triangles, "1 to 2³¹ - 1 are wanted"),
        () if flags & SCENE_CHECKSUM == 0 && scene_checksum != 0 => {
            wrong("checksum of the scene", scene_checksum, "without flag 2 it is 0")
        }
        () if reserved != 0 => wrong("last field", reserved, "it is 0 in this version"),
        () => Ok(Header { flags, arity, max_leaf, nodes, leaves, slots, triangles, scene_checksum }),
    }
}

fn node(bytes: &[u8; NODE]) -> Node {
    let number = |i: usize| u32::from_le_bytes([bytes[4 * i], bytes[4 * i + 1], bytes[4 * i + 2], bytes[4 * i + 3]]);
    let corner = |i: usize| Vec3::from_array([i, i + 1, i + 2].map(|i| f32::from_bits(number(i))));
    Node { aabb: Aabb::new(corner(0), corner(3)), first: number(6), tagged_count: number(7) }
}

/// What must hold before the tree can be walked at all; the rest is the validator's.
fn check(bvh: &Bvh, header: &Header) -> Result<(), Malformed> {
    let (nodes, slots) = (bvh.nodes.len(), bvh.triangle_ids.len());
    let leaves = bvh.nodes.iter().filter(|n| n.is_leaf()).count();
    if leaves != header.leaves as usize {
        return Err(Malformed::Leaves { promised: header.leaves, found: leaves });
    }
    for (index, node) in bvh.nodes.iter().enumerate() {
        match node.kind() {
            NodeKind::Inner(children) if children.is_empty() => return Err(Malformed::NoChildren(index)),
            NodeKind::Inner(children) if children.start <= index => {
                return Err(Malformed::ChildNotBehind { node: index, child: children.start });
            }
            NodeKind::Inner(children) if children.end > nodes => {
                return Err(Malformed::ChildrenBeyond { node: index, last: children.end - 1, nodes });
            }
            NodeKind::Leaf(of) if of.end > slots => {
                return Err(Malformed::SlotsBeyond { leaf: index, last: of.end, slots });
            }
            _ => {}
        }
        let empty_leaf = node.is_leaf() && node.count() == 0 && node.aabb == Aabb::EMPTY;
        if !node.aabb.is_valid() && !empty_leaf {
            return Err(Malformed::Box(index));
        }
    }
    match bvh.triangle_ids.iter().position(|&id| id >= header.triangles) {
        Some(slot) => Err(Malformed::Id { slot, id: bvh.triangle_ids[slot], triangles: header.triangles }),
        None => Ok(()),
    }
}

/// A reader that keeps the checksum of what came out of it, and where it is.
struct Source<'a> {
    input: &'a mut dyn Read,
    crc: crc32fast::Hasher,
    at: u64,
    /// Bytes that there should be, as far as is known.
    size: u64,
}

impl Source<'_> {
    fn fill(&mut self, bytes: &mut [u8]) -> Result<(), Failure> {
        let mut filled = 0;
        while filled < bytes.len() {
            match self.input.read(&mut bytes[filled..]) {
                Ok(0) => {
                    let at = self.at + filled as u64;
                    return Err(Malformed::Truncated { at, size: self.size }.into());
                }
                Ok(n) => filled += n,
                Err(e) if e.kind() == io::ErrorKind::Interrupted => {}
                Err(e) => return Err(Failure::Io(e)),
            }
        }
        self.crc.update(bytes);
        self.at += bytes.len() as u64;
        Ok(())
    }

    /// `count` records of `N` bytes each, one after the other to `take`.
    fn records<const N: usize>(&mut self, count: u32, mut take: impl FnMut(&[u8; N])) -> Result<(), Failure> {
        let mut block = vec![[0; N]; (BLOCK / N).min(count as usize)];
        let mut left = count as usize;
        while left > 0 {
            let some = left.min(block.len());
            self.fill(block[..some].as_flattened_mut())?;
            block[..some].iter().for_each(&mut take);
            left -= some;
        }
        Ok(())
    }

    /// Nothing may follow.
    fn end(&mut self) -> Result<(), Failure> {
        match self.fill(&mut [0]) {
            Err(Failure::Malformed(Malformed::Truncated { .. })) => Ok(()),
            Err(e) => Err(e),
            Ok(()) => Err(Malformed::TooLong { size: self.size }.into()),
        }
    }
}
