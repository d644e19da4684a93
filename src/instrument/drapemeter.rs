//! The drapemeter (Cusick; ISO 9073-9; the paper's (21), Fig. 12-16 and Table 4): a disc of cloth hangs over a smaller
//! plate, and the part of the ring that its shadow covers is the drape coefficient.
//!
//! ```text
//!          ____________
//!         /|___plate___|\        the disc is clamped between two plates, or rests on one
//!        / |           | \
//! ```
//!
//! A drape has many stable states: a reading is a mean over several starts and meshes, and every state is a tested
//! minimum of the energy.

mod folds;
pub mod paper;
mod shadow;

use serde::{Deserialize, Serialize};

use super::{Curve, Diagram, Instrument, Mark, MeasureError, Reading, Report, Settings};
use crate::fabric::Fabric;
use crate::scene::{FabricSpec, Override, library, parse};
use crate::sim::Simulation;
pub use folds::{Fold, PROMINENCE, find as fold_list};
pub use shadow::{DIRECTIONS, RAYS, Shadow};

/// How the disc is held.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Hold {
    /// A second plate clamps it: it leaves the edge level.
    #[default]
    Clamped,
    /// It lies on the plate, held by friction.
    Resting,
}

impl Hold {
    /// Both.
    pub const ALL: [Hold; 2] = [Hold::Clamped, Hold::Resting];

    /// The word on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Hold::Clamped => "clamped",
            Hold::Resting => "resting",
        }
    }

    /// The built-in scene that it is a case of.
    fn scene(self) -> &'static str {
        match self {
            Hold::Clamped => "drapemeter",
            Hold::Resting => "drapemeter-resting",
        }
    }
}

/// Part of the ring that hangs in which sharp ridges run round the plate and hold most of the bending.
const RIDGES: f64 = 0.25;
/// How far within the plate's edge a resting disc is refined, over the same.
const WITHIN: f64 = 0.1;

/// Sizes and starts of a drape test.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct DrapeSettings {
    /// How the disc is held.
    pub hold: Hold,
    /// Diameter of the plate \[m\].
    pub plate: f64,
    /// Diameter of the specimen \[m\].
    pub specimen: f64,
    /// Triangles of the mesh: of the ring that hangs if clamped, of the whole disc if resting.
    pub triangles: usize,
    /// Starts, each with its own mesh.
    pub seeds: u64,
    /// Of the plate, resting only \[-\].
    pub friction: f64,
}

impl Default for DrapeSettings {
    /// The paper's apparatus and mesh.
    fn default() -> Self {
        Self {
            hold: Hold::Clamped,
            plate: 0.15,
            specimen: 0.25,
            triangles: 5750,
            seeds: 8,
            friction: 0.3,
        }
    }
}

/// One state of rest of a disc.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Drape {
    /// Of perturbation and mesh.
    pub seed: u64,
    /// Triangles of the mesh.
    pub triangles: usize,
    /// Drape coefficient by the area of the shadow, 0 to 1 \[-\].
    pub coefficient: f64,
    /// The same from the radii along 16 rays, (21) \[-\].
    pub coefficient_rays: f64,
    /// Folds.
    pub folds: usize,
    /// Mean reach of the folds beyond the plate's edge \[m\].
    pub fold_length: f64,
    /// Mean distance between the valleys on both sides of a fold \[m\].
    pub fold_width: f64,
    /// Mean height of a fold over its two valleys, in the shadow \[m\].
    pub fold_depth: f64,
    /// Elastic energy and that of the weight and of contact, none when flat \[J\].
    pub energy: f64,
    /// Frequency of the softest vibration about the state \[Hz\]; above zero it is a minimum of the energy.
    pub lowest_frequency: f64,
    /// Sum of the residual forces over the weight \[-\].
    pub residual: f64,
    /// Saddles left on the way.
    pub saddles: u64,
    /// Steps of the flow to it.
    pub flow_steps: u64,
    /// Largest membrane strain \[-\].
    pub largest_strain: f64,
    /// Radius of the shadow in [`DIRECTIONS`] directions, the first along the warp \[m\]. Not kept in tables.
    #[serde(skip)]
    pub outline: Vec<f64>,
}

