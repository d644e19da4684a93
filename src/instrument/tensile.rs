//! Tension: nominal stress at a strain, and the modulus at none, the paper's (12) read backwards.

use super::strip::{self, Strip};
use super::{Curve, Diagram, Direction, Instrument, Mark, MeasureError, Reading, Report, Settings};
use crate::fabric::identify::tension;
use crate::scene::FabricSpec;

/// Points of the stress-strain curve.
const POINTS: usize = 6;

pub fn measure(fabric: &FabricSpec, settings: &Settings) -> Result<Report, MeasureError> {
    let resolved = fabric.resolve()?;
    let direction = settings.direction;
    let [warp, weft, bias] = tension(&resolved).young;
    let expected = match direction {
        Direction::Warp => warp,
        Direction::Weft => weft,
        Direction::Bias => bias,
    };
    let small = strip::small(fabric, direction, settings)?;
    let mut residual = small.iter().map(|s| s.residual).fold(0.0, f64::max);
    let strips: Vec<Strip> = (0..settings.meshes)
        .map(|seed| Strip::new(fabric, direction, settings, seed))
        .collect::<Result<_, _>>()?;
    let mut stresses = vec![];
    for strip in &strips {
        let pull = strip.pull(settings.strain)?;
        residual = residual.max(pull.residual);
        stresses.push(pull.stress);
    }
    let moduli: Vec<f64> = small.iter().map(|s| s.modulus).collect();
    let [secants, forces] = [1.0 / settings.strain, resolved.thickness]
        .map(|factor| stresses.iter().map(|s| s * factor).collect::<Vec<_>>());
    Ok(Report {
        instrument: Instrument::Tensile,
        fabric: resolved.name.clone(),
        direction,
        specimen: [strips[0].cut.length, strips[0].cut.width],
        set_up: strip::SET_UP.into(),
        edge: strips[0].cut.edge,
        triangles: small[0].triangles,
        meshes: settings.meshes,
        residual,
        readings: vec![
            Reading::new("modulus at no strain", "Pa", &moduli, Some(expected)),
            Reading::new("nominal stress at the strain", "Pa", &stresses, None),
            Reading::new("force per width at the strain", "N/m", &forces, None),
            Reading::new("secant modulus at the strain", "Pa", &secants, None),
        ],
        warnings: vec![],
        drapes: vec![],
        diagram: diagram(&strips[0], settings, moduli[0], stresses[0])?,
    })
}

fn diagram(
    strip: &Strip,
    settings: &Settings,
    modulus: f64,
    last: f64,
) -> Result<Diagram, MeasureError> {
    let mut points = vec![[0.0; 2]];
    for k in 1..POINTS {
        let strain = settings.strain * k as f64 / POINTS as f64;
        points.push([1e2 * strain, 1e-3 * strip.pull(strain)?.stress]);
    }
    points.push([1e2 * settings.strain, 1e-3 * last]);
    let tangent = [0.0, settings.strain].map(|e| [1e2 * e, 1e-3 * modulus * e]);
    let curve = |name: &str, mark, points| Curve {
        name: name.into(),
        mark,
        points,
    };
    Ok(Diagram {
        x: "nominal strain [%]",
        y: "nominal stress [kPa]",
        shape: false,
        curves: vec![
            curve("measured", Mark::Dots, points),
            curve("modulus at no strain", Mark::Dashes, tangent.to_vec()),
        ],
    })
}
