//! What rerun and Foxglove need to show a recording at once, carried in the binary.
//!
//! Foxglove and its open fork hide topics until a layout shows them: import `toile_layout.json`. rerun draws the
//! state as points and the obstacles by itself; for the surface and the plots it needs the blueprint, which it
//! applies to a converted file of the same application id only:
//!
//! ```text
//! rerun mcap convert FILE.mcap --application-id toile -o FILE.rrd && rerun FILE.rrd toile.rbl
//! ```
//!
//! `make_blueprint.py` beside this file makes the blueprint, for rerun 0.41.

use std::fs;
use std::path::{Path, PathBuf};

use super::NodeError;

/// Blueprint for rerun 0.41.
pub const RERUN_BLUEPRINT: &[u8] = include_bytes!("viewers/toile.rbl");
/// Layout for Foxglove and its open fork.
pub const FOXGLOVE_LAYOUT: &str = include_str!("viewers/toile_layout.json");

/// Writes both into a directory, which is made if missing; returns their paths.
pub fn write(directory: &Path) -> Result<[PathBuf; 2], NodeError> {
    fs::create_dir_all(directory).map_err(NodeError::file("create directory", directory))?;
    let save = |name: &str, content: &[u8]| -> Result<PathBuf, NodeError> {
        let path = directory.join(name);
        fs::write(&path, content).map_err(NodeError::file("write", &path))?;
        Ok(path)
    };
    Ok([
        save("toile.rbl", RERUN_BLUEPRINT)?,
        save("toile_layout.json", FOXGLOVE_LAYOUT.as_bytes())?,
    ])
}
