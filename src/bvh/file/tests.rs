//! Tree files: what comes back, what is refused, and what hostile bytes do.

use super::*;
use crate::build::{BUILDERS, Brake, BuildOptions, Input, Parameter};
use crate::bvh::testing::{Random, boxes, median_split, random_tree, soup};
use crate::bvh::{Node, tree_hash, validate};
use crate::cost::{SahParams, sah};
use crate::refine::refit;
use glam::Vec3;
use proptest::prelude::*;
use tempfile::TempDir;

/// A file of its own, gone with the test.
struct Shelf(TempDir);

impl Shelf {
    fn new() -> Self {
        Self(TempDir::new().unwrap())
    }

    fn path(&self) -> std::path::PathBuf {
        self.0.path().join("tree.bvh")
    }

    /// The bytes that [`write()`] writes, without waiting for the disk.
    fn written(&self, bvh: &Bvh, limits: &Limits, triangles: &[Triangle]) -> Vec<u8> {
        let mut bytes = Vec::new();
        encode::encode(&mut bytes, bvh, limits, &SceneMark::of(triangles)).unwrap();
        bytes
    }

    /// What [`read()`] makes of a file of these bytes.
    fn read(&self, mut bytes: &[u8], triangles: &[Triangle]) -> Result<SavedTree, FileError> {
        let path = self.path();
        fitted(&path, decode::decode(&mut bytes).map_err(|failure| failure.at(&path))?, triangles)
    }

    /// The one line that these bytes are refused with.
    fn refused(&self, bytes: &[u8], triangles: &[Triangle]) -> String {
        let line = self.read(bytes, triangles).unwrap_err().to_string();
        assert!(line.contains("tree.bvh: ") && !line.contains('\n'), "{line}");
        line
    }
}

/// The same bytes with the checksum at their end made right.
fn sealed(mut bytes: Vec<u8>) -> Vec<u8> {
    let end = bytes.len() - WORD;
    let checksum = crc32fast::hash(&bytes[..end]);
    bytes[end..].copy_from_slice(&checksum.to_le_bytes());
    bytes
}

/// A good file with some words changed, checksum made right. Offsets in bytes.
fn with_words(bytes: &[u8], words: &[(usize, u32)]) -> Vec<u8> {
    let mut bytes = bytes.to_vec();
    for (at, word) in words {
        bytes[*at..at + WORD].copy_from_slice(&word.to_le_bytes());
    }
    sealed(bytes)
}

/// Nine triangles, leaves of up to two, and where the parts of their file begin.
fn nine() -> (Vec<Triangle>, Bvh, Limits) {
    let triangles = soup(5, 9, 0.4);
    let bvh = median_split(&boxes(&triangles), 2);
    (triangles, bvh, Limits { max_leaf: 2, ..Limits::default() })
}

/// Offset of the first and of the last word of a node.
const fn box_of(node: usize) -> usize {
    HEADER + NODE * node
}
const fn first_of(node: usize) -> usize {
    box_of(node) + 24
}
const fn count_of(node: usize) -> usize {
    box_of(node) + 28
}

