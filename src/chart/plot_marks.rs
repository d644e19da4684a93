//! Curves with their markers and labels, and the crosses of runs that died.

use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, VPos};

use super::lettering::DrawError;
use super::plot_frame::{Area, Panel, at, fault, font, to_local};
use super::plot_points::{Arranged, Cross, Point};
use crate::scene::{Method, Scheme, Solver};

/// Class name in the SVG of nothing but failures: one `<text>` of this glyph for each.
pub const CROSS_GLYPH: &str = "✕";
/// The same of runs that were left, since they cost too much.
pub const LEFT_GLYPH: &str = "»";

pub(super) fn color(method: Method) -> RGBColor {
    // Okabe and Ito: distinct for every kind of colour vision.
    match method.solver {
        Solver::QuasiNewton => return RGBColor(86, 180, 233),
        Solver::Xpbd => return RGBColor(230, 159, 0),
        Solver::Newton => {}
    }
    match method.scheme {
        Scheme::BackwardEuler => RGBColor(213, 94, 0),
        Scheme::Bdf2 => RGBColor(0, 114, 178),
        Scheme::GeneralisedAlpha => RGBColor(0, 158, 115),
        Scheme::CentralDifference => RGBColor(170, 80, 150),
        Scheme::Equilibrium => RGBColor(90, 90, 90),
    }
}

/// The marker of a method at a place in pixels.
pub(super) fn mark(area: &Area, method: Method, (x, y): (i32, i32)) -> Result<(), DrawError> {
    let r = 6;
    let corners: Vec<(i32, i32)> = match method.scheme {
        Scheme::BackwardEuler => {
            let halo = Circle::new((x, y), r + 2, WHITE.filled());
            area.draw(&halo).map_err(fault)?;
            return area
                .draw(&Circle::new((x, y), r, color(method).filled()))
                .map_err(fault);
        }
        Scheme::Bdf2 => vec![(-r, -r), (r, -r), (r, r), (-r, r)],
        Scheme::GeneralisedAlpha => vec![(0, -r - 2), (r + 1, r - 1), (-r - 1, r - 1)],
        Scheme::CentralDifference | Scheme::Equilibrium => {
            vec![(0, -r - 2), (r + 2, 0), (0, r + 2), (-r - 2, 0)]
        }
    };
    for (scale, ink) in [(1.35, WHITE), (1.0, color(method))] {
        let place = |(a, b): &(i32, i32)| {
            (
                x + (f64::from(*a) * scale) as i32,
                y + (f64::from(*b) * scale) as i32,
            )
        };
        let shape = Polygon::new(corners.iter().map(place).collect::<Vec<_>>(), ink.filled());
        area.draw(&shape).map_err(fault)?;
    }
    Ok(())
}

pub(super) fn curves(
    area: &Area,
    panel: &mut Panel,
    arranged: &Arranged,
    x: impl Fn(&Point) -> f64,
) -> Result<(), DrawError> {
    for curve in &arranged.curves {
        let points = &curve.points;
        let path: Vec<(f64, f64)> = points.iter().map(|p| (x(p), p.error)).collect();
        let line = PathElement::new(path.clone(), color(curve.method).stroke_width(2));
        panel.draw_series([line]).map_err(fault)?;
    }
    for curve in &arranged.curves {
        let points = &curve.points;
        for p in points {
            mark(
                area,
                curve.method,
                to_local(area, panel.backend_coord(&(x(p), p.error))),
            )?;
        }
    }
    Ok(())
}

/// Most labels of failures that stand apart.
const MOST_LABELS: usize = 8;
/// Height that a mark with a label takes in the band of failures, over that of one without.
const LABELLED: f64 = 9.0;