/// Lets one disc drape and reads it.
///
/// # Errors
/// A setting is out of range, or no state of rest was found.
pub fn drape(fabric: &FabricSpec, set: &DrapeSettings, seed: u64) -> Result<Drape, MeasureError> {
    check(set)?;
    let mut simulation = Simulation::new(&scene(fabric, set, seed)?, 1)?;
    let report = simulation.step()?.clone();
    let (plate, rim) = (0.5 * set.plate, 0.5 * set.specimen);
    let shadow = Shadow::of(&simulation.model().mesh, &simulation.state().positions);
    let folds = folds::find(&shadow, rim - plate);
    let mean = |of: fn(&Fold) -> f64| match folds.len() {
        0 => 0.0,
        count => folds.iter().map(of).sum::<f64>() / count as f64,
    };
    let energies = &report.energies;
    let found = simulation.equilibrium().copied().unwrap_or_default();
    Ok(Drape {
        seed,
        triangles: simulation.model().mesh.faces.len(),
        coefficient: shadow.coefficient(plate, rim),
        coefficient_rays: shadow.coefficient_by_rays(plate, rim),
        folds: folds.len(),
        fold_length: match folds.len() {
            0 => 0.0,
            _ => mean(|fold| fold.tip) - plate,
        },
        fold_width: mean(|fold| fold.width),
        fold_depth: mean(|fold| fold.depth),
        energy: energies.stretch + energies.bend + energies.gravity + energies.contact,
        lowest_frequency: found.lowest_frequency,
        residual: found.residual,
        saddles: found.saddles,
        flow_steps: found.flow_steps,
        largest_strain: report.largest_strain,
        outline: shadow.radii,
    })
}

/// The built-in scene with the sizes, the fabric and the start put in.
fn scene(
    fabric: &FabricSpec,
    set: &DrapeSettings,
    seed: u64,
) -> Result<crate::scene::Scene, MeasureError> {
    let constants = toml::Table::try_from(fabric).expect("a fabric is TOML");
    let mut values: Vec<(String, String)> = constants
        .into_iter()
        .map(|(key, value)| (format!("fabric.{key}"), value.to_string()))
        .collect();
    let outline = match set.hold {
        Hold::Clamped => format!(
            "{{ kind = \"annulus\", outer = {:?}, inner = {:?} }}",
            set.specimen, set.plate
        ),
        Hold::Resting => format!("{{ kind = \"disc\", diameter = {:?} }}", set.specimen),
    };
    values.push(("sheet.outline".into(), outline));
    let ridges = format!(
        "{{ kind = \"ring\", outer = {:?}, inner = {:?} }}",
        set.plate + RIDGES * (set.specimen - set.plate),
        set.plate - WITHIN * (set.specimen - set.plate)
    );
    values.push(("sheet.refine.region".into(), ridges));
    values.push(("sheet.triangles".into(), set.triangles.to_string()));
    for key in ["sheet.mesh_seed", "perturbation.seed"] {
        values.push((key.into(), seed.to_string()));
    }
    match set.hold {
        Hold::Clamped => {
            let region = format!("{{ kind = \"disc\", diameter = {:?} }}", set.plate);
            values.push(("support.plates.region".into(), region));
        }
        Hold::Resting => {
            let shape = format!(
                "{{ kind = \"cylinder\", radius = {:?}, length = 0.02 }}",
                0.5 * set.plate
            );
            values.push(("obstacle.plate.shape".into(), shape));
            values.push((
                "obstacle.plate.friction".into(),
                format!("{:?}", set.friction),
            ));
        }
    }
    let overrides: Vec<Override> = values
        .iter()
        .map(|(key, value)| Override::new(key, value, &format!("{key} = {value}")))
        .collect();
    let text = library::text(set.hold.scene()).expect("a built-in scene");
    Ok(parse(text, &overrides)?.0)
}

fn check(set: &DrapeSettings) -> Result<(), MeasureError> {
    let sizes = [
        ("plate", set.plate, 1e-2, 1.0, "m"),
        ("specimen", set.specimen, 1e-2, 2.0, "m"),
        ("friction", set.friction, 0.0, 10.0, ""),
        ("seeds", set.seeds as f64, 1.0, 1e3, ""),
        ("triangles", set.triangles as f64, 100.0, 1e5, ""),
    ];
    for (field, value, min, max, unit) in sizes {
        if !(value >= min && value <= max) {
            let allowed = format!("from {min} to {max} {unit}");
            return Err(MeasureError::setting(field, value, allowed.trim_end()));
        }
    }
    if set.specimen < 1.05 * set.plate {
        let allowed = format!(
            "at least {} m, 5 % more than the plate of {} m",
            (1.05e4 * set.plate).ceil() * 1e-4,
            set.plate
        );
        return Err(MeasureError::setting("specimen", set.specimen, allowed));
    }
    Ok(())
}

