//! What can be wrong with a tree file: each message says what, where, and what to do, in one line.

use super::{SceneMark, VERSION};
use crate::bvh::{Violation, Violations};
use std::path::PathBuf;

/// Why a tree was not read or written.
#[derive(Debug, thiserror::Error)]
pub enum FileError {
    /// The system did not let it be read.
    #[error("cannot read {path}: {source}", path = path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// What the system said.
        source: std::io::Error,
    },
    /// The system did not let it be written.
    #[error("cannot write {path}: {source}", path = path.display())]
    Write {
        /// The file.
        path: PathBuf,
        /// What the system said.
        source: std::io::Error,
    },
    /// It is no tree file, or a damaged one.
    #[error("{path}: {reason}", path = path.display())]
    Malformed {
        /// The file.
        path: PathBuf,
        /// What is wrong with it.
        reason: Malformed,
    },
    /// The tree was built for other triangles.
    #[error(
        "{path}: built for {built}, not for {these}: name that scene, or build the tree anew{refit}",
        path = path.display(),
        built = one_scene(built_for, built_for.triangles == here.triangles),
        these = this_scene(here, built_for.triangles == here.triangles),
        refit = if built_for.triangles == here.triangles { ", or refit it if only vertices moved (--refit)" } else { "" }
    )]
    OtherScene {
        /// The file.
        path: PathBuf,
        /// The scene that it names.
        built_for: SceneMark,
        /// The scene at hand.
        here: SceneMark,
    },
    /// The file is sound, but what it holds is not a tree of this scene.
    #[error("{path}: {what}; {advice}", path = path.display(), what = gravest(violations), advice = advice(violations))]
    Invalid {
        /// The file.
        path: PathBuf,
        /// What the validator found.
        violations: Violations,
    },
}

fn one_scene(mark: &SceneMark, with_checksum: bool) -> String {
    match mark.checksum.filter(|_| with_checksum) {
        Some(checksum) => format!("a scene of {} triangles with checksum {checksum:08x}", mark.triangles),
        None => format!("a scene of {} triangles", mark.triangles),
    }
}

fn this_scene(mark: &SceneMark, with_checksum: bool) -> String {
    match mark.checksum.filter(|_| with_checksum) {
        Some(checksum) => format!("this one with {checksum:08x}"),
        None => format!("this one of {}", mark.triangles),
    }
}

/// What to tell of: what is wrong with the boxes often follows from something else.
fn gravest(violations: &Violations) -> String {
    let other = violations.first.iter().find(|v| !matches!(v, Violation::LooseBox(_)));
    match other.filter(|_| violations.total > 1) {
        Some(violation) => format!("invalid tree: {violation} (one of {} violations)", violations.total),
        None => violations.to_string(),
    }
}

/// What the user can do.
fn advice(violations: &Violations) -> &'static str {
    if violations.first.iter().all(|v| matches!(v, Violation::LooseBox(_))) {
        "refit it to this scene (--refit), or have its writer make boxes exact"
    } else {
        "mend the program that wrote it, or build the tree anew"
    }
}

/// What is wrong with the bytes of a tree file. Nodes and slots are named by their index.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum Malformed {
    /// The file begins otherwise.
    #[error("not a tree file (its first 8 bytes are not those of one): `bvh-lab build SCENE -o TREE.bvh` writes them")]
    Magic,
    /// A version that this program does not know.
    #[error("a tree file of version {0}, and this program reads version {VERSION}: write it with this program")]
    Version(u32),
    /// A number of the header that cannot be.
    #[error("the {field} in the header is {value}, and {wanted}: write the file anew")]
    Header {
        /// Which number.
        field: &'static str,
        /// What it is.
        value: u32,
        /// What it could be.
        wanted: &'static str,
    },
    /// The file is shorter than its header says.
    #[error("ends after {at} of {size} bytes: it was cut short or its header is wrong; write it anew")]
    Truncated {
        /// Bytes that there are.
        at: u64,
        /// Bytes that there should be: all of them, or those of the header.
        size: u64,
    },
    /// The file is longer than its header says.
    #[error("goes on beyond its {size} bytes: its header is wrong, or something was appended; write it anew")]
    TooLong {
        /// Bytes that there should be.
        size: u64,
    },
    /// The checksum at the end is not that of the bytes before it.
    #[error("damaged: its checksum is {computed:08x} and should be {stored:08x}; write it anew")]
    Checksum {
        /// What the file says.
        stored: u32,
        /// What its bytes give.
        computed: u32,
    },
    /// Leaves are not as many as the header says.
    #[error("the header promises {promised} leaves and there are {found}: mend the program that wrote it")]
    Leaves {
        /// What the header says.
        promised: u32,
        /// What there are.
        found: usize,
    },
    /// An inner node without children.
    #[error("inner node {0} has no children: mend the program that wrote it")]
    NoChildren(usize),
    /// A cycle, or an order that parents do not lead.
    #[error("node {node} has child {child}, which does not stand behind it: number parents before their children")]
    ChildNotBehind {
        /// The node.
        node: usize,
        /// Its first child.
        child: usize,
    },
    /// Children beyond the last node.
    #[error("node {node} has child {last} of {nodes} nodes: mend the program that wrote it")]
    ChildrenBeyond {
        /// The node.
        node: usize,
        /// Its last child.
        last: usize,
        /// Nodes there are.
        nodes: usize,
    },
    /// Slots beyond the last one.
    #[error("the slots of leaf {leaf} end at {last} of {slots}: mend the program that wrote it")]
    SlotsBeyond {
        /// The leaf.
        leaf: usize,
        /// End of its slots.
        last: usize,
        /// Slots there are.
        slots: usize,
    },
    /// A box that is empty or holds NaN or infinity.
    #[error("the box of node {0} is empty, or holds NaN or infinity: mend the program that wrote it")]
    Box(usize),
    /// An id that no triangle has.
    #[error("slot {slot} holds triangle {id} of {triangles}: ids count from 0; mend the program that wrote it")]
    Id {
        /// The slot.
        slot: usize,
        /// The id.
        id: u32,
        /// Triangles there are.
        triangles: u32,
    },
}