/// The step of every point, written beside it where no marker and no other label is in the way.
pub(super) fn step_labels(
    area: &Area,
    panel: &Panel,
    arranged: &Arranged,
) -> Result<(), DrawError> {
    let place = |p: &Point| to_local(area, panel.backend_coord(&(p.cpu, p.error)));
    let mut taken = obstructions(arranged, place);
    for curve in &arranged.curves {
        let points = &curve.points;
        for p in points {
            let (x, y) = place(p);
            let (w, h) = (7 * p.label.chars().count() as i32 + 2, 15);
            let (middle, left, over) = (-h / 2, -w - 11, -h - 9);
            let offsets = [
                (12, middle),
                (8, over),
                (8, 9),
                (left, middle),
                (left, over),
                (left, 9),
                (-w / 2, over - 3),
                (-w / 2, 12),
                (12, -24),
                (12, 10),
                (-w / 2, -36),
                (-w / 2, 24),
            ];
            let boxes = offsets.map(|(a, b)| [x + a, y + b, x + a + w, y + b + h]);
            let overlaps = |b: &[i32; 4]| taken.iter().filter(|t| overlap(b, t)).count();
            let Some(chosen) = boxes.into_iter().find(|b| overlaps(b) == 0) else {
                continue;
            };
            taken.push(chosen);
            let style = at(font(14, color(curve.method)), HPos::Left, VPos::Top);
            area.draw_text(&p.label, &style, (chosen[0], chosen[1]))
                .map_err(fault)?;
        }
    }
    Ok(())
}

pub(super) fn overlap(a: &[i32; 4], b: &[i32; 4]) -> bool {
    a[0] < b[2] && b[0] < a[2] && a[1] < b[3] && b[1] < a[3]
}

/// Boxes that labels should not cover: markers (counted more than once) and the lines between them.
pub(super) fn obstructions(
    arranged: &Arranged,
    place: impl Fn(&Point) -> (i32, i32),
) -> Vec<[i32; 4]> {
    let mut taken = vec![];
    for curve in &arranged.curves {
        let points = &curve.points;
        for (x, y) in points.iter().map(&place) {
            taken.extend([[x - 8, y - 8, x + 8, y + 8]; 3]);
        }
        for pair in points.windows(2) {
            let ((x0, y0), (x1, y1)) = (place(&pair[0]), place(&pair[1]));
            for k in 1..24 {
                let (x, y) = (x0 + (x1 - x0) * k / 24, y0 + (y1 - y0) * k / 24);
                taken.push([x - 1, y - 1, x + 1, y + 1]);
            }
        }
    }
    taken
}

pub(super) fn crosses(
    area: &Area,
    panel: &Panel,
    arranged: &Arranged,
    range: (f64, f64),
    (_, high, top): (f64, f64, f64),
    x: impl Fn(&Cross) -> f64,
) -> Result<(), DrawError> {
    let few = arranged.crosses.len() <= MOST_LABELS;
    let height = |cross: &Cross| if few || cross.died { LABELLED } else { 1.0 };
    // The band's own label stands at its top.
    let total = LABELLED + arranged.crosses.iter().map(height).sum::<f64>();
    let mut down = LABELLED;
    for cross in &arranged.crosses {
        down += height(cross);
        let middle = (down - 0.5 * height(cross)) / total;
        let level = top * (high / top).powf(1.0 - middle);
        let value = x(cross).clamp(range.0 * 1.05, range.1 / 1.05);
        let (px, py) = to_local(area, panel.backend_coord(&(value, level)));
        let ink = color(cross.method);
        let style = at(font(22, ink), HPos::Center, VPos::Center);
        let glyph = match cross.died {
            true => CROSS_GLYPH,
            false => LEFT_GLYPH,
        };
        area.draw_text(glyph, &style, (px, py)).map_err(fault)?;
        let right = (value / range.0).ln() > 0.55 * (range.1 / range.0).ln();
        let (side, dx) = if right {
            (HPos::Right, -14)
        } else {
            (HPos::Left, 14)
        };
        if few || cross.died {
            let style = at(font(14, ink), side, VPos::Center);
            area.draw_text(&cross.label, &style, (px + dx, py))
                .map_err(fault)?;
        }
    }
    Ok(())
}
