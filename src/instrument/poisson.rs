//! Poisson's ratio: contraction over extension of a pulled strip, the paper's (17) in strains, where the paper
//! divides displacements, which depends on how the specimen is cut.

use super::strip::{self, Strip};
use super::{Curve, Diagram, Direction, Instrument, Mark, MeasureError, Reading, Report, Settings};
use crate::fabric::identify::tension;
use crate::scene::FabricSpec;

const POINTS: usize = 6;

pub fn measure(fabric: &FabricSpec, settings: &Settings) -> Result<Report, MeasureError> {
    let resolved = fabric.resolve()?;
    let direction = settings.direction;
    let constants = tension(&resolved);
    let expected = match direction {
        Direction::Warp => constants.poisson[0],
        Direction::Weft => constants.poisson[1],
        // nu = 1 - E_bias A / 2 with A = S11 + S22 + 2 S12, by turning the compliance tensor.
        Direction::Bias => {
            let [warp, weft, bias] = constants.young;
            let normal = (1.0 - 2.0 * constants.poisson[0]) / warp + 1.0 / weft;
            1.0 - 0.5 * bias * normal
        }
    };
    let small = strip::small(fabric, direction, settings)?;
    let ratios: Vec<f64> = small.iter().map(|s| s.poisson).collect();
    let strip = Strip::new(fabric, direction, settings, 0)?;
    let mut points = vec![[0.0; 2]];
    let mut residual = small.iter().map(|s| s.residual).fold(0.0, f64::max);
    for k in 1..=POINTS {
        let strain = settings.strain * k as f64 / POINTS as f64;
        let pull = strip.pull(strain)?;
        residual = residual.max(pull.residual);
        points.push([1e2 * strain, -1e2 * pull.across]);
    }
    let at_strain = points[POINTS][1] / points[POINTS][0];
    let mut warnings = vec![];
    if direction != Direction::Bias && resolved.membrane().c12 == 0.0 {
        let said = "this fabric has no Poisson coupling (fabric.poisson = none): the ratio is zero by the model; \
                    --set fabric.poisson=symmetrised couples";
        warnings.push(said.to_string());
    }
    Ok(Report {
        instrument: Instrument::Poisson,
        fabric: resolved.name.clone(),
        direction,
        specimen: [strip.cut.length, strip.cut.width],
        set_up: strip::SET_UP.into(),
        edge: strip.cut.edge,
        triangles: small[0].triangles,
        meshes: settings.meshes,
        residual,
        readings: vec![
            Reading::new("Poisson's ratio at no strain", "-", &ratios, Some(expected)),
            Reading::new(
                "contraction over extension at the strain",
                "-",
                &[at_strain],
                None,
            ),
        ],
        warnings,
        drapes: vec![],
        diagram: Diagram {
            x: "nominal strain along the pull [%]",
            y: "contraction across it [%]",
            shape: false,
            curves: vec![Curve {
                name: "measured".into(),
                mark: Mark::Dots,
                points,
            }],
        },
    })
}
