//! The key table: every key of a scene, its type, and the one place where its range stands.
//!
//! The ranges refuse what cannot be meant (a metre-thick cloth, a step of an hour); what is physically
//! possible but unwise is left to warnings. `tests/it/scene.rs` holds this table against the serde types.

use super::quantity::{Range, range};
use super::ranges::{
    FLUID_DAMPING, FRICTION, MESH_SCALE, PLACE, SIZE, SPEED, TIME, TURN_RATE, WIND,
};

/// One key of a table.
pub(super) struct Key {
    pub name: &'static str,
    pub required: bool,
    pub kind: Kind,
}

/// What a key may hold.
pub(super) enum Kind {
    /// A number; whole numbers are taken as floats.
    Number(Range),
    /// A whole number.
    Count(i64, i64),
    /// An array of this many numbers.
    Vector(usize, Range),
    /// An array of pairs, at least one.
    Points(Range),
    /// An array of numbers, at least one.
    Series(Range),
    /// An array of arrays of three numbers, at least one.
    Triples(Range),
    /// An array of arrays of three whole numbers, at least one.
    Corners,
    /// One line of text of at most this many characters.
    Text(usize),
    /// A name that can be part of a file name.
    FileName,
    /// A non-empty set of the letters x, y, z.
    Axes,
    /// One of these words.
    Choice(&'static [&'static str]),
    /// An array of some of these words, each at most once.
    Some(&'static [&'static str]),
    /// A table with these keys.
    Table(&'static [Key]),
    /// A table of tables, each with a name of the user's choice and these keys.
    Named(&'static [Key]),
    /// A table whose `kind` says which other keys it has.
    Tagged(&'static [(&'static str, &'static [Key])]),
}

const fn need(name: &'static str, kind: Kind) -> Key {
    Key {
        name,
        required: true,
        kind,
    }
}

const fn may(name: &'static str, kind: Kind) -> Key {
    Key {
        name,
        required: false,
        kind,
    }
}

use Kind::{
    Axes, Choice, Corners, Count, FileName, Named, Number, Points, Series, Table, Tagged, Text,
    Triples, Vector,
};

/// Angles of poses.
const ANGLE: Range = range(-360.0, 360.0, "degrees");
/// Any seed that TOML can hold.
const SEED: Kind = Count(0, i64::MAX);

/// The document.
pub(super) const SCENE: &[Key] = &[
    need("name", FileName),
    need("description", Text(200)),
    need("duration", Number(range(1e-6, 1e5, "s"))),
    may("gravity", Vector(3, range(-1e3, 1e3, "m/s²"))),
    may("damping", Number(range(0.0, 1e4, "kg/(m²·s)"))),
    may("accept", Kind::Some(&["obstacles", "air"])),
    need("sheet", Table(SHEET)),
    need("fabric", Table(FABRIC)),
    may("support", Named(SUPPORT)),
    may("load", Named(LOAD)),
    may("obstacle", Named(OBSTACLE)),
    may("overlap", Table(OVERLAP)),
    may("air", Table(AIR)),
    may("layers", Table(LAYERS)),
    may("sleep", Table(SLEEP)),
    may("perturbation", Table(PERTURBATION)),
    may("method", Table(METHOD)),
    may("output", Table(OUTPUT)),
    may("observe", Named(OBSERVE)),
];

const SHEET: &[Key] = &[
    need("outline", Tagged(OUTLINE)),
    may("triangles", Count(2, 2_000_000)),
    may("edge", Number(range(1e-6, 10.0, "m"))),
    may("refine", Table(REFINE)),
    may("jitter", Number(range(0.0, 0.3, "edge lengths"))),
    may("mesh_seed", SEED),
    may("warp_angle", Number(ANGLE)),
    may("position", Vector(3, PLACE)),
    may("rotation", Vector(3, ANGLE)),
];

const REFINE: &[Key] = &[
    need("region", Tagged(REGION)),
    need("factor", Number(range(0.02, 1.0, ""))),
];

const OUTLINE: &[(&str, &[Key])] = &[
    (
        "rectangle",
        &[need("length", Number(SIZE)), need("width", Number(SIZE))],
    ),
    ("disc", &[need("diameter", Number(SIZE))]),
    (
        "annulus",
        &[need("outer", Number(SIZE)), need("inner", Number(SIZE))],
    ),
    (
        "sector",
        &[
            need("outer", Number(SIZE)),
            need("inner", Number(SIZE)),
            need("angle", Number(range(1.0, 359.9, "degrees"))),
        ],
    ),
];

const FABRIC: &[Key] = &[
    need("name", Text(64)),
    may("areal_density", Number(range(1e-4, 100.0, "kg/m²"))),
    may("thickness", Number(range(1e-6, 0.1, "m"))),
    may("young_warp", Number(range(1.0, 1e13, "Pa"))),
    may("young_weft", Number(range(1.0, 1e13, "Pa"))),
    may("shear_modulus", Number(range(1.0, 1e13, "Pa"))),
    may("rigidity_warp", Number(range(1e-12, 1e3, "N·m"))),
    may("rigidity_weft", Number(range(1e-12, 1e3, "N·m"))),
    may("poisson_warp", Number(range(0.0, 10.0, ""))),
    may("poisson_weft", Number(range(0.0, 10.0, ""))),
    may("twist", Choice(&["geometric", "none"])),
    may("poisson", Choice(&["none", "symmetrised"])),
];

const SUPPORT: &[Key] = &[
    need("kind", Choice(&["pin", "clamp"])),
    need("region", Tagged(REGION)),
    may("axes", Axes),
    may("displacement", Vector(3, PLACE)),
    may("motion", Table(SUPPORT_MOTION)),
];

const LOAD: &[Key] = &[
    need("region", Tagged(REGION)),
    need("force", Vector(3, range(-1e6, 1e6, "N"))),
];

const SUPPORT_MOTION: &[Key] = &[
    may("law", Choice(LAWS)),
    need("times", Series(TIME)),
    may("displacements", Triples(PLACE)),
    may("rotations", Triples(ANGLE)),
];

const LAWS: &[&str] = &["linear", "smooth"];

const REGION: &[(&str, &[Key])] = &[
    ("x-min", &[]),
    ("x-max", &[]),
    ("y-min", &[]),
    ("y-max", &[]),
    ("boundary", &[]),
    (
        "box",
        &[need("min", Vector(2, PLACE)), need("max", Vector(2, PLACE))],
    ),
    ("disc", &[need("diameter", Number(SIZE))]),
    (
        "ring",
        &[need("outer", Number(SIZE)), need("inner", Number(SIZE))],
    ),
    ("point", &[need("at", Vector(2, PLACE))]),
];

const OBSTACLE: &[Key] = &[
    need("shape", Tagged(SHAPE)),
    may("position", Vector(3, PLACE)),
    may("rotation", Vector(3, ANGLE)),
    may("linear_velocity", Vector(3, SPEED)),
    may("angular_velocity", Vector(3, TURN_RATE)),
    may("friction", Number(FRICTION)),
    may("friction_static", Number(FRICTION)),
    may("motion", Table(OBSTACLE_MOTION)),
];

const OBSTACLE_MOTION: &[Key] = &[
    may("law", Choice(LAWS)),
    need("times", Series(TIME)),
    may("positions", Triples(PLACE)),
    may("rotations", Triples(ANGLE)),
];

const OVERLAP: &[Key] = &[
    may("rule", Choice(&["push-out", "refuse"])),
    may("time", Number(range(1e-3, 10.0, "s"))),
    may("speed", Number(range(1e-3, 10.0, "m/s"))),
];

const SHAPE: &[(&str, &[Key])] = &[
    ("plane", &[]),
    ("box", &[need("size", Vector(3, SIZE))]),
    ("sphere", &[need("radius", Number(SIZE))]),
    ("disc", &[need("radius", Number(SIZE))]),
    (
        "cylinder",
        &[need("radius", Number(SIZE)), need("length", Number(SIZE))],
    ),
    (
        "capsule",
        &[need("radius", Number(SIZE)), need("length", Number(SIZE))],
    ),
    (
        "mesh",
        &[
            may("file", Text(1000)),
            may("scale", Number(MESH_SCALE)),
            may("vertices", Triples(PLACE)),
            may("triangles", Corners),
        ],
    ),
];

const AIR: &[Key] = &[
    need("fluid_damping", Number(FLUID_DAMPING)),
    may("velocity", Vector(3, WIND)),
    may("region", Table(AIR_REGION)),
    may("rise", Number(TIME)),
    may("start", Number(TIME)),
    may("hold", Number(TIME)),
];

const AIR_REGION: &[Key] = &[need("min", Vector(3, PLACE)), need("max", Vector(3, PLACE))];

const LAYERS: &[Key] = &[
    may("contact", Choice(&["on", "off"])),
    may("friction", Number(FRICTION)),
    may("thickness", Number(range(1e-6, 0.1, "m"))),
];

const SLEEP: &[Key] = &[
    may("speed", Number(range(1e-9, 1.0, "m/s"))),
    may("acceleration", Number(range(1e-6, 10.0, "m/s²"))),
];

const PERTURBATION: &[Key] = &[
    may("amplitude", Number(range(0.0, 0.1, "m"))),
    may("seed", SEED),
    may("fade", Number(range(0.0, 1.0, "m"))),
];

const METHOD: &[Key] = &[
    may("scheme", Choice(SCHEMES)),
    may("solver", Choice(&["newton", "quasi-newton", "xpbd"])),
    may("dt", Number(range(1e-7, 1.0, "s"))),
    may("tolerance", Number(range(1e-14, 0.1, "of the weight"))),
    may("max_iterations", Count(1, 10_000)),
    may("substep", Number(range(1e-9, 1.0, "s"))),
    may("step_tolerance", Number(range(1e-9, 0.1, "m"))),
    may("limit", Choice(&["keep", "ignore"])),
    may("coarsest", Count(50, 2_000_000)),
    may("rho_infinity", Number(range(0.0, 1.0, ""))),
];

const SCHEMES: &[&str] = &[
    "backward-euler",
    "bdf2",
    "generalised-alpha",
    "central-difference",
    "equilibrium",
];

const OUTPUT: &[Key] = &[
    may("rate", Number(range(1e-3, 1e6, "Hz"))),
    may("mesh_rate", Number(range(0.0, 1e6, "Hz"))),
    may("keyframe_interval", Number(range(0.0, 1e5, "s"))),
];

const OBSERVE: &[Key] = &[
    may("points", Points(PLACE)),
    may("region", Tagged(REGION)),
    need("axis", Choice(&["x", "y", "z"])),
];

impl Kind {
    /// What the key takes, as it stands after "must be" in a message.
    pub(super) fn expected(&self) -> String {
        match self {
            Number(range) => format!("a number {range}"),
            Count(min, i64::MAX) => format!("a whole number from {min} to 2^63 - 1"),
            Count(min, max) => format!("a whole number from {min} to {max}"),
            Vector(count, range) => format!("an array of {count} numbers {range}"),
            Points(range) => format!("an array of [x, y] pairs {range}, at least one"),
            Series(range) => format!("an array of numbers {range}, at least one"),
            Triples(range) => {
                format!("an array of [x, y, z] triples {range}, at least one")
            }
            Corners => "an array of [i, j, k] whole numbers from 0, at least one".to_string(),
            Text(longest) => format!("one line of text, 1 to {longest} characters"),
            FileName => "1 to 64 letters, digits, `-` or `_`, a letter or digit first".to_string(),
            Axes => "some of the letters x, y, z, each at most once".to_string(),
            Choice(words) => format!("one of {}", words.join(", ")),
            Kind::Some(words) => {
                format!(
                    "an array of some of {}, each at most once",
                    words.join(", ")
                )
            }
            Table(keys) => format!("a table of {}", names(keys)),
            Named(keys) => format!("a table of named tables of {}", names(keys)),
            Tagged(variants) => {
                let kinds: Vec<_> = variants.iter().map(|(kind, _)| *kind).collect();
                format!("a table with kind = one of {}", kinds.join(", "))
            }
        }
    }
}

/// The names of some keys, for a message.
pub(super) fn names(keys: &[Key]) -> String {
    let names: Vec<_> = keys.iter().map(|key| key.name).collect();
    names.join(", ")
}
