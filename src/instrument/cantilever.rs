//! The cantilever test (ASTM D1388, ISO 9073-7; the paper's (19)-(20)): a strip is pushed over the edge of a platform
//! until the chord from the edge to its end hangs at 41.5 degrees. The overhang then gives bending length and flexural
//! rigidity, by the exact heavy elastica and by Peirce's formula.
//!
//! ```text
//!   platform ====+---.__        the part on the platform stands for a clamp: it lies flat
//!                 \      `.
//!             41.5 \       |
//! ```

use nalgebra::Vector3;

use super::specimen::{Cut, Rest};
use super::{Curve, Diagram, Direction, Instrument, Mark, MeasureError, Reading, Report, Settings};
use crate::fabric::Fabric;
use crate::fabric::identify::{Bending, HeavyElastica};
use crate::scene::FabricSpec;
use crate::sim::State;

/// Edges of the mesh along the overhang, unless a setting says otherwise.
const EDGES: f64 = 30.0;
/// Width over overhang: a strip bends the same at any width, and a narrow one is cheap.
const WIDTH: f64 = 0.2;
/// How near the chord comes to the wanted angle \[rad\].
const AIM: f64 = 1e-6;
/// Overhangs tried at most.
const TRIALS: usize = 16;
/// A long step at once: the strip is limp, and the way to its rest does not matter.
const HELD: &str = "[support.platform]\nkind = \"clamp\"\nregion = { kind = \"x-min\" }\n\
                    [method]\ndt = 1.0\nmax_iterations = 200\n";

/// A strip that hangs at the wanted angle.
struct Hung {
    cut: Cut,
    rest: Rest,
    residual: f64,
}

pub fn measure(fabric: &FabricSpec, settings: &Settings) -> Result<Report, MeasureError> {
    let resolved = fabric.resolve()?;
    let (angle, weight) = (
        settings.angle.to_radians(),
        resolved.areal_density * settings.gravity,
    );
    let strip = HeavyElastica::of_chord(angle)
        .ok_or_else(|| MeasureError::setting("angle", settings.angle, "from 5 to 85 degrees"))?;
    let rigidity = rigidity(&resolved, settings.direction);
    let first = (strip.gamma * rigidity / weight).cbrt();
    let unit = Cut {
        direction: settings.direction,
        length: first,
        width: settings.width.unwrap_or(WIDTH * first),
        edge: settings.edge.unwrap_or(first / EDGES),
        seed: 0,
    };
    unit.check()?;
    let hung: Vec<Hung> = (0..settings.meshes)
        .map(|seed| hang(fabric, settings, &Cut { seed, ..unit }))
        .collect::<Result<_, _>>()?;
    let coarse = Cut {
        edge: 2.0 * unit.edge,
        ..unit
    };
    let coarse = match coarse.check() {
        Ok(()) => Some(hang(fabric, settings, &coarse)?.cut.length),
        Err(_) => None,
    };
    let lengths: Vec<f64> = hung.iter().map(|h| h.cut.length).collect();
    // A strip across the yarns also twists: its rigidity has no closed form.
    let known = (settings.direction != Direction::Bias).then_some(first);
    let read = |name: &str, unit, of: &dyn Fn(f64) -> f64, known: Option<f64>| {
        let values: Vec<f64> = lengths.iter().map(|l| of(*l)).collect();
        let reading = Reading::new(name, unit, &values, known);
        match coarse {
            Some(length) => reading.against(of(length)),
            None => reading,
        }
    };
    let length = |l: f64| l * strip.bending_length();
    let exact = |l: f64| weight * length(l).powi(3);
    let peirce = |l: f64| Bending::peirce(l, angle, weight);
    let cut = hung[0].cut;
    Ok(Report {
        instrument: Instrument::Cantilever,
        fabric: resolved.name.clone(),
        direction: settings.direction,
        specimen: [cut.length, cut.width],
        set_up: format!(
            "clamped at the platform's edge, end at {} degrees below it",
            settings.angle
        ),
        edge: cut.edge,
        triangles: hung[0].rest.triangles(),
        meshes: settings.meshes,
        residual: hung.iter().map(|h| h.residual).fold(0.0, f64::max),
        readings: vec![
            read("overhang", "m", &|l| l, known),
            read("bending length, exact", "m", &length, known.map(length)),
            read(
                "flexural rigidity, exact",
                "N·m",
                &exact,
                known.map(|_| rigidity),
            ),
            read(
                "bending length, Peirce (19)",
                "m",
                &|l| peirce(l).length,
                None,
            ),
            read(
                "flexural rigidity, Peirce (20)",
                "N·m",
                &|l| peirce(l).rigidity,
                known.map(|l| peirce(l).rigidity),
            ),
        ],
        warnings: warnings(&resolved, settings, &cut),
        drapes: vec![],
        diagram: diagram(&hung[0], &strip, settings),
    })
}

/// Of a strip along a yarn, D11 or D22; at 45 degrees that of a sheet bent to a cylinder, as a first guess \[N·m\].
fn rigidity(fabric: &Fabric, direction: Direction) -> f64 {
    let d = fabric.bending();
    match direction {
        Direction::Warp => d.c11,
        Direction::Weft => d.c22,
        Direction::Bias => 0.25 * (d.c11 + d.c22 + 2.0 * d.c12 + 4.0 * d.c66),
    }
}

