//! Trees on disk: a small, checked binary format that any program can write, version 1.
//!
//! ```text
//! bvh-lab build bunny.obj -b binned-sah -o bunny.bvh
//! bvh-lab trace bunny.obj --tree bunny.bvh
//! bvh-lab build bunny.obj --tree bunny.bvh          # what a tree is worth: SAH, EPO, shape, hash
//! ```
//!
//! # Layout
//!
//! All numbers are little-endian; f32 is IEEE 754. `n` is the number of nodes, `s` that of slots.
//!
//! | offset | bytes | type | what |
//! |---|---|---|---|
//! | 0 | 8 | | magic `89 42 56 48 0D 0A 1A 0A`: `\x89BVH\r\n\x1a\n`, so that a copy that changed line ends is found out |
//! | 8 | 4 | u32 | version: 1 |
//! | 12 | 4 | u32 | flags, see below |
//! | 16 | 4 | u32 | arity: the most children that a node was allowed to have, at least 2 |
//! | 20 | 4 | u32 | the most triangles that a leaf was allowed to have, at least 1 |
//! | 24 | 4 | u32 | `n`: nodes, leaves included, at least 1 |
//! | 28 | 4 | u32 | leaves |
//! | 32 | 4 | u32 | `s`: slots, that is triangle ids |
//! | 36 | 4 | u32 | triangles of the scene, at least 1 and below 2³¹ |
//! | 40 | 4 | u32 | checksum of the scene's triangles; 0 without flag 2 |
//! | 44 | 4 | u32 | 0 |
//! | 48 | 32 `n` | | nodes; node 0 is the root |
//! | 48 + 32 `n` | 4 `s` | u32 | triangle ids, slot by slot |
//! | 48 + 32 `n` + 4 `s` | 4 | u32 | checksum of all bytes before it; here the file ends |
//!
//! One node, 32 bytes:
//!
//! | offset | bytes | type | what |
//! |---|---|---|---|
//! | 0 | 12 | 3 × f32 | least corner of its box: x, y, z |
//! | 12 | 12 | 3 × f32 | greatest corner |
//! | 24 | 4 | u32 | inner node: index of its first child; leaf: its first slot |
//! | 28 | 4 | u32 | number of children, or number of triangles plus 2³¹: the top bit marks a leaf |
//!
//! Flags:
//!
//! | bit | value | what |
//! |---|---|---|
//! | 0 | 1 | spatial splits: a triangle may stand in several leaves ([`Limits::spatial`]) |
//! | 1 | 2 | nodes of the thesis' rule Q8 are allowed ([`Limits::q8`]); for trees of that program alone |
//! | 2 | 4 | the checksum of the scene's triangles is given |
//!
//! Both checksums are CRC-32 as in zip, gzip and PNG (zlib's `crc32`). That of the scene is taken over its triangles in the
//! order of their ids: nine f32 each, the three corners one after the other, 36 bytes a triangle: exactly the bytes of a
//! [`.tri` file](crate::scene::file). Ids count the triangles that `bvh-lab scene` counts, from 0; those dropped at load have
//! none.
//!
//! # What a tree must be
//!
//! Children of a node stand next to each other, and behind their parent: breadth-first and depth-first numberings with
//! adjacent siblings both do. Every node but the root has one parent. Boxes are exact: a leaf's is the union of its
//! triangles' boxes, an inner node's that of its children's, by minimum and maximum of f32 and without padding. Without flags
//! every triangle stands in exactly one slot. With flag 0 a leaf's box may be smaller, as it bounds parts of its triangles: the
//! leaves that hold a triangle must cover it ([`super::validate_parts`]). A leaf without triangles is refused, but where rule Q8 made it.
//!
//! [`read()`] believes nothing: it allocates no more than the file holds, whatever the numbers in it say, checks both checksums and
//! every index, and then runs [`super::validate_parts`] against the scene. So a tree for another scene is refused. A tree whose boxes are
//! not exact, or not of this scene any more as its vertices have moved, is read by [`read_unfitted`] and given its boxes by
//! [`crate::refine::refit`]: `bvh-lab build SCENE --tree TREE.bvh --refit -o NEW.bvh`.
//!
//! # A tree from elsewhere
//!
//! This C++ writes such a file; `nodes` are numbered as above, `vertices` (which may be null) are nine floats a triangle.
//!
//! ```cpp
//! #include <cstdint>
//! #include <cstdio>
//! #include <cstring>
//! #include <vector>
//!
//! struct Node { float min[3], max[3]; uint32_t first, count; };   // count | 0x80000000 in a leaf
//!
//! uint32_t crc32(const uint8_t* p, size_t n) {                    // or zlib's
//!     uint32_t c = ~0u;
//!     while (n--) { c ^= *p++; for (int i = 0; i < 8; i++) c = c >> 1 ^ (c & 1 ? 0xEDB88320u : 0); }
//!     return ~c;
//! }
//!
//! bool write_bvh(const char* path, const std::vector<Node>& nodes, const std::vector<uint32_t>& ids,
//!                uint32_t arity, uint32_t max_leaf, uint32_t triangles, const float* vertices) {
//!     uint32_t leaves = 0;
//!     for (const Node& node : nodes) leaves += node.count >> 31;
//!     uint32_t scene = vertices ? crc32(reinterpret_cast<const uint8_t*>(vertices), size_t(36) * triangles) : 0;
//!     uint32_t header[12] = {0x48564289, 0x0A1A0A0D, 1, vertices ? 4u : 0u, arity, max_leaf,
//!                            uint32_t(nodes.size()), leaves, uint32_t(ids.size()), triangles, scene, 0};
//!     std::vector<uint8_t> out(sizeof header + nodes.size() * sizeof(Node) + ids.size() * 4 + 4);
//!     uint8_t* p = out.data();                                    // on a little-endian machine
//!     memcpy(p, header, sizeof header);                     p += sizeof header;
//!     memcpy(p, nodes.data(), nodes.size() * sizeof(Node)); p += nodes.size() * sizeof(Node);
//!     memcpy(p, ids.data(), ids.size() * 4);                p += ids.size() * 4;
//!     uint32_t sum = crc32(out.data(), p - out.data());
//!     memcpy(p, &sum, 4);
//!     FILE* file = fopen(path, "wb");
//!     bool ok = file && fwrite(out.data(), 1, out.size(), file) == out.size();
//!     return file && fclose(file) == 0 && ok;
//! }
//! ```
//!
//! # From Rust
//!
//! ```
//! use bvh_lab::build::{Brake, BuildOptions, Input, find};
//! use bvh_lab::bvh::{file, tree_hash};
//! use bvh_lab::scene::Scene;
//!
//! let scene = Scene::load("gen:spheres:100")?;
//! let (builder, options) = (find("binned-sah").unwrap(), BuildOptions::default());
//! let bvh = (builder.timed)(Input::of_boxes(&scene.boxes()), &options, &mut Brake::default())?;
//! let folder = tempfile::tempdir()?;
//! let path = folder.path().join("tree.bvh");
//! file::write(&path, &bvh, &builder.limits(&options), &scene.triangles)?;
//! let read = file::read(&path, &scene.triangles)?;
//! assert_eq!(tree_hash(&read.bvh), tree_hash(&bvh));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod decode;
mod encode;
mod error;
#[cfg(test)]
mod tests;

