//! What a recording says of its making: enough to know whether a replay can give the same bits.

use std::collections::BTreeMap;
use std::fs;

use serde::Serialize;

use super::Pace;
use crate::sim::Model;

/// What a recording says of its making.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize)]
pub struct About {
    /// Version of toile.
    pub version: String,
    /// Name of the build: version, hash of what decides the bits, target.
    pub build: String,
    /// Processor, with the vector extensions that the arithmetic uses.
    pub processor: String,
    /// Name of the scene.
    pub scene: String,
    /// Name of the fabric.
    pub fabric: String,
    /// Pace of the run.
    pub pace: String,
    /// Whether the run started paused.
    pub paused: bool,
}

impl About {
    /// Of a run that this build starts here.
    pub fn run(model: &Model, pace: Pace, paused: bool) -> Self {
        Self {
            version: env!("CARGO_PKG_VERSION").to_string(),
            build: env!("TOILE_BUILD").to_string(),
            processor: processor(),
            scene: model.scene.name.clone(),
            fabric: model.fabric.name.clone(),
            pace: pace.to_string(),
            paused,
        }
    }

    /// Whether two runs of the same scene and commands must agree to the last bit.
    pub fn same_bits(&self, other: &About) -> bool {
        self.build == other.build && self.processor == other.processor
    }

    /// As it stands in a recording.
    pub(super) fn to_metadata(&self) -> BTreeMap<String, String> {
        let start = if self.paused { PAUSED } else { "running" };
        [
            ("version", &self.version),
            ("build", &self.build),
            ("processor", &self.processor),
            ("scene", &self.scene),
            ("fabric", &self.fabric),
            ("pace", &self.pace),
            ("start", &start.to_string()),
        ]
        .map(|(key, value)| (key.to_string(), value.clone()))
        .into()
    }

    /// As read from a recording; what is missing is empty.
    pub(super) fn from_metadata(metadata: &BTreeMap<String, String>) -> Self {
        let get = |key: &str| metadata.get(key).cloned().unwrap_or_default();
        Self {
            version: get("version"),
            build: get("build"),
            processor: get("processor"),
            scene: get("scene"),
            fabric: get("fabric"),
            pace: get("pace"),
            paused: get("start") == PAUSED,
        }
    }
}

/// Start of a run that waits for somebody to say go.
const PAUSED: &str = "paused";

/// Model name and vector extensions. The bits depend on both: kernels are chosen by the extensions, their blocks
/// by the caches.
fn processor() -> String {
    let info = fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
    let name = info.lines().find_map(|line| {
        let (key, value) = line.split_once(':')?;
        (key.trim() == "model name").then(|| value.trim().to_string())
    });
    let name = name.unwrap_or_else(|| format!("unknown {}", std::env::consts::ARCH));
    format!("{name} ({})", extensions().join(" "))
}

#[cfg(target_arch = "x86_64")]
fn extensions() -> Vec<&'static str> {
    let mut found = vec![];
    if std::is_x86_feature_detected!("avx2") {
        found.push("avx2");
    }
    if std::is_x86_feature_detected!("fma") {
        found.push("fma");
    }
    if std::is_x86_feature_detected!("avx512f") {
        found.push("avx512f");
    }
    found
}

#[cfg(not(target_arch = "x86_64"))]
fn extensions() -> Vec<&'static str> {
    vec![]
}
