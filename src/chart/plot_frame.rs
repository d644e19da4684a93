//! One panel of a chart: logarithmic axes, and the bands and slopes behind its curves.

use plotters::coord::Shift;
use plotters::coord::combinators::{BindKeyPoints, LogCoord, WithKeyPoints};
use plotters::element::DashedPathElement;
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};

use super::lettering::{DrawError, FAMILY};
use super::plot::Caption;
use super::plot_points::{Arranged, Point, short};

pub(super) const INK: RGBColor = RGBColor(38, 40, 43);
pub(super) const FAINT: RGBColor = RGBColor(107, 112, 120);
pub(super) const GRID: RGBColor = RGBColor(226, 228, 231);
pub(super) const FRONT: RGBColor = RGBColor(240, 205, 90);

type Log = WithKeyPoints<LogCoord<f64>>;
pub(super) type Panel<'a, 'b> = ChartContext<'a, SVGBackend<'b>, Cartesian2d<Log, Log>>;
pub(super) type Area<'b> = DrawingArea<SVGBackend<'b>, Shift>;

pub(super) fn fault(error: impl std::fmt::Display) -> DrawError {
    DrawError::Chart(error.to_string())
}

pub(super) fn font(size: u32, ink: RGBColor) -> TextStyle<'static> {
    let mut style = TextStyle::from((FAMILY, size).into_font());
    style.color = ink.to_backend_color();
    style
}

pub(super) fn at(style: TextStyle<'static>, h: HPos, v: VPos) -> TextStyle<'static> {
    style.pos(Pos::new(h, v))
}

pub(super) fn frame<'a, 'b>(
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
pub(super) fn ticks(low: f64, high: f64) -> Vec<f64> {
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
pub(super) fn tick(x: f64) -> String {
    let power = x.log10().round();
    match (x / 10f64.powf(power) - 1.0).abs() < 1e-6 {
        true => raised(power),
        false => short(x),
    }
}

pub(super) fn raised(power: f64) -> String {
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
pub(super) fn ground(
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
    area.draw_text(
        "runs that died, or were left (»)",
        &style,
        (over.0 + 8, over.1 + 8),
    )
    .map_err(fault)
}

/// Slopes of first and second order through the middle of the curves.
pub(super) fn guides(
    panel: &mut Panel,
    arranged: &Arranged,
    x: (f64, f64),
    (low, _, top): (f64, f64, f64),
) -> Result<(), DrawError> {
    let all: Vec<&Point> = arranged.curves.iter().flat_map(|c| &c.points).collect();
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

pub(super) fn to_local(area: &Area, (x, y): (i32, i32)) -> (i32, i32) {
    let (base_x, base_y) = area.get_base_pixel();
    (x - base_x, y - base_y)
}