#[test]
fn bytes_by_hand_are_a_tree_and_have_its_cost() {
    // Two unit squares, two triangles each, three apart; put down without any code of ours, from the table alone.
    let square = |x: f32| {
        let p = |dx: f32, dy: f32| Vec3::new(x + dx, dy, 0.0);
        [Triangle::new(p(0.0, 0.0), p(1.0, 0.0), p(1.0, 1.0)), Triangle::new(p(0.0, 0.0), p(1.0, 1.0), p(0.0, 1.0))]
    };
    let triangles = [square(0.0), square(4.0)].concat();
    #[rustfmt::skip]
    let mut bytes: Vec<u8> = [
        0x8942_5648, 0x0d0a_1a0a,
        0x0100_0000, 0x0000_0000, 0x0200_0000, 0x0400_0000, // version, flags, arity, leaf limit
        0x0300_0000, 0x0200_0000, 0x0400_0000, 0x0400_0000, // nodes, leaves, slots, triangles
        0x0000_0000, 0x0000_0000,
        0, 0, 0, 0x0000_a040, 0x0000_803f, 0, 0x0100_0000, 0x0200_0000, // (0 0 0) to (5 1 0): children 1 and 2
        0, 0, 0, 0x0000_803f, 0x0000_803f, 0, 0x0000_0000, 0x0200_0080, // (0 0 0) to (1 1 0): slots 0 and 1
        0x0000_8040, 0, 0, 0x0000_a040, 0x0000_803f, 0, 0x0200_0000, 0x0200_0080, // (4 0 0) to (5 1 0): slots 2 and 3
        0x0100_0000, 0x0000_0000, 0x0200_0000, 0x0300_0000u32, // triangles 1, 0, 2, 3
    ].into_iter().flat_map(u32::to_be_bytes).collect();
    // CRC-32 bit by bit: the polynomial of IEEE 802.3, reflected.
    let mut crc = !0u32;
    for byte in &bytes {
        crc ^= u32::from(*byte);
        for _ in 0..8 {
            crc = (crc >> 1) ^ (0xedb8_8320 & (crc & 1).wrapping_neg());
        }
    }
    bytes.extend((!crc).to_le_bytes());
    let read = Shelf::new().read(&bytes, &triangles).unwrap();
    assert_eq!((read.limits, read.coverage.references), (Limits::default(), 4));
    assert_eq!((read.bvh.leaf_triangles(1), read.bvh.leaf_triangles(2)), (&[1, 0][..], &[2, 3][..]));
    // Areas: 10 for the root, 2 for each leaf of two triangles.
    assert_eq!(sah(&read.bvh, SahParams::default()), Some(1.0 + 2.0 * 2.0 / 10.0 * 2.0));
}

#[test]
fn every_builder_at_every_arity_comes_back_and_so_do_the_bytes() {
    let shelf = Shelf::new();
    for n in [1, 2, 90] {
        let triangles = soup(3, n, 0.3);
        let b = boxes(&triangles);
        for builder in BUILDERS {
            let few = builder.parameters.contains(&Parameter::Candidates).then_some(9);
            for options in builder.variants(BuildOptions { candidates: few, ..BuildOptions::default() }) {
                let input = Input::of_triangles(&triangles, &b);
                let bvh = (builder.timed)(input, &options, &mut Brake::default()).unwrap();
                let limits = builder.limits(&options);
                let bytes = shelf.written(&bvh, &limits, &triangles);
                assert_eq!(bytes.len(), HEADER + NODE * bvh.nodes.len() + WORD * (bvh.triangle_ids.len() + 1));
                let read = shelf.read(&bytes, &triangles).unwrap();
                assert_eq!((&read.bvh, read.limits), (&bvh, limits), "{} {options:?}", builder.id);
                assert_eq!(tree_hash(&read.bvh), tree_hash(&bvh));
                assert_eq!(shelf.written(&read.bvh, &read.limits, &triangles), bytes);
            }
        }
    }
}

#[test]
fn a_file_larger_than_a_block_comes_back() {
    let triangles = soup(1, 40_000, 0.02);
    let bvh = random_tree(1, &boxes(&triangles), 5, 3);
    let shelf = Shelf::new();
    write(&shelf.path(), &bvh, &Limits::default(), &triangles).unwrap();
    let bytes = shelf.written(&bvh, &Limits::default(), &triangles);
    assert!(bytes.len() > 4 * (1 << 16) && fs::read(shelf.path()).unwrap() == bytes);
    assert_eq!(read(&shelf.path(), &triangles).unwrap().bvh, bvh);
}

#[test]
fn every_flipped_bit_is_noticed() {
    let (triangles, bvh, limits) = nine();
    let shelf = Shelf::new();
    let good = shelf.written(&bvh, &limits, &triangles);
    for at in 0..good.len() {
        for bit in 0..8 {
            let mut bad = good.clone();
            bad[at] ^= 1 << bit;
            let line = shelf.refused(&bad, &triangles);
            assert!(at >= 8 || line.contains("not a tree file"), "{at} {line}");
        }
    }
}

