//! Rows to SVG: error against step (the order of a scheme is its slope) and error against CPU time.
//!
//! Runs that died are crosses in a band at the top, at their step and their CPU time: never left out.

use plotters::coord::Shift;
use plotters::coord::combinators::{BindKeyPoints, LogCoord, WithKeyPoints};
use plotters::element::DashedPathElement;
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};

use super::lettering::{DrawError, FAMILY};
use super::plot_points::{Arranged, Cross, Point, arrange, log_range, short};
use super::rows::{Row, SCHEMES, scheme_name};
use crate::scene::Scheme;

/// Width and height of a chart, in SVG units.
pub const CHART_SIZE: (u32, u32) = (1500, 780);

/// Class name in the SVG of nothing but failures: one `<text>` of this glyph for each.
pub const CROSS_GLYPH: &str = "✕";

const INK: RGBColor = RGBColor(38, 40, 43);
const FAINT: RGBColor = RGBColor(107, 112, 120);
const GRID: RGBColor = RGBColor(226, 228, 231);
const FRONT: RGBColor = RGBColor(240, 205, 90);

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
}

type Log = WithKeyPoints<LogCoord<f64>>;
type Panel<'a, 'b> = ChartContext<'a, SVGBackend<'b>, Cartesian2d<Log, Log>>;
type Area<'b> = DrawingArea<SVGBackend<'b>, Shift>;

fn fault(error: impl std::fmt::Display) -> DrawError {
    DrawError::Chart(error.to_string())
}

fn color(scheme: Scheme) -> RGBColor {
    // Okabe and Ito: distinct for every kind of colour vision.
    match scheme {
        Scheme::BackwardEuler => RGBColor(213, 94, 0),
        Scheme::Bdf2 => RGBColor(0, 114, 178),
        Scheme::GeneralisedAlpha => RGBColor(0, 158, 115),
        Scheme::CentralDifference => RGBColor(170, 80, 150),
    }
}

fn font(size: u32, ink: RGBColor) -> TextStyle<'static> {
    let mut style = TextStyle::from((FAMILY, size).into_font());
    style.color = ink.to_backend_color();
    style
}

fn at(style: TextStyle<'static>, h: HPos, v: VPos) -> TextStyle<'static> {
    style.pos(Pos::new(h, v))
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
        let errors = error_range(&arranged, caption.uncertainty);
        step_panel(&left, &arranged, caption, errors)?;
        cpu_panel(&right, &arranged, caption, errors)?;
        root.present().map_err(fault)?;
    }
    Ok(svg)
}