pub(super) fn measure(fabric: &FabricSpec, settings: &Settings) -> Result<Report, MeasureError> {
    let resolved = fabric.resolve()?;
    let set = &settings.drape;
    check(set)?;
    let drapes: Vec<Drape> = (1..=set.seeds)
        .map(|seed| drape(fabric, set, seed))
        .collect::<Result<_, _>>()?;
    let read = |name: &str, unit, of: &dyn Fn(&Drape) -> f64| {
        let values: Vec<f64> = drapes.iter().map(of).collect();
        Reading::new(name, unit, &values, None)
    };
    let edge = edge(set);
    Ok(Report {
        instrument: Instrument::Drapemeter,
        fabric: resolved.name.clone(),
        direction: settings.direction,
        specimen: [set.specimen, set.plate],
        set_up: match set.hold {
            Hold::Clamped => "clamped between two plates".to_string(),
            Hold::Resting => format!("resting on one plate, friction {}", set.friction),
        },
        edge,
        triangles: drapes[0].triangles,
        meshes: set.seeds,
        residual: drapes.iter().map(|d| d.residual).fold(0.0, f64::max),
        readings: vec![
            read("drape coefficient, shadow", "%", &|d| 1e2 * d.coefficient),
            read("drape coefficient, 16 rays (21)", "%", &|d| {
                1e2 * d.coefficient_rays
            }),
            read("folds", "", &|d| d.folds as f64),
            read("fold length", "m", &|d| d.fold_length),
            read("fold width", "m", &|d| d.fold_width),
            read("fold depth", "m", &|d| d.fold_depth),
            read("energy", "J", &|d| d.energy),
            read("lowest frequency", "Hz", &|d| d.lowest_frequency),
        ],
        warnings: warnings(&resolved, edge),
        diagram: diagram(&drapes, set),
        drapes,
    })
}

/// Edge length of equilateral triangles of the mesh \[m\].
fn edge(set: &DrapeSettings) -> f64 {
    use std::f64::consts::FRAC_PI_4;
    let hole = match set.hold {
        Hold::Clamped => set.plate,
        Hold::Resting => 0.0,
    };
    let area = FRAC_PI_4 * (set.specimen.powi(2) - hole.powi(2));
    (4.0 * area / (3f64.sqrt() * set.triangles as f64)).sqrt()
}

fn warnings(fabric: &Fabric, edge: f64) -> Vec<String> {
    let length = fabric.bending_length(9.81);
    if edge <= 0.5 * length {
        return vec![];
    }
    vec![format!(
        "the mesh's edges of {:.2} mm are longer than half the bending length of {:.2} mm: the drape coefficient may \
         be off by several points",
        1e3 * edge,
        1e3 * length
    )]
}

/// The shadow's outline, as on the paper ring of a Cusick drapemeter: the state nearest to the mean.
fn diagram(drapes: &[Drape], set: &DrapeSettings) -> Diagram {
    let mean = drapes.iter().map(|d| d.coefficient).sum::<f64>() / drapes.len() as f64;
    let off = |d: &&Drape| (d.coefficient - mean).abs();
    let typical = drapes
        .iter()
        .min_by(|a, b| off(a).total_cmp(&off(b)))
        .expect("at least one seed");
    let around = |radius: &dyn Fn(usize) -> f64| -> Vec<[f64; 2]> {
        (0..=DIRECTIONS)
            .map(|k| {
                let (sin, cos) = Shadow::angle(k).sin_cos();
                let r = 1e3 * radius(k % DIRECTIONS);
                [r * cos, r * sin]
            })
            .collect()
    };
    let curve = |name: String, mark, points| Curve { name, mark, points };
    let shadow = format!("shadow, seed {}", typical.seed);
    Diagram {
        x: "along the warp [mm]",
        y: "along the weft [mm]",
        shape: true,
        curves: vec![
            curve(shadow, Mark::Line, around(&|k| typical.outline[k])),
            curve("plate".into(), Mark::Dashes, around(&|_| 0.5 * set.plate)),
            curve("flat".into(), Mark::Dashes, around(&|_| 0.5 * set.specimen)),
        ],
    }
}