#[test]
fn every_length_but_the_right_one_is_noticed() {
    let (triangles, bvh, limits) = nine();
    let shelf = Shelf::new();
    let good = shelf.written(&bvh, &limits, &triangles);
    for length in 0..good.len() {
        let line = shelf.refused(&good[..length], &triangles);
        if length < MAGIC.len() {
            assert!(line.contains("not a tree file"), "{line}");
        } else {
            let size = if length < HEADER { HEADER } else { good.len() };
            assert!(line.contains(&format!("ends after {length} of {size} bytes")), "{line}");
        }
    }
    let long = [&good[..], b"\n"].concat();
    assert!(shelf.refused(&long, &triangles).contains(&format!("goes on beyond its {} bytes", good.len())));
}

#[test]
fn every_changed_byte_under_a_right_checksum_is_an_error_or_changes_nothing() {
    let (triangles, bvh, limits) = nine();
    let shelf = Shelf::new();
    let good = shelf.written(&bvh, &limits, &triangles);
    let mut accepted = Vec::new();
    for at in 0..good.len() - WORD {
        for value in [0, 1, 2, 3, 5, 8, 64, 127, 128, 192, 255, good[at] ^ 1, good[at] ^ 128] {
            let mut changed = good.clone();
            changed[at] = value;
            match shelf.read(&sealed(changed), &triangles) {
                Ok(read) => {
                    assert_eq!((&read.bvh.nodes, tree_hash(&read.bvh)), (&bvh.nodes, tree_hash(&bvh)), "{at} {value}");
                    if value != good[at] {
                        accepted.push(at);
                    }
                }
                Err(e) => assert!(!e.to_string().contains('\n')),
            }
        }
    }
    accepted.dedup();
    // What a valid tree may be told to be: flags, arity and leaf limit, as long as it keeps them; ids may change places in
    // their leaf only together.
    assert!(accepted.iter().all(|at| (12..24).contains(at)) && accepted.contains(&16), "{accepted:?}");
}

