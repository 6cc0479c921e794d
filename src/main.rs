//! The command `bvh-lab`.

mod cli;

/// So that builds can say what they take.
#[global_allocator]
static ALLOCATOR: bvh_lab::lab::MeteredAllocator = bvh_lab::lab::MeteredAllocator;

fn main() -> std::process::ExitCode {
    cli::main()
}
