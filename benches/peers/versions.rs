//! Versions of the peers, as the build script read them from the lock file's packages.

/// The version of the package, or a question mark.
pub fn of(package: &str) -> String {
    let mut all = env!("BVH_LAB_PEERS").split(',').filter_map(|entry| entry.split_once('='));
    all.find(|(name, _)| *name == package).map_or_else(|| "?".into(), |(_, version)| version.into())
}