#[test]
fn what_is_wrong_is_said() {
    let (triangles, bvh, limits) = nine();
    let shelf = Shelf::new();
    let good = shelf.written(&bvh, &limits, &triangles);
    let (n, s) = (bvh.nodes.len(), bvh.triangle_ids.len());
    let leaf = bvh.nodes.iter().position(Node::is_leaf).unwrap();
    let inner = (1..n).find(|&i| !bvh.nodes[i].is_leaf()).unwrap();
    let slots = HEADER + NODE * n;
    let nan = f32::NAN.to_bits();
    let top = 1 << 31;
    for (words, says) in [
        (vec![(8, 2)], "version 2, and this program reads version 1"),
        (vec![(12, 8)], "flags in the header is 8"),
        (vec![(16, 1)], "arity in the header is 1"),
        (vec![(20, 0)], "leaf limit in the header is 0"),
        (vec![(20, 1)], "holds 2 triangles, more than 1"),
        (vec![(24, 0)], "number of nodes in the header is 0"),
        (vec![(24, u32::MAX), (32, u32::MAX)], "bytes: it was cut short"),
        (vec![(24, n as u32 - 1)], "its checksum is"),
        (vec![(28, n as u32 + 1)], "number of leaves in the header"),
        (vec![(28, 1)], "the header promises 1 leaves"),
        (vec![(32, u32::MAX)], "it was cut short"),
        (vec![(36, 0)], "number of triangles in the header is 0"),
        (vec![(36, u32::MAX)], "number of triangles in the header"),
        (vec![(36, 8)], "slot"),
        (vec![(36, 10)], "built for a scene of 10 triangles, not for this one of 9"),
        (vec![(40, 7)], "with checksum 00000007, not for this one with"),
        (vec![(12, 0)], "without flag 2 it is 0"),
        (vec![(44, 1)], "last field in the header is 1"),
        (vec![(first_of(0), 0)], "node 0 has child 0, which does not stand behind it"),
        (vec![(first_of(inner), 1)], "which does not stand behind it"),
        (vec![(first_of(0), n as u32)], &format!("node 0 has child {} of {n} nodes", n + 1)),
        (vec![(first_of(0), u32::MAX)], "node 0 has child 4294967296"),
        (vec![(first_of(0), 2)], "invalid tree: node 1 cannot be reached"),
        (vec![(count_of(0), 0)], "inner node 0 has no children"),
        (vec![(count_of(0), 1)], "cannot be reached from the root"),
        (vec![(count_of(0), 3)], "has 3 children, more than the arity 2"),
        (vec![(count_of(0), top - 1)], "node 0 has child"),
        (vec![(first_of(leaf), s as u32)], &format!("the slots of leaf {leaf} end at")),
        (vec![(count_of(leaf), u32::MAX)], &format!("the slots of leaf {leaf} end at")),
        (vec![(count_of(leaf), top)], &format!("leaf {leaf} is empty")),
        (vec![(first_of(leaf), (bvh.nodes[leaf].range().start + 1) as u32 % s as u32)], "although it was held before"),
        (vec![(slots, 9)], "slot 0 holds triangle 9 of 9"),
        (vec![(slots, u32::MAX)], "slot 0 holds triangle 4294967295 of 9"),
        (vec![(slots, bvh.triangle_ids[1])], "although it was held before"),
        (vec![(box_of(0), nan)], "the box of node 0 is empty, or holds NaN"),
        (vec![(box_of(leaf) + 12, nan)], &format!("the box of node {leaf} is empty, or holds NaN")),
        (vec![(box_of(leaf), f32::INFINITY.to_bits())], "is empty, or holds NaN"),
        (vec![(box_of(inner), f32::MAX.to_bits())], "is empty, or holds NaN"),
        (vec![(box_of(0), (-9f32).to_bits())], "the box of node 0 is not the union of the boxes below it"),
        (vec![(box_of(leaf), (-9f32).to_bits())], "refit it to this scene (--refit)"),
    ] {
        let line = shelf.refused(&with_words(&good, &words), &triangles);
        assert!(line.contains(says), "{words:?}: {line}, not {says}");
    }
    // An old tree of a moved scene, and one that names no scene: the boxes tell.
    let moved = soup(6, 9, 0.4);
    let line = shelf.refused(&good, &moved);
    assert!(line.contains("with checksum") && line.contains("--refit"), "{line}");
    assert!(shelf.refused(&good, &moved[..8]).contains("built for a scene of 9 triangles, not for this one of 8"));
    let nameless = with_words(&good, &[(12, 0), (40, 0)]);
    assert!(shelf.refused(&nameless, &moved).contains("is not the union of the boxes below it"));
    assert_eq!(shelf.read(&nameless, &triangles).unwrap().bvh, bvh);
    for not_a_tree in [&b""[..], b"v 0 0 0\nf 1 2 3\n", b"\x89BVH\n\x1a\n and more", &[0; 100]] {
        assert!(shelf.refused(not_a_tree, &triangles).contains("not a tree file"));
    }
}

#[test]
fn a_header_that_promises_the_world_costs_nothing() {
    // Were memory taken as promised, this would take 2³² · 36 bytes.
    let (triangles, bvh, limits) = nine();
    let shelf = Shelf::new();
    let good = shelf.written(&bvh, &limits, &triangles);
    let bytes = with_words(&good, &[(24, u32::MAX), (28, u32::MAX), (32, u32::MAX)]);
    assert!(shelf.refused(&bytes, &triangles).contains("of 154618822672 bytes"));
    // Nor does a file without an end hold anybody up.
    #[cfg(unix)]
    assert!(read(Path::new("/dev/zero"), &triangles).unwrap_err().to_string().contains("not a tree file"));
}

