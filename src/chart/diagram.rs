//! The report of an instrument as SVG: its diagram beside its readings.

use plotters::element::DashedPathElement;
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, VPos};

use super::lettering::{DrawError, FAMILY};
use super::plot_frame::{Area, FAINT, GRID, INK, at, fault, font};
use crate::instrument::{Curve, Diagram, Mark, Report};

/// Width and height of a report, in SVG units.
pub const REPORT_SIZE: (u32, u32) = (1200, 620);
/// Where the readings begin.
const READINGS: i32 = 700;
const COLORS: [RGBColor; 3] = [
    RGBColor(30, 100, 170),
    RGBColor(196, 94, 30),
    RGBColor(60, 130, 70),
];

/// Draws a report; `rows` are its readings as text, name and value.
pub fn report(report: &Report, title: &str, rows: &[[String; 2]]) -> Result<String, DrawError> {
    let mut svg = String::new();
    {
        let root = SVGBackend::with_string(&mut svg, REPORT_SIZE).into_drawing_area();
        root.fill(&WHITE).map_err(fault)?;
        let bold = FontDesc::new(FontFamily::Name(FAMILY), 24.0, FontStyle::Bold);
        let style = TextStyle::from(bold).color(&INK);
        root.draw_text(title, &style, (30, 18)).map_err(fault)?;
        readings(&root, rows)?;
        let body = root.margin(60, 10, 0, 0);
        let (left, _) = body.split_horizontally(READINGS - 20);
        panel(&left, &report.diagram)?;
        root.present().map_err(fault)?;
    }
    Ok(svg)
}

fn readings(root: &Area, rows: &[[String; 2]]) -> Result<(), DrawError> {
    for (k, [name, value]) in rows.iter().enumerate() {
        let y = 84 + 48 * k as i32;
        let under = at(font(15, FAINT), HPos::Left, VPos::Top);
        root.draw_text(name, &under, (READINGS, y)).map_err(fault)?;
        let style = at(font(17, INK), HPos::Left, VPos::Top);
        root.draw_text(value, &style, (READINGS, y + 19))
            .map_err(fault)?;
    }
    Ok(())
}

fn panel(area: &Area, diagram: &Diagram) -> Result<(), DrawError> {
    let points = diagram.curves.iter().flat_map(|curve| &curve.points);
    let points: Vec<_> = points.copied().collect();
    if points.is_empty() {
        return Err(DrawError::Empty("a diagram without points"));
    }
    let mut ranges = [0, 1].map(|axis| range(&points, axis));
    if diagram.shape {
        one_scale(&mut ranges, area.dim_in_pixel());
    }
    let [x, y] = ranges;
    let mut chart = ChartBuilder::on(area)
        .margin_left(20)
        .margin_right(20)
        .x_label_area_size(56)
        .y_label_area_size(80)
        .build_cartesian_2d(x.0..x.1, y.0..y.1)
        .map_err(fault)?;
    chart
        .configure_mesh()
        .x_desc(diagram.x)
        .y_desc(diagram.y)
        .axis_desc_style(font(17, INK))
        .label_style(font(15, INK))
        .bold_line_style(GRID)
        .light_line_style(WHITE)
        .axis_style(FAINT)
        .draw()
        .map_err(fault)?;
    for (curve, color) in diagram.curves.iter().zip(COLORS.iter().cycle()) {
        draw(&mut chart, curve, *color)?;
    }
    chart
        .configure_series_labels()
        .label_font(font(15, INK))
        .background_style(WHITE.mix(0.85))
        .position(SeriesLabelPosition::UpperRight)
        .draw()
        .map_err(fault)
}

type Chart<'a, 'b> = ChartContext<
    'a,
    SVGBackend<'b>,
    Cartesian2d<plotters::coord::types::RangedCoordf64, plotters::coord::types::RangedCoordf64>,
>;

fn draw(chart: &mut Chart, curve: &Curve, color: RGBColor) -> Result<(), DrawError> {
    let points: Vec<(f64, f64)> = curve.points.iter().map(|[x, y]| (*x, *y)).collect();
    let line = color.stroke_width(2);
    let drawn = match curve.mark {
        Mark::Dots => {
            let dots = points
                .into_iter()
                .map(|p| Circle::new(p, 3, color.filled()));
            chart.draw_series(dots).map_err(fault)?
        }
        Mark::Line => chart
            .draw_series([PathElement::new(points, line)])
            .map_err(fault)?,
        Mark::Dashes => chart
            .draw_series([DashedPathElement::new(points, 7, 5, line)])
            .map_err(fault)?,
    };
    let mark = curve.mark;
    drawn.label(&curve.name).legend(move |(x, y)| {
        let key = match mark {
            Mark::Dots => vec![(x + 8, y), (x + 12, y)],
            Mark::Line | Mark::Dashes => vec![(x, y), (x + 20, y)],
        };
        PathElement::new(
            key,
            color.stroke_width(if mark == Mark::Dots { 4 } else { 2 }),
        )
    });
    Ok(())
}

/// What an axis must show, with a little room; a flat curve gets some height.
fn range(points: &[[f64; 2]], axis: usize) -> (f64, f64) {
    let values = points.iter().map(|p| p[axis]);
    let (low, high) = values.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| {
        (l.min(v), h.max(v))
    });
    let room = (0.06 * (high - low)).max(1e-6 * (1.0 + high.abs()));
    (low - room, high + room)
}

/// Widens the range that leaves paper unused, so that a length is as long across as up.
fn one_scale(ranges: &mut [(f64, f64); 2], (width, height): (u32, u32)) {
    let paper = [f64::from(width) - 120.0, f64::from(height) - 56.0];
    let scale = |k: usize| (ranges[k].1 - ranges[k].0) / paper[k];
    let largest = scale(0).max(scale(1));
    for (range, paper) in ranges.iter_mut().zip(paper) {
        let (middle, half) = (0.5 * (range.0 + range.1), 0.5 * largest * paper);
        *range = (middle - half, middle + half);
    }
}