pub use error::{FileError, Malformed};

use super::{Bvh, Coverage, Limits, validate_parts};
use crate::geom::{Aabb, Triangle};
use std::fs::{self, File};
use std::io::{self, BufWriter, Write};
use std::path::Path;

/// The first bytes of every tree file.
const MAGIC: [u8; 8] = *b"\x89BVH\r\n\x1a\n";
/// The one version there is.
const VERSION: u32 = 1;
/// Bytes before the first node.
const HEADER: usize = 48;
/// Bytes of a node.
const NODE: usize = 32;
/// Bytes of a slot, and of a checksum.
const WORD: usize = 4;

/// Flag: triangles may stand in several leaves.
const SPATIAL: u32 = 1;
/// Flag: nodes of rule Q8.
const Q8: u32 = 2;
/// Flag: the checksum of the scene is given.
const SCENE_CHECKSUM: u32 = 4;

/// A tree that was read and found to be one of the scene at hand.
#[derive(Clone, Debug, PartialEq)]
pub struct SavedTree {
    /// The tree.
    pub bvh: Bvh,
    /// What its builder held it to, and what it was validated with.
    pub limits: Limits,
    /// What the validation counted.
    pub coverage: Coverage,
}

/// A tree that was read as it stands in its file: its indices are in bounds, its children stand behind their parents, its
/// boxes hold no NaN; whether it is a tree, and of which scene, has not been looked at.
#[derive(Clone, Debug, PartialEq)]
pub struct UnfittedTree {
    /// The tree, fit for [`crate::refine::refit`] and [`super::validate_parts`].
    pub bvh: Bvh,
    /// What its builder held it to.
    pub limits: Limits,
    /// Which scene it was built for.
    pub scene: SceneMark,
}