#[test]
fn triangles_in_several_leaves_are_as_the_flags_say() {
    let (triangles, ..) = nine();
    let b = boxes(&triangles);
    let mut bvh = Bvh {
        nodes: vec![Node::inner(b[0], 1, 2), Node::leaf(b[0], 0, 5), Node::leaf(b[0], 4, 5)],
        triangle_ids: (0..9).collect(),
        arity: 2,
    };
    refit(&mut bvh, &b);
    let shelf = Shelf::new();
    let limits = Limits { max_leaf: 5, ..Limits::default() };
    // Slot 4 is in both leaves.
    let overlapping = shelf.written(&bvh, &limits, &triangles);
    assert!(
        shelf.refused(&overlapping, &triangles).contains("triangle 4 stands in leaf 2 although it was held before")
    );
    let read = shelf.read(&with_words(&overlapping, &[(12, Q8 | SCENE_CHECKSUM)]), &triangles).unwrap();
    assert_eq!((read.limits.q8, read.coverage.duplicated, read.bvh), (true, 1, bvh));
    for (q8, spatial) in [(false, true), (true, false), (true, true)] {
        let limits = Limits { q8, spatial, ..limits };
        let (.., bvh, _) = nine();
        write(&shelf.path(), &bvh, &limits, &triangles).unwrap();
        assert_eq!(read_unfitted(&shelf.path()).unwrap().limits, limits);
    }
}

#[test]
fn a_moved_scene_gets_its_tree_back_by_refitting() {
    let (triangles, bvh, limits) = nine();
    let moved = soup(6, 9, 0.4);
    let shelf = Shelf::new();
    write(&shelf.path(), &bvh, &limits, &triangles).unwrap();
    let mut old = read_unfitted(&shelf.path()).unwrap();
    assert_eq!(old.scene, SceneMark::of(&triangles));
    refit(&mut old.bvh, &boxes(&moved));
    write(&shelf.path(), &old.bvh, &old.limits, &moved).unwrap();
    let new = read(&shelf.path(), &moved).unwrap();
    assert_eq!((tree_hash(&new.bvh), &new.bvh), (tree_hash(&bvh), &old.bvh));
}

#[test]
fn files_appear_whole_or_not_at_all() {
    let (triangles, bvh, limits) = nine();
    let shelf = Shelf::new();
    let good = shelf.written(&bvh, &limits, &triangles);
    // Over an old one: replaced, nothing else left behind.
    fs::write(shelf.path(), "old").unwrap();
    write(&shelf.path(), &bvh, &limits, &triangles).unwrap();
    assert!(fs::read(shelf.path()).unwrap() == good);
    assert_eq!(fs::read_dir(shelf.0.path()).unwrap().count(), 1);
    // A writer that fails half way leaves the old one.
    let failed = replace(&shelf.path(), |out| {
        out.write_all(b"half")?;
        Err(io::Error::other("no more"))
    });
    assert!(failed.is_err() && fs::read(shelf.path()).unwrap() == good);
    assert_eq!(fs::read_dir(shelf.0.path()).unwrap().count(), 1);
    for place in [shelf.0.path().to_owned(), shelf.0.path().join("no/where.bvh")] {
        let error = write(&place, &bvh, &limits, &triangles).unwrap_err();
        assert!(error.to_string().starts_with(&format!("cannot write {}: ", place.display())), "{error}");
    }
    let nowhere = read(&shelf.0.path().join("none.bvh"), &triangles).unwrap_err();
    assert!(matches!(&nowhere, FileError::Read { .. }) && nowhere.to_string().contains("none.bvh"), "{nowhere}");
    assert!(matches!(read(shelf.0.path(), &triangles), Err(FileError::Read { .. })));
}

#[cfg(unix)]
#[test]
fn links_lead_to_the_file_and_devices_stay_what_they_are() {
    use std::os::unix::fs::{FileTypeExt, PermissionsExt, symlink};
    let (triangles, bvh, limits) = nine();
    let shelf = Shelf::new();
    write(&shelf.path(), &bvh, &limits, &triangles).unwrap();
    let link = shelf.0.path().join("link.bvh");
    symlink(shelf.path(), &link).unwrap();
    write(&link, &bvh, &limits, &triangles).unwrap();
    assert!(link.is_symlink() && !shelf.path().is_symlink());
    assert_ne!(fs::metadata(shelf.path()).unwrap().permissions().mode() & 0o044, 0, "others may read it");
    let device = Path::new("/dev/null");
    assert!(write(device, &bvh, &limits, &triangles).unwrap_err().to_string().contains("not a file"));
    assert!(fs::metadata(device).unwrap().file_type().is_char_device());
}

