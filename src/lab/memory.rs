//! Warm memory: what a run frees, the next one gets without asking the system for pages.
//!
//! A page that is touched for the first time costs the system some microseconds, and glibc gives large blocks back as
//! soon as they are freed: without this, at 10⁶ triangles a repeated build would mostly measure the page faults of its
//! arrays. Libraries written in C that are measured beside ours use the same allocator and profit alike.

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
