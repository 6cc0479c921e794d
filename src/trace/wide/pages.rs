//! Memory on huge pages, for what kernels walk.
//!
//! A ray looks at nodes all over a layout of megabytes. With pages of 4 KB a processor has to look up in tables, again and
//! again, where each of them is; with pages of 2 MB it remembers them all. Linux gives them where it is asked to; elsewhere,
//! and where it has none left, this is ordinary memory.

use allocator_api2::alloc::{AllocError, Allocator, Global};
use std::alloc::Layout;
use std::ptr::NonNull;

/// An allocator for large pieces of memory that asks for huge pages.
#[derive(Clone, Copy, Debug, Default)]
pub(in crate::trace) struct HugePages;

/// A vector on huge pages.
pub(in crate::trace) type Vec<T> = allocator_api2::vec::Vec<T, HugePages>;

/// Bytes of a huge page of x86-64, and of other processors with small pages of 4 KB.
const PAGE: usize = 2 << 20;

/// From how many bytes on memory is asked for in whole pages.
const LEAST: usize = PAGE / 2;

/// Whether memory of this layout comes in pages, and then in how many bytes.
fn in_pages(layout: Layout) -> Option<usize> {
    (cfg!(target_os = "linux") && layout.size() >= LEAST && layout.align() <= PAGE)
        .then(|| layout.size().checked_next_multiple_of(PAGE))
        .flatten()
}

// SAFETY: memory is the system's, or fresh pages; it stays where it is until it is given back with a layout of the same size.
unsafe impl Allocator for HugePages {
    fn allocate(&self, layout: Layout) -> Result<NonNull<[u8]>, AllocError> {
        match in_pages(layout) {
            Some(bytes) => Ok(NonNull::slice_from_raw_parts(system::map(bytes).ok_or(AllocError)?, layout.size())),
            None => Global.allocate(layout),
        }
    }

    // SAFETY: the caller's promise is the trait's: memory of `allocate`, with a layout that fits it.
    unsafe fn deallocate(&self, memory: NonNull<u8>, layout: Layout) {
        match in_pages(layout) {
            // SAFETY: it was mapped with as many bytes.
            Some(bytes) => unsafe { system::unmap(memory, bytes) },
            // SAFETY: it was allocated there, with this layout.
            None => unsafe { Global.deallocate(memory, layout) },
        }
    }
}

#[cfg(target_os = "linux")]
mod system {
    use super::PAGE;
    use std::ptr::{self, NonNull};

    /// Fresh memory of `bytes`, a multiple of a page, at the beginning of one.
    pub(super) fn map(bytes: usize) -> Option<NonNull<u8>> {
        // Room to find the beginning of a page in; what is not needed goes back.
        let room = bytes.checked_add(PAGE)?;
        let (access, kind) = (libc::PROT_READ | libc::PROT_WRITE, libc::MAP_PRIVATE | libc::MAP_ANONYMOUS);
        // SAFETY: a new mapping, of nothing.
        let start = unsafe { libc::mmap(ptr::null_mut(), room, access, kind, -1, 0) };
        if start == libc::MAP_FAILED {
            return None;
        }
        let start = start.cast::<u8>();
        let before = start.align_offset(PAGE);
        // SAFETY: the parts before and behind are of the mapping above, in whole small pages; nothing refers to them.
        unsafe {
            let memory = start.add(before);
            for (part, bytes) in [(start, before), (memory.add(bytes), PAGE - before)] {
                if bytes > 0 {
                    libc::munmap(part.cast(), bytes);
                }
            }
            // Advice: where it is not taken there are small pages.
            libc::madvise(memory.cast(), bytes, libc::MADV_HUGEPAGE);
            NonNull::new(memory)
        }
    }

    /// # Safety
    /// `memory` is of [`map`], with the same number of bytes, and nothing refers to it.
    pub(super) unsafe fn unmap(memory: NonNull<u8>, bytes: usize) {
        // SAFETY: the caller's promise.
        unsafe { libc::munmap(memory.as_ptr().cast(), bytes) };
    }
}

#[cfg(not(target_os = "linux"))]
mod system {
    use std::ptr::NonNull;

    pub(super) fn map(_: usize) -> Option<NonNull<u8>> {
        None
    }

    /// # Safety
    /// None is asked for: [`map`] never gives anything, so there is nothing to give back.
    // SAFETY: unsafe only as its like for Linux is; it does nothing.
    pub(super) unsafe fn unmap(_: NonNull<u8>, _: usize) {}
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn vectors_of_any_size_grow_and_shrink_and_keep_what_they_hold() {
        for n in [0, 1, 1000, LEAST / 8 - 1, LEAST / 8, PAGE / 8, PAGE / 8 + 1, 3 * PAGE / 8] {
            let mut some: Vec<u64> = Vec::new_in(HugePages);
            some.extend((0..n as u64).map(|i| i * i));
            let copy = some.clone();
            some.extend(0..10);
            some.truncate(n);
            some.shrink_to_fit();
            assert_eq!(some, copy);
            assert!((0..).zip(&some).all(|(i, &x)| x == i * i));
        }
    }

    #[test]
    #[cfg(target_os = "linux")]
    fn large_memory_begins_with_a_page() {
        let some = Vec::<u8>::with_capacity_in(LEAST, HugePages);
        assert!(some.as_ptr().addr().is_multiple_of(PAGE));
        assert!(HugePages.allocate(Layout::from_size_align(isize::MAX as usize - PAGE, 1).unwrap()).is_err());
    }
}