/// What a tree file knows of its scene.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SceneMark {
    /// Number of triangles.
    pub triangles: usize,
    /// CRC-32 of the triangles' corners; `None` where the writer did not say.
    pub checksum: Option<u32>,
}

impl SceneMark {
    /// The mark of a scene, in time linear in its triangles.
    pub fn of(triangles: &[Triangle]) -> Self {
        let mut crc = crc32fast::Hasher::new();
        let mut bytes = Vec::with_capacity(36 * 1024);
        for some in triangles.chunks(1024) {
            bytes.clear();
            let numbers = some.iter().flat_map(|t| t.v).flat_map(|p| p.to_array());
            bytes.extend(numbers.flat_map(f32::to_le_bytes));
            crc.update(&bytes);
        }
        Self { triangles: triangles.len(), checksum: Some(crc.finalize()) }
    }

    /// Whether a tree with this mark can be one of the scene with the mark `scene`.
    fn fits(&self, scene: &Self) -> bool {
        self.triangles == scene.triangles && (self.checksum.is_none() || self.checksum == scene.checksum)
    }
}

/// Writes a tree of the scene with these `triangles`, which is valid within `limits`. The file appears whole or not at all: it
/// is written beside its place and then moved there. What is at `path` is replaced if it is a file.
///
/// # Errors
/// [`FileError::Write`].
///
/// # Panics
/// On a tree that its builder's [`super::validate_parts`] would not pass: without nodes, or with more triangles than ids.
pub fn write(path: &Path, bvh: &Bvh, limits: &Limits, triangles: &[Triangle]) -> Result<(), FileError> {
    let mark = SceneMark::of(triangles);
    replace(path, |out| encode::encode(out, bvh, limits, &mark))
        .map_err(|source| FileError::Write { path: path.into(), source })
}

/// Reads a tree and checks everything: the file, and the tree against the scene with these `triangles`.
///
/// # Errors
/// All of [`FileError`] but [`FileError::Write`]; always one line.
pub fn read(path: &Path, triangles: &[Triangle]) -> Result<SavedTree, FileError> {
    fitted(path, read_unfitted(path)?, triangles)
}

/// Checks a tree read from `path` against its scene.
fn fitted(path: &Path, tree: UnfittedTree, triangles: &[Triangle]) -> Result<SavedTree, FileError> {
    let UnfittedTree { bvh, limits, scene } = tree;
    let here = SceneMark::of(triangles);
    if !scene.fits(&here) {
        return Err(FileError::OtherScene { path: path.into(), built_for: scene, here });
    }
    let boxes: Vec<Aabb> = triangles.iter().map(Triangle::aabb).collect();
    match validate_parts(&bvh, triangles, &boxes, &limits) {
        Ok(coverage) => Ok(SavedTree { bvh, limits, coverage }),
        Err(violations) => Err(FileError::Invalid { path: path.into(), violations }),
    }
}

/// Reads a tree for [`crate::refine::refit`]: its boxes need not be those of any scene. What comes out is safe to refit over as
/// many boxes as [`SceneMark::triangles`] says, and is to be validated after that.
///
/// # Errors
/// [`FileError::Read`] and [`FileError::Malformed`].
pub fn read_unfitted(path: &Path) -> Result<UnfittedTree, FileError> {
    let tree = File::open(path).map_err(decode::Failure::Io).and_then(|mut file| decode::decode(&mut file));
    tree.map_err(|failure| failure.at(path))
}

/// Puts what `write` writes at `path`, all of it or nothing.
fn replace(path: &Path, write: impl FnOnce(&mut dyn Write) -> io::Result<()>) -> io::Result<()> {
    // Through a link to the file itself. A device or a folder is nothing that a file could take the place of.
    let place = fs::canonicalize(path).unwrap_or_else(|_| path.to_owned());
    if place.exists() && !place.is_file() {
        return Err(io::Error::new(io::ErrorKind::InvalidInput, "there is something that is not a file"));
    }
    let folder = place.parent().filter(|f| !f.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let mut builder = tempfile::Builder::new();
    builder.prefix(".bvh-lab-").suffix(".part");
    // As any new file, not for its owner alone.
    #[cfg(unix)]
    builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o666));
    let mut out = BufWriter::new(builder.tempfile_in(folder)?);
    write(&mut out)?;
    let file = out.into_inner().map_err(io::IntoInnerError::into_error)?;
    file.as_file().sync_all()?;
    file.persist(&place).map_err(|e| e.error)?;
    Ok(())
}