/// Some of a good file's words, or words near it, so that what comes out is often almost a tree.
fn near_miss(good: &[u8], random: &mut Random) -> Vec<u8> {
    let words = good.len() / WORD;
    let mut bytes = good.to_vec();
    for _ in 0..1 + random.below(4) {
        let (to, from) = (2 + random.below(words - 2), random.below(words));
        let word: [u8; WORD] = bytes[from * WORD..][..WORD].try_into().unwrap();
        let word = match random.below(4) {
            0 => u32::from_le_bytes(word),
            1 => random.below(12) as u32,
            2 => random.below(12) as u32 | 1 << 31,
            _ => random.next() as u32,
        };
        bytes[to * WORD..][..WORD].copy_from_slice(&word.to_le_bytes());
    }
    match random.below(6) {
        0 => bytes.truncate(random.below(bytes.len())),
        1 => bytes.extend((0..random.below(40)).map(|_| random.next() as u8)),
        _ => {}
    }
    if bytes.len() > HEADER { sealed(bytes) } else { bytes }
}

proptest! {
    #[test]
    fn any_tree_comes_back(seed: u64, n in 1usize..70, arity in 2usize..17, max_leaf in 1usize..9) {
        let triangles = soup(seed, n, 0.4);
        let bvh = random_tree(seed, &boxes(&triangles), arity, max_leaf);
        let limits = Limits { max_leaf, ..Limits::default() };
        let shelf = Shelf::new();
        let bytes = shelf.written(&bvh, &limits, &triangles);
        let read = shelf.read(&bytes, &triangles).unwrap();
        prop_assert_eq!((&read.bvh, read.limits), (&bvh, limits));
        prop_assert_eq!(shelf.written(&read.bvh, &read.limits, &triangles), bytes);
    }

    #[test]
    fn no_bytes_are_too_much(bytes: Vec<u8>, header: [u32; 10]) {
        let with_magic = [&MAGIC[..], &bytes].concat();
        let small = header.map(|word| word % 5);
        let words = |words: [u32; 10]| words.into_iter().flat_map(u32::to_le_bytes).collect::<Vec<u8>>();
        let with_header = [&MAGIC[..], &words(header), &bytes].concat();
        let with_small = sealed([&MAGIC[..], &words([1, 0, 2, small[3], small[4], small[5], small[6], 3, 0, 0]), &bytes, &[0; WORD]].concat());
        for bytes in [bytes, with_magic, with_header, with_small] {
            if let Err(decode::Failure::Io(e)) = decode::decode(&mut &bytes[..]) {
                panic!("{e}");
            }
        }
    }

    #[test]
    fn what_is_nearly_a_tree_is_refused_or_is_one(seed: u64) {
        let (triangles, bvh, limits) = nine();
        let b = boxes(&triangles);
        let mut good = Vec::new();
        encode::encode(&mut good, &bvh, &limits, &SceneMark { checksum: None, ..SceneMark::of(&triangles) }).unwrap();
        let mut random = Random(seed);
        for _ in 0..50 {
            let Ok(mut read) = decode::decode(&mut &near_miss(&good, &mut random)[..]) else { continue };
            // Whatever it is: it can be validated, and refitted if it is of so many triangles.
            let _ = validate(&read.bvh, &b, &read.limits);
            if read.scene.triangles <= b.len() {
                refit(&mut read.bvh, &b);
                if validate(&read.bvh, &b, &read.limits).is_ok() && !read.limits.q8 && !read.limits.spatial {
                    let mut ids = read.bvh.nodes.iter().filter(|n| n.is_leaf()).flat_map(|n| read.bvh.triangle_ids[n.range()].to_vec()).collect::<Vec<_>>();
                    ids.sort_unstable();
                    prop_assert_eq!(ids, (0..9).collect::<Vec<u32>>());
                }
            }
        }
    }
}
