//! Memory: kept warm between runs, and counted.
//!
//! **Warm.** A page that is touched for the first time costs the system some microseconds, and glibc gives large blocks back as
//! soon as they are freed: without [`keep_freed_memory`], at 10⁶ triangles a repeated build would mostly measure the page faults
//! of its arrays. Libraries written in C that are measured beside ours use the same allocator and profit alike.
//!
//! **Counted.** What a build takes at most is asked of the allocator, not of the system: bytes that were wanted, whatever pages
//! they lie in and whoever else has some. On one thread that is the same number on every machine, but for what is made once only,
//! such as a thread's own data; on several it depends on who is held up.

use std::alloc::{GlobalAlloc, Layout, System};
use std::sync::atomic::{AtomicBool, AtomicIsize, Ordering};
use std::sync::{Mutex, PoisonError};

/// Asks the allocator of this process to keep what is freed. Does nothing where the allocator is not glibc's. To be called
/// once, before anything is measured; not where memory is meant to be cold.
pub fn keep_freed_memory() {
    #[cfg(all(target_os = "linux", target_env = "gnu"))]
    // SAFETY: mallopt sets a parameter of the allocator and touches no memory of ours; any value is allowed.
    unsafe {
        libc::mallopt(libc::M_MMAP_MAX, 0);
        libc::mallopt(libc::M_TRIM_THRESHOLD, -1);
        libc::mallopt(libc::M_TOP_PAD, 64 << 20);
    }
}

/// The system's allocator, which counts while [`peak_of`] runs. A program has its figures if it says
/// `#[global_allocator] static ALLOCATOR: MeteredAllocator = MeteredAllocator;`. Of the crates for this,
/// `peak_alloc` writes zeros where the system has them, copies where it would move pages, and counts always, though builds are
/// timed here; `stats_alloc` keeps no peak.
#[derive(Clone, Copy, Debug, Default)]
pub struct MeteredAllocator;

/// Whether anybody counts.
static METERED: AtomicBool = AtomicBool::new(false);
/// Bytes given out since then, less those taken back.
static LIVE: AtomicIsize = AtomicIsize::new(0);
/// The most that these ever were.
static PEAK: AtomicIsize = AtomicIsize::new(0);

impl MeteredAllocator {
    #[inline(always)]
    fn more(memory: *mut u8, bytes: usize) {
        if METERED.load(Ordering::Relaxed) && !memory.is_null() {
            // No allocation is larger than the greatest isize.
            let live = LIVE.fetch_add(bytes as isize, Ordering::Relaxed) + bytes as isize;
            PEAK.fetch_max(live, Ordering::Relaxed);
        }
    }

    #[inline(always)]
    fn fewer(bytes: usize) {
        if METERED.load(Ordering::Relaxed) {
            LIVE.fetch_sub(bytes as isize, Ordering::Relaxed);
        }
    }
}

// SAFETY: all of it is the system's allocator.
unsafe impl GlobalAlloc for MeteredAllocator {
    // SAFETY: the caller's, as the system's allocator asks for it.
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        // SAFETY: the caller's.
        let memory = unsafe { System.alloc(layout) };
        Self::more(memory, layout.size());
        memory
    }

    // SAFETY: as above.
    unsafe fn alloc_zeroed(&self, layout: Layout) -> *mut u8 {
        // SAFETY: the caller's.
        let memory = unsafe { System.alloc_zeroed(layout) };
        Self::more(memory, layout.size());
        memory
    }

    // SAFETY: as above.
    unsafe fn dealloc(&self, memory: *mut u8, layout: Layout) {
        // Before another thread can have it.
        Self::fewer(layout.size());
        // SAFETY: the caller's.
        unsafe { System.dealloc(memory, layout) };
    }

    // SAFETY: as above.
    unsafe fn realloc(&self, memory: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        // SAFETY: the caller's.
        let moved = unsafe { System.realloc(memory, layout, size) };
        // For a moment there may be both.
        Self::more(moved, size);
        if !moved.is_null() {
            Self::fewer(layout.size());
        }
        moved
    }
}

/// Runs something, and counts the most bytes that the whole process held meanwhile beyond those that it had before; none
/// where [`MeteredAllocator`] is not the allocator of the program. What grows in place counts for a moment as both: old and
/// new.
pub fn peak_of<R>(run: impl FnOnce() -> R) -> (R, Option<usize>) {
    /// One at a time.
    static ONE: Mutex<()> = Mutex::new(());
    /// Ends the count, also where `run` panics.
    struct Count;
    impl Drop for Count {
        fn drop(&mut self) {
            METERED.store(false, Ordering::Relaxed);
        }
    }
    let _one = ONE.lock().unwrap_or_else(PoisonError::into_inner);
    LIVE.store(0, Ordering::Relaxed);
    PEAK.store(0, Ordering::Relaxed);
    METERED.store(true, Ordering::Relaxed);
    let count = Count;
    drop(std::hint::black_box(Box::new(0u8)));
    let is_counted = PEAK.load(Ordering::Relaxed) > 0;
    let result = run();
    drop(count);
    (result, is_counted.then(|| PEAK.load(Ordering::Relaxed) as usize))
}
