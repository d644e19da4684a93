//! What rerun and Foxglove need to show a recording at once.

use std::path::Path;
