//! The command `bvh-lab`.

mod cli;

fn main() -> std::process::ExitCode {
    cli::main()
}
