//! Forces that hang on the sheet.

use serde::{Deserialize, Serialize};

use super::spec::Region;

/// A dead load: a force of constant size and direction, spread over a part of the sheet. On a part of the boundary it
/// is spread by length, elsewhere by area.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LoadSpec {
    /// The part of the sheet that bears it.
    pub region: Region,
    /// Its sum, in world axes \[N\].
    pub force: [f64; 3],
}
