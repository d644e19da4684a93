//! Part of the build script: which build this is, for recordings. Not a module of the crate.
//!
//! Two builds with the same name give the same bits on the same processor: same sources of the core, same
//! versions of what it depends on, same compiler and optimisation, same target.

use std::path::{Path, PathBuf};
use std::process::Command;
use std::{env, fs, io};

/// The modules whose sources decide the bits.
const CORE: [&str; 7] = [
    "math", "sheet", "fabric", "contact", "physics", "scene", "sim",
];
/// Versions of the dependencies.
const LOCK: &str = "Cargo.lock";

/// What the build script says: what it depends on, and the name of the build as `TOILE_BUILD`.
pub fn lines() -> io::Result<Vec<String>> {
    let watched = CORE.iter().map(|module| format!("src/{module}"));
    let watched = watched.chain([LOCK.to_string()]);
    let mut lines: Vec<_> = watched
        .map(|path| format!("cargo:rerun-if-changed={path}"))
        .collect();
    let mut hash = Fnv::new();
    for module in CORE {
        for path in files(&Path::new("src").join(module))? {
            hash.update(path.to_string_lossy().as_bytes());
            hash.update(&fs::read(&path)?);
        }
    }
    hash.update(&fs::read(LOCK)?);
    let compiler = Command::new(variable("RUSTC")).arg("-vV").output()?;
    hash.update(&compiler.stdout);
    hash.update(variable("CARGO_CFG_TARGET_FEATURE").as_bytes());
    hash.update(variable("OPT_LEVEL").as_bytes());
    let (version, target) = (variable("CARGO_PKG_VERSION"), variable("TARGET"));
    let name = format!("{version} {:016x} {target}", hash.0);
    lines.push(format!("cargo:rustc-env=TOILE_BUILD={name}"));
    Ok(lines)
}

fn variable(name: &str) -> String {
    env::var(name).unwrap_or_default()
}

/// All files below a folder, sorted.
fn files(folder: &Path) -> io::Result<Vec<PathBuf>> {
    let mut entries = vec![];
    for entry in fs::read_dir(folder)? {
        entries.push(entry?.path());
    }
    entries.sort();
    let mut found = vec![];
    for path in entries {
        match path.is_dir() {
            true => found.extend(files(&path)?),
            false => found.push(path),
        }
    }
    Ok(found)
}

/// FNV-1a, 64 bits: enough to tell builds apart, and the same in every version of Rust.
struct Fnv(u64);

impl Fnv {
    fn new() -> Self {
        Self(0xcbf2_9ce4_8422_2325)
    }

    fn update(&mut self, bytes: &[u8]) {
        for byte in bytes {
            self.0 = (self.0 ^ u64::from(*byte)).wrapping_mul(0x0000_0100_0000_01b3);
        }
    }
}