/// Lowest and highest error, and where the band of failures begins.
fn error_range(arranged: &Arranged, uncertainty: f64) -> (f64, f64, f64) {
    let errors = arranged.curves.iter().flat_map(|(_, c)| c).map(|p| p.error);
    let (low, high) = log_range(errors.chain([uncertainty]));
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
    for scheme in SCHEMES {
        let drawn = arranged.curves.iter().any(|(s, _)| *s == scheme)
            || arranged.crosses.iter().any(|c| c.scheme == scheme);
        if !drawn {
            continue;
        }
        let ink = color(scheme);
        let line = PathElement::new(vec![(x, y), (x + 44, y)], ink.stroke_width(2));
        root.draw(&line).map_err(fault)?;
        mark(root, scheme, (x + 22, y))?;
        let style = at(font(17, INK), HPos::Left, VPos::Center);
        root.draw_text(scheme_name(scheme), &style, (x + 54, y))
            .map_err(fault)?;
        x += 90 + 8 * scheme_name(scheme).len() as i32;
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

/// The marker of a scheme at a place in pixels.
fn mark(area: &Area, scheme: Scheme, (x, y): (i32, i32)) -> Result<(), DrawError> {
    let r = 6;
    let corners: Vec<(i32, i32)> = match scheme {
        Scheme::BackwardEuler => {
            let halo = Circle::new((x, y), r + 2, WHITE.filled());
            area.draw(&halo).map_err(fault)?;
            return area
                .draw(&Circle::new((x, y), r, color(scheme).filled()))
                .map_err(fault);
        }
        Scheme::Bdf2 => vec![(-r, -r), (r, -r), (r, r), (-r, r)],
        Scheme::GeneralisedAlpha => vec![(0, -r - 2), (r + 1, r - 1), (-r - 1, r - 1)],
        Scheme::CentralDifference => vec![(0, -r - 2), (r + 2, 0), (0, r + 2), (-r - 2, 0)],
    };
    for (scale, ink) in [(1.35, WHITE), (1.0, color(scheme))] {
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

fn step_panel(
    area: &Area,
    arranged: &Arranged,
    caption: &Caption,
    errors: (f64, f64, f64),
) -> Result<(), DrawError> {
    let points = arranged.curves.iter().flat_map(|(_, c)| c).map(|p| p.dt);
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
    let points = arranged.curves.iter().flat_map(|(_, c)| c).map(|p| p.cpu);
    let dead = arranged.crosses.iter().map(|c| c.cpu);
    let range = log_range(points.chain(dead).chain([1.0]));
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
    crosses(area, &panel, arranged, range, errors, |c| c.cpu)
}

fn frame<'a, 'b>(
    area: &'a Area<'b>,
    caption: &Caption,
    x_label: &str,
    x: (f64, f64),
    (low, high, top): (f64, f64, f64),
) -> Result<Panel<'a, 'b>, DrawError> {
    let mut panel = ChartBuilder::on(area)
        .margin_left(24)
        .margin_right(26)
        .margin_top(6)
        .x_label_area_size(58)
        .y_label_area_size(84)
        .build_cartesian_2d(
            (x.0..x.1).log_scale().with_key_points(ticks(x.0, x.1)),
            (low..high).log_scale().with_key_points(ticks(low, top)),
        )
        .map_err(fault)?;
    panel
        .configure_mesh()
        .x_desc(x_label)
        .y_desc(format!("largest error / {}", caption.error_over))
        .axis_desc_style(font(18, INK))
        .label_style(font(16, INK))
        .x_label_formatter(&|x| tick(*x))
        .y_label_formatter(&|y| tick(*y))
        .bold_line_style(GRID)
        .light_line_style(WHITE)
        .axis_style(FAINT)
        .draw()
        .map_err(fault)?;
    Ok(panel)
}

/// Whole decades within a range; on a short axis 2 and 5 as well.
fn ticks(low: f64, high: f64) -> Vec<f64> {
    let leads: &[f64] = if high / low < 60.0 {
        &[1.0, 2.0, 5.0]
    } else {
        &[1.0]
    };
    let decades = low.log10().floor() as i32..=high.log10().ceil() as i32;
    let all = decades.flat_map(|d| leads.iter().map(move |l| l * 10f64.powi(d)));
    all.filter(|v| *v >= low * 0.999 && *v <= high * 1.001)
        .collect()
}

/// Powers of ten as powers, what lies between as it is.
fn tick(x: f64) -> String {
    let power = x.log10().round();
    match (x / 10f64.powf(power) - 1.0).abs() < 1e-6 {
        true => raised(power),
        false => short(x),
    }
}

fn raised(power: f64) -> String {
    if power == 0.0 {
        return "1".to_string();
    }
    let digits = format!("{power}");
    let digits = digits.chars().map(|c| match c {
        '-' => '⁻',
        '1' => '¹',
        '2' => '²',
        '3' => '³',
        c => char::from_u32(0x2070 + c.to_digit(10).unwrap_or(0)).unwrap_or(c),
    });
    format!("10{}", digits.collect::<String>())
}

/// The bands behind the curves: the reference's own uncertainty below, failures above.
fn ground(
    area: &Area,
    panel: &mut Panel,
    caption: &Caption,
    x: (f64, f64),
    (low, high, top): (f64, f64, f64),
) -> Result<(), DrawError> {
    let grey = RGBColor(120, 126, 134).mix(0.16).filled();
    let unsure = Rectangle::new([(x.0, low), (x.1, caption.uncertainty.max(low))], grey);
    let red = RGBColor(200, 60, 60).mix(0.08).filled();
    let dead = Rectangle::new([(x.0, top), (x.1, high)], red);
    panel.draw_series([unsure, dead]).map_err(fault)?;
    let under = to_local(area, panel.backend_coord(&(x.0, low)));
    let style = at(font(15, FAINT), HPos::Left, VPos::Bottom);
    let text = "the reference's own uncertainty";
    area.draw_text(text, &style, (under.0 + 8, under.1 - 7))
        .map_err(fault)?;
    let over = to_local(area, panel.backend_coord(&(x.0, high)));
    let style = at(font(15, RGBColor(160, 50, 50)), HPos::Left, VPos::Top);
    area.draw_text("runs that died", &style, (over.0 + 8, over.1 + 8))
        .map_err(fault)
}

/// Slopes of first and second order through the middle of the curves.
fn guides(
    panel: &mut Panel,
    arranged: &Arranged,
    x: (f64, f64),
    (low, _, top): (f64, f64, f64),
) -> Result<(), DrawError> {
    let all: Vec<&Point> = arranged.curves.iter().flat_map(|(_, c)| c).collect();
    let Some(anchor) = all.iter().max_by(|a, b| a.error.total_cmp(&b.error)) else {
        return Ok(());
    };
    for (order, shift) in [(1.0, 0.9), (2.0, 0.25)] {
        let value = |dt: f64| shift * anchor.error * (dt / anchor.dt).powf(order);
        let first = (low / (shift * anchor.error)).powf(1.0 / order) * anchor.dt;
        let last = (top / (shift * anchor.error)).powf(1.0 / order) * anchor.dt;
        let (from, to) = (first.max(x.0), last.min(x.1));
        let ends = vec![(from, value(from)), (to, value(to))];
        let line = DashedPathElement::new(ends, 6, 5, FAINT.mix(0.6).stroke_width(1));
        panel.draw_series([line]).map_err(fault)?;
        let mark = from * (to / from).powf(0.22);
        let style = at(font(15, FAINT), HPos::Right, VPos::Bottom);
        let text = Text::new(format!("order {order} "), (mark, value(mark)), style);
        panel.draw_series([text]).map_err(fault)?;
    }
    Ok(())
}

fn to_local(area: &Area, (x, y): (i32, i32)) -> (i32, i32) {
    let (base_x, base_y) = area.get_base_pixel();
    (x - base_x, y - base_y)
}

fn curves(
    area: &Area,
    panel: &mut Panel,
    arranged: &Arranged,
    x: impl Fn(&Point) -> f64,
) -> Result<(), DrawError> {
    for (scheme, points) in &arranged.curves {
        let path: Vec<(f64, f64)> = points.iter().map(|p| (x(p), p.error)).collect();
        let line = PathElement::new(path.clone(), color(*scheme).stroke_width(2));
        panel.draw_series([line]).map_err(fault)?;
    }
    for (scheme, points) in &arranged.curves {
        for p in points {
            mark(
                area,
                *scheme,
                to_local(area, panel.backend_coord(&(x(p), p.error))),
            )?;
        }
    }
    Ok(())
}

/// The step of every point, written beside it where no marker and no other label is in the way.
fn step_labels(area: &Area, panel: &Panel, arranged: &Arranged) -> Result<(), DrawError> {
    let place = |p: &Point| to_local(area, panel.backend_coord(&(p.cpu, p.error)));
    let mut taken = obstructions(arranged, place);
    for (scheme, points) in &arranged.curves {
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
            let Some(chosen) = boxes.into_iter().min_by_key(overlaps) else {
                continue;
            };
            taken.push(chosen);
            let style = at(font(14, color(*scheme)), HPos::Left, VPos::Top);
            area.draw_text(&p.label, &style, (chosen[0], chosen[1]))
                .map_err(fault)?;
        }
    }
    Ok(())
}

fn overlap(a: &[i32; 4], b: &[i32; 4]) -> bool {
    a[0] < b[2] && b[0] < a[2] && a[1] < b[3] && b[1] < a[3]
}

/// Boxes that labels should not cover: markers (counted more than once) and the lines between them.
fn obstructions(arranged: &Arranged, place: impl Fn(&Point) -> (i32, i32)) -> Vec<[i32; 4]> {
    let mut taken = vec![];
    for (_, points) in &arranged.curves {
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

fn crosses(
    area: &Area,
    panel: &Panel,
    arranged: &Arranged,
    range: (f64, f64),
    (_, high, top): (f64, f64, f64),
    x: impl Fn(&Cross) -> f64,
) -> Result<(), DrawError> {
    let count = arranged.crosses.len() as f64;
    for (k, cross) in arranged.crosses.iter().enumerate() {
        let level = top * (high / top).powf(1.0 - (k as f64 + 1.0) / (count + 1.0));
        let value = x(cross).clamp(range.0 * 1.05, range.1 / 1.05);
        let (px, py) = to_local(area, panel.backend_coord(&(value, level)));
        let ink = color(cross.scheme);
        let style = at(font(22, ink), HPos::Center, VPos::Center);
        area.draw_text(CROSS_GLYPH, &style, (px, py))
            .map_err(fault)?;
        let right = (value / range.0).ln() > 0.55 * (range.1 / range.0).ln();
        let (side, dx) = if right {
            (HPos::Right, -14)
        } else {
            (HPos::Left, 14)
        };
        let style = at(font(14, ink), side, VPos::Center);
        area.draw_text(&cross.label, &style, (px + dx, py))
            .map_err(fault)?;
    }
    Ok(())
}
