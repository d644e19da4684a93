//! Rows to SVG: error against step (the order of a scheme is its slope) and error against CPU time.
//!
//! Runs that died are crosses in a band at the top, at their step and their CPU time: never left out.

use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, VPos};

use super::lettering::{DrawError, FAMILY};
use super::plot_frame::{
    Area, FAINT, FRONT, INK, at, fault, font, frame, ground, guides, to_local,
};
use super::plot_marks::{color, crosses, curves, mark, step_labels};
use super::plot_points::{Arranged, arrange, log_range};
use super::rows::Row;
use crate::scene::Method;

pub use super::plot_marks::{CROSS_GLYPH, LEFT_GLYPH};

/// Width and height of a chart, in SVG units.
pub const CHART_SIZE: (u32, u32) = (1500, 780);

/// What a chart says besides its rows.
#[derive(Clone, Debug)]
pub struct Caption {
    /// Scene whose rows are drawn.
    pub scene: String,
    /// First line.
    pub title: String,
    /// Second line: mesh, fabric, machine.
    pub subtitle: String,
    /// What the error is divided by, as in `error / length`.
    pub error_over: String,
    /// Uncertainty of the reference, in the units of the error \[-\].
    pub uncertainty: f64,
    /// Where the reference comes from.
    pub source: String,
    /// Other programs: label, CPU seconds per simulated second, error.
    pub peers: Vec<(String, f64, f64)>,
}

/// Draws the rows of one scene.
pub fn chart(caption: &Caption, rows: &[Row]) -> Result<String, DrawError> {
    let mine: Vec<&Row> = rows
        .iter()
        .filter(|r| r.key.scene == caption.scene)
        .collect();
    if mine.is_empty() {
        return Err(DrawError::Empty("no rows of this scene"));
    }
    let arranged = arrange(&mine);
    let mut svg = String::new();
    {
        let root = SVGBackend::with_string(&mut svg, CHART_SIZE).into_drawing_area();
        root.fill(&WHITE).map_err(fault)?;
        heading(&root, caption)?;
        legend(&root, &arranged)?;
        let body = root.margin(112, 40, 0, 0);
        let (left, right) = body.split_horizontally(710);
        let errors = error_range(&arranged, caption);
        step_panel(&left, &arranged, caption, errors)?;
        cpu_panel(&right, &arranged, caption, errors)?;
        root.present().map_err(fault)?;
    }
    Ok(svg)
}

/// Lowest and highest error, and where the band of failures begins.
fn error_range(arranged: &Arranged, caption: &Caption) -> (f64, f64, f64) {
    let errors = arranged
        .curves
        .iter()
        .flat_map(|c| &c.points)
        .map(|p| p.error);
    let others = caption.peers.iter().map(|(_, _, error)| *error);
    let (low, high) = log_range(errors.chain(others).chain([caption.uncertainty]));
    let band = (high / low).powf(0.07 + 0.03 * arranged.crosses.len().min(4) as f64);
    (low, high * band, high)
}

fn heading(root: &Area, caption: &Caption) -> Result<(), DrawError> {
    let title = FontDesc::new(FontFamily::Name(FAMILY), 25.0, FontStyle::Bold);
    let style = TextStyle::from(title).color(&INK);
    root.draw_text(&caption.title, &style, (30, 16))
        .map_err(fault)?;
    root.draw_text(&caption.subtitle, &font(17, FAINT), (30, 48))
        .map_err(fault)?;
    let source = format!("reference: {}", caption.source);
    let corner = at(font(15, FAINT), HPos::Left, VPos::Bottom);
    root.draw_text(&source, &corner, (30, CHART_SIZE.1 as i32 - 10))
        .map_err(fault)
}