/// Secants over the overhang until the end hangs at the angle. The strip scales as a whole, so that its mesh stays
/// the same and each trial starts from the shape of the one before.
fn hang(fabric: &FabricSpec, settings: &Settings, unit: &Cut) -> Result<Hung, MeasureError> {
    let wanted = settings.angle.to_radians();
    let mut before: Option<(f64, f64)> = None;
    let (mut scale, mut state) = (1.0, None);
    let mut reached = 0.0;
    for _ in 0..TRIALS {
        let cut = Cut {
            length: scale * unit.length,
            width: scale * unit.width,
            edge: scale * unit.edge,
            ..*unit
        };
        fits(settings, &cut)?;
        let rest = at_rest(fabric, settings, &cut, state.take())?;
        let angle = chord(&rest, &cut);
        reached = angle;
        if (angle - wanted).abs() < AIM {
            let residual = rest.residual();
            return Ok(Hung {
                cut,
                rest,
                residual,
            });
        }
        // At 41.5 degrees the angle grows by 1.24 for each relative change of the overhang; the first secant
        // corrects that.
        let slope = match before {
            Some((s, a)) if s != scale && a != angle => (angle - a) / (scale - s),
            _ => 1.2 / scale,
        };
        let next = scale + (wanted - angle) / slope;
        before = Some((scale, angle));
        let next = next.clamp(0.6 * scale, 1.6 * scale);
        state = Some(scaled(rest.simulation().state(), next / scale));
        scale = next;
    }
    Err(MeasureError::NoOverhang {
        angle: settings.angle,
        overhang: scale * unit.length,
        reached: reached.to_degrees(),
    })
}

/// Whether the laboratory's strip is long enough.
fn fits(settings: &Settings, cut: &Cut) -> Result<(), MeasureError> {
    match settings.length {
        Some(length) if length < cut.length => Err(MeasureError::setting(
            "length",
            length,
            format!(
                "at least {:.4} m, the overhang at {} degrees",
                cut.length, settings.angle
            ),
        )),
        _ => Ok(()),
    }
}

fn at_rest(
    fabric: &FabricSpec,
    settings: &Settings,
    cut: &Cut,
    from: Option<State>,
) -> Result<Rest, MeasureError> {
    let scene = cut.scene("overhang", fabric, settings.gravity, HELD);
    Rest::find(&scene, from)
}

/// Angle below the horizontal of the line from the middle of the clamp to the middle of the free end \[rad\].
fn chord(rest: &Rest, cut: &Cut) -> f64 {
    let along = end(rest, cut, 1.0) - end(rest, cut, -1.0);
    (-along.z).atan2(along.x)
}

/// Mean place of one of the two ends \[m\].
fn end(rest: &Rest, cut: &Cut, side: f64) -> Vector3<f64> {
    rest.place(|p| p.x * side > (0.5 - 1e-6) * cut.length)
}

/// A shape of another size.
fn scaled(state: &State, factor: f64) -> State {
    let mut state = state.clone();
    state.positions.iter_mut().for_each(|p| *p *= factor);
    state
}

fn warnings(fabric: &Fabric, settings: &Settings, cut: &Cut) -> Vec<String> {
    let d = fabric.bending();
    let length = (d.c11.min(d.c22) / (fabric.areal_density * settings.gravity)).cbrt();
    let mut warnings = vec![];
    if cut.edge > 0.25 * length {
        warnings.push(format!(
            "the mesh's edges of {:.2} mm are longer than a quarter of the bending length of {:.2} mm: the rigidity \
             may be off by more than 0.5 %; --edge {:.1e} resolves it",
            1e3 * cut.edge,
            1e3 * length,
            0.1 * length
        ));
    }
    if settings.direction == Direction::Bias {
        let said = "a strip cut at 45 degrees bends and twists: its reading depends on width and twist rigidity";
        warnings.push(said.to_string());
    }
    warnings
}

fn diagram(hung: &Hung, strip: &HeavyElastica, settings: &Settings) -> Diagram {
    let (start, length) = (end(&hung.rest, &hung.cut, -1.0), hung.cut.length);
    let millimetres = |p: &Vector3<f64>| [1e3 * (p.x - start.x), 1e3 * (p.z - start.z)];
    let points = hung.rest.simulation().state().positions.iter();
    let exact = strip.shape.iter();
    let exact = exact.map(|[x, drop]| [1e3 * length * x, -1e3 * length * drop]);
    let (sin, cos) = settings.angle.to_radians().sin_cos();
    let curve = |name: &str, mark, points| Curve {
        name: name.into(),
        mark,
        points,
    };
    Diagram {
        x: "from the platform's edge [mm]",
        y: "height [mm]",
        shape: true,
        curves: vec![
            curve("exact elastica", Mark::Line, exact.collect()),
            curve(
                "vertices of the strip",
                Mark::Dots,
                points.map(millimetres).collect(),
            ),
            curve(
                &format!("{} degrees", settings.angle),
                Mark::Dashes,
                vec![[0.0; 2], [1e3 * length * cos, -1e3 * length * sin]],
            ),
        ],
    }
}
