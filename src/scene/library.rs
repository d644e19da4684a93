//! The built-in scenes, embedded so that the binary runs with nothing beside it.

/// Name and text of each, in the order of `toile list scenes`.
const SCENES: [(&str, &str); 15] = [
    ("drape-table", include_str!("library/drape-table.toml")),
    (
        "drape-table-air",
        include_str!("library/drape-table-air.toml"),
    ),
    ("free-fall", include_str!("library/free-fall.toml")),
    ("cantilever", include_str!("library/cantilever.toml")),
    ("four-edges", include_str!("library/four-edges.toml")),
    ("three-edges", include_str!("library/three-edges.toml")),
    ("held-point", include_str!("library/held-point.toml")),
    ("falling-sheet", include_str!("library/falling-sheet.toml")),
    (
        "drape-table-part",
        include_str!("library/drape-table-part.toml"),
    ),
    ("drape-podium", include_str!("library/drape-podium.toml")),
    ("drapemeter", include_str!("library/drapemeter.toml")),
    (
        "drapemeter-resting",
        include_str!("library/drapemeter-resting.toml"),
    ),
    ("towel-fold", include_str!("library/towel-fold.toml")),
    ("strip-release", include_str!("library/strip-release.toml")),
    ("fling", include_str!("library/fling.toml")),
];

/// Names of the built-in scenes.
pub fn names() -> impl Iterator<Item = &'static str> {
    SCENES.iter().map(|(name, _)| *name)
}

/// The TOML of a built-in scene, comments and all.
pub fn text(name: &str) -> Option<&'static str> {
    SCENES
        .iter()
        .find(|(known, _)| *known == name)
        .map(|(_, text)| *text)
}
