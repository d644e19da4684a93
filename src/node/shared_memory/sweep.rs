//! Half-made files of killed processes, which iceoryx2 0.10 waits for but never removes.
//!
//! It makes a file readable-only when it is complete. A process that is killed before that leaves one that its
//! owner could still write: others take the service for one that is just being made, for ever, and the dead
//! process's folder cannot be removed.

use std::fs;
use std::os::unix::fs::PermissionsExt;
use std::path::{Path, PathBuf};
use std::time::{Duration, SystemTime};

use iceoryx2::prelude::{Config, MessagingPattern, Service, ServiceName};
use iceoryx2::service::service_hash::ServiceHash;

use super::link::Ipc;

/// Longer than a living process can take over a file: it is written in milliseconds.
const ABANDONED: Duration = Duration::from_secs(5);
/// Removes what has been half made for long, of any run.
pub(super) fn sweep(config: &Config) {
    let prefix = config.global.prefix.to_string();
    let services = PathBuf::from(config.global.service_dir().to_string());
    let nodes = PathBuf::from(config.global.node_dir().to_string());
    let folders = entries(&nodes).into_iter().filter(|path| path.is_dir());
    for folder in folders.chain([services]) {
        for path in entries(&folder) {
            let name = path.file_name().unwrap_or_default().to_string_lossy();
            if name.starts_with(&prefix) && is_half_made(&path, ABANDONED) {
                // Another process may have been faster.
                let _ = fs::remove_file(&path);
            }
        }
    }
}

/// Removes the half-made file of a service, if it is older than that: of one that only the caller may make, any.
pub(super) fn discard(
    config: &Config,
    service: &ServiceName,
    pattern: MessagingPattern,
    age: Duration,
) {
    let hash = ServiceHash::new::<<Ipc as Service>::ServiceNameHasher>(service, pattern);
    let (prefix, suffix) = (
        config.global.prefix,
        config.global.service.static_config_storage_suffix,
    );
    let folder = PathBuf::from(config.global.service_dir().to_string());
    let path = folder.join(format!("{prefix}{hash}{suffix}"));
    if is_half_made(&path, age) {
        let _ = fs::remove_file(path);
    }
}

fn entries(folder: &Path) -> Vec<PathBuf> {
    let entries = fs::read_dir(folder).into_iter().flatten().flatten();
    entries.map(|entry| entry.path()).collect()
}

/// Whether a file is older than that and not yet complete.
fn is_half_made(path: &Path, age: Duration) -> bool {
    let Ok(data) = path.metadata() else {
        return false;
    };
    let modified = data.modified().unwrap_or(SystemTime::UNIX_EPOCH);
    let old = modified.elapsed().is_ok_and(|elapsed| elapsed > age);
    data.is_file() && old && data.permissions().mode() & 0o200 != 0
}