fn legend(root: &Area, arranged: &Arranged) -> Result<(), DrawError> {
    let mut x = 30;
    let y = 92;
    for method in Method::IN_TIME {
        let drawn = arranged.curves.iter().any(|curve| curve.method == method)
            || arranged.crosses.iter().any(|c| c.method == method);
        if !drawn {
            continue;
        }
        let ink = color(method);
        let line = PathElement::new(vec![(x, y), (x + 44, y)], ink.stroke_width(2));
        root.draw(&line).map_err(fault)?;
        mark(root, method, (x + 22, y))?;
        let style = at(font(17, INK), HPos::Left, VPos::Center);
        root.draw_text(&method.name(), &style, (x + 54, y))
            .map_err(fault)?;
        x += 90 + 8 * method.name().len() as i32;
    }
    if !arranged.front.is_empty() {
        let line = PathElement::new(vec![(x, y), (x + 44, y)], FRONT.stroke_width(9));
        root.draw(&line).map_err(fault)?;
        let style = at(font(17, INK), HPos::Left, VPos::Center);
        root.draw_text("no other run is better in both", &style, (x + 54, y))
            .map_err(fault)?;
    }
    Ok(())
}

fn step_panel(
    area: &Area,
    arranged: &Arranged,
    caption: &Caption,
    errors: (f64, f64, f64),
) -> Result<(), DrawError> {
    let points = arranged.curves.iter().flat_map(|c| &c.points).map(|p| p.dt);
    let range = log_range(points.chain(arranged.crosses.iter().map(|c| c.dt)));
    let mut panel = frame(area, caption, "step or substep [s]", range, errors)?;
    ground(area, &mut panel, caption, range, errors)?;
    guides(&mut panel, arranged, range, errors)?;
    curves(area, &mut panel, arranged, |p| p.dt)?;
    crosses(area, &panel, arranged, range, errors, |c| c.dt)
}

fn cpu_panel(
    area: &Area,
    arranged: &Arranged,
    caption: &Caption,
    errors: (f64, f64, f64),
) -> Result<(), DrawError> {
    let points = arranged
        .curves
        .iter()
        .flat_map(|c| &c.points)
        .map(|p| p.cpu);
    let dead = arranged.crosses.iter().map(|c| c.cpu);
    let others = caption.peers.iter().map(|(_, cpu, _)| *cpu);
    let range = log_range(points.chain(dead).chain(others).chain([1.0]));
    let label = "CPU seconds per simulated second [-], one thread";
    let mut panel = frame(area, caption, label, range, errors)?;
    ground(area, &mut panel, caption, range, errors)?;
    let (low, _, top) = errors;
    let line = PathElement::new(vec![(1.0, low), (1.0, top)], INK.mix(0.7).stroke_width(2));
    panel.draw_series([line]).map_err(fault)?;
    let here = to_local(area, panel.backend_coord(&(1.0, top)));
    let style = at(font(15, INK), HPos::Right, VPos::Top);
    area.draw_text("real time", &style, (here.0 - 7, here.1 + 8))
        .map_err(fault)?;
    let mut steps = vec![];
    for (k, (cpu, error)) in arranged.front.iter().enumerate() {
        if k > 0 {
            steps.push((*cpu, arranged.front[k - 1].1));
        }
        steps.push((*cpu, *error));
    }
    let front = PathElement::new(steps, FRONT.mix(0.75).stroke_width(9));
    panel.draw_series([front]).map_err(fault)?;
    curves(area, &mut panel, arranged, |p| p.cpu)?;
    step_labels(area, &panel, arranged)?;
    for (label, cpu, error) in &caption.peers {
        let (x, y) = to_local(area, panel.backend_coord(&(*cpu, *error)));
        let square = Rectangle::new([(x - 6, y - 6), (x + 6, y + 6)], INK.stroke_width(2));
        area.draw(&square).map_err(fault)?;
        let style = at(font(14, INK), HPos::Right, VPos::Center);
        area.draw_text(label, &style, (x - 11, y)).map_err(fault)?;
    }
    crosses(area, &panel, arranged, range, errors, |c| c.cpu)
}
