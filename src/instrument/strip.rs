//! A strip between two jaws, flat on a table without friction. The jaws hold the pulled direction only, so the strip
//! narrows and shears as it will and the strain is the same everywhere; at 45 degrees, too.
//!
//! ```text
//!   |==========================|-->  strain x length
//! ```

use super::specimen::{Cut, Rest};
use super::{Direction, MeasureError, Settings};
use crate::scene::FabricSpec;

/// Strains from which small-strain readings are extrapolated to none \[-\]; linear in them, so the rest is 1e-8.
const SMALL: [f64; 2] = [1e-4, 2e-4];
const LENGTH: f64 = 0.2;
const WIDTH: f64 = 0.05;

/// A strip that is pulled.
pub struct Strip<'a> {
    fabric: &'a FabricSpec,
    /// Of the fabric \[m\].
    thickness: f64,
    pub cut: Cut,
}

/// One pull.
pub struct Pull {
    /// Nominal stress: force over the width and thickness at rest \[Pa\].
    pub stress: f64,
    /// Extension across the pull over the width; negative if the strip narrows \[-\].
    pub across: f64,
    pub residual: f64,
    pub triangles: usize,
}

/// What a strip tends to at no strain.
pub struct Small {
    /// Stress over strain \[Pa\].
    pub modulus: f64,
    /// Contraction over extension \[-\].
    pub poisson: f64,
    pub residual: f64,
    pub triangles: usize,
}

impl<'a> Strip<'a> {
    pub fn new(
        fabric: &'a FabricSpec,
        direction: Direction,
        settings: &Settings,
        seed: u64,
    ) -> Result<Self, MeasureError> {
        let thickness = fabric.resolve()?.thickness;
        let (length, width) = (
            settings.length.unwrap_or(LENGTH),
            settings.width.unwrap_or(WIDTH),
        );
        let edge = settings.edge.unwrap_or(0.2 * length.min(width));
        let cut = Cut {
            direction,
            length,
            width,
            edge,
            seed,
        };
        cut.check()?;
        Ok(Self {
            fabric,
            thickness,
            cut,
        })
    }

    /// The same strip cut in another direction.
    pub fn of(other: &Strip<'a>, direction: Direction) -> Self {
        Self {
            cut: Cut {
                direction,
                ..other.cut
            },
            ..*other
        }
    }

    /// Pulls to a strain \[-\] and lets the strip come to rest.
    pub fn pull(&self, strain: f64) -> Result<Pull, MeasureError> {
        let Cut { length, width, .. } = self.cut;
        let (x, y) = (0.5 * length, 0.5 * width);
        let held = format!(
            "[support]\n\
             table = {{ kind = \"pin\", axes = \"z\", region = {{ kind = \"box\", min = [-{x:?}, -{y:?}], max = [{x:?}, {y:?}] }} }}\n\
             jaw = {{ kind = \"pin\", axes = \"x\", region = {{ kind = \"x-min\" }} }}\n\
             pulled = {{ kind = \"pin\", axes = \"x\", region = {{ kind = \"x-max\" }}, displacement = [{:?}, 0.0, 0.0] }}\n\
             still = {{ kind = \"pin\", axes = \"y\", region = {{ kind = \"point\", at = [-{x:?}, -{y:?}] }} }}\n",
            strain * length
        );
        let scene = self.cut.scene("strip", self.fabric, 0.0, &held);
        let rest = Rest::find(&scene, None)?;
        let margin = 1e-6 * length;
        let force = rest.force(|p| p.x > x - margin).x;
        let [low, high] = [-1.0, 1.0].map(|side| rest.place(|p| p.y * side > y - margin).y);
        Ok(Pull {
            stress: force / (width * self.thickness),
            across: (high - low) / width - 1.0,
            residual: rest.residual(),
            triangles: rest.triangles(),
        })
    }

    /// Pulls twice by next to nothing and extrapolates to nothing.
    pub fn small(&self) -> Result<Small, MeasureError> {
        let [one, two] = [self.pull(SMALL[0])?, self.pull(SMALL[1])?];
        let modulus = |pull: &Pull, strain: f64| pull.stress / strain;
        let poisson = |pull: &Pull, strain: f64| -pull.across / strain;
        let limit = |of: &dyn Fn(&Pull, f64) -> f64| 2.0 * of(&one, SMALL[0]) - of(&two, SMALL[1]);
        Ok(Small {
            modulus: limit(&modulus),
            poisson: limit(&poisson),
            residual: one.residual.max(two.residual),
            triangles: one.triangles,
        })
    }
}

/// How the strip is held, for the report.
pub const SET_UP: &str =
    "between jaws that hold the pulled direction only, flat on a table without friction";

/// Small-strain readings of one direction on every mesh.
pub fn small(
    fabric: &FabricSpec,
    direction: Direction,
    settings: &Settings,
) -> Result<Vec<Small>, MeasureError> {
    (0..settings.meshes)
        .map(|seed| Strip::new(fabric, direction, settings, seed)?.small())
        .collect()
}
