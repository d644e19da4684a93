//! The shear modulus from tensions in warp, weft and bias: equation (18) as printed, and in tensor form, where
//! each Poisson ratio stands over its own modulus.

use super::strip::{self, Small, Strip};
use super::{Curve, Diagram, Direction, Instrument, Mark, MeasureError, Reading, Report, Settings};
use crate::fabric::identify::{Tension, shear};
use crate::scene::FabricSpec;

const CUTS: [Direction; 3] = [Direction::Warp, Direction::Weft, Direction::Bias];

pub fn measure(fabric: &FabricSpec, settings: &Settings) -> Result<Report, MeasureError> {
    let resolved = fabric.resolve()?;
    let mut pulls = vec![];
    for cut in CUTS {
        pulls.push(strip::small(fabric, cut, settings)?);
    }
    let tests: Vec<Tension> = (0..settings.meshes as usize)
        .map(|k| Tension {
            young: [0, 1, 2].map(|cut| pulls[cut][k].modulus),
            poisson: [0, 1].map(|cut| pulls[cut][k].poisson),
        })
        .collect();
    let moduli = |of: &dyn Fn(&Tension) -> Option<f64>| -> Vec<f64> {
        // No positive modulus is no reading.
        tests.iter().map(|t| of(t).unwrap_or(f64::NAN)).collect()
    };
    let consistent = moduli(&|t| shear(t).consistent);
    let printed = moduli(&|t| shear(t).printed);
    let bias = moduli(&|t| Some(t.young[2]));
    let strip = Strip::new(fabric, Direction::Bias, settings, 0)?;
    let all = || pulls.iter().flatten();
    Ok(Report {
        instrument: Instrument::Shear,
        fabric: resolved.name.clone(),
        direction: Direction::Bias,
        specimen: [strip.cut.length, strip.cut.width],
        set_up: format!("three strips, warp, weft and bias, each {}", strip::SET_UP),
        edge: strip.cut.edge,
        triangles: pulls[2][0].triangles,
        meshes: settings.meshes,
        residual: all().map(|s: &Small| s.residual).fold(0.0, f64::max),
        readings: vec![
            Reading::new(
                "shear modulus, (18) in tensor form",
                "Pa",
                &consistent,
                Some(resolved.shear_modulus),
            ),
            Reading::new("shear modulus, (18) as printed", "Pa", &printed, None),
            Reading::new("bias modulus at no strain", "Pa", &bias, None),
        ],
        warnings: vec![],
        drapes: vec![],
        diagram: diagram(&strip, settings)?,
    })
}

/// Stress of the three cuts up to the strain.
fn diagram(bias: &Strip, settings: &Settings) -> Result<Diagram, MeasureError> {
    const POINTS: usize = 4;
    let mut curves = vec![];
    for direction in CUTS {
        let strip = Strip::of(bias, direction);
        let mut points = vec![[0.0; 2]];
        for k in 1..=POINTS {
            let strain = settings.strain * k as f64 / POINTS as f64;
            points.push([1e2 * strain, 1e-3 * strip.pull(strain)?.stress]);
        }
        curves.push(Curve {
            name: direction.name().into(),
            mark: Mark::Line,
            points,
        });
    }
    Ok(Diagram {
        x: "nominal strain [%]",
        y: "nominal stress [kPa]",
        shape: false,
        curves,
    })
}
