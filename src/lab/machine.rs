//! Which program, on which machine: what every row says of its origin.

/// Version of the crate and of the row format; rows of different formats are never mixed.
pub fn version() -> &'static str {
    concat!(env!("CARGO_PKG_VERSION"), "+rows2")
}

/// The commit the program was built from; with `-modified-` and a fingerprint of the sources where they differ from it,
/// `unknown-` and the fingerprint outside a checkout.
pub fn commit() -> &'static str {
    env!("BVH_LAB_COMMIT")
}

/// Processor, number of hardware threads and operating system.
pub fn machine() -> String {
    let model = std::fs::read_to_string("/proc/cpuinfo").ok().and_then(|text| {
        let line = text.lines().find(|l| l.starts_with("model name"))?;
        Some(line.split_once(':')?.1.trim().to_owned())
    });
    let threads = std::thread::available_parallelism().map_or(1, usize::from);
    let model = model.as_deref().unwrap_or(std::env::consts::ARCH);
    format!("{model}, {threads} threads, {}", std::env::consts::OS)
}
