//! The waterfall as SVG: a bar a way, from the dearest down, with what the economy has saved.

use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, VPos};

use super::lettering::{DrawError, FAMILY};
use super::plot_frame::{FAINT, GRID, INK, at, fault, font, tick, ticks};
use super::plot_marks::color;
use super::plot_points::{log_range, short};
use super::waterfall::Bar;

/// Width, and the height of a bar with its room, in SVG units.
const WIDTH: u32 = 1300;
const ROW: i32 = 74;
/// Above the bars, below them, and left of them.
const HEAD: i32 = 96;
const FOOT: i32 = 76;
const LEFT: i32 = 400;

/// Draws the ways of a scene; the second line says what they have in common.
pub fn falls(title: &str, subtitle: &str, bars: &[Bar]) -> Result<String, DrawError> {
    if bars.is_empty() {
        return Err(DrawError::Empty("a waterfall without bars"));
    }
    let bottom = HEAD + ROW * bars.len() as i32;
    let range = log_range(bars.iter().map(|bar| bar.cpu_rate));
    let across = |value: f64| {
        let share = (value / range.0).ln() / (range.1 / range.0).ln();
        LEFT + (share.clamp(0.0, 1.0) * f64::from(WIDTH as i32 - LEFT - 190)) as i32
    };
    let mut svg = String::new();
    {
        let size = (WIDTH, (bottom + FOOT) as u32);
        let root = SVGBackend::with_string(&mut svg, size).into_drawing_area();
        root.fill(&WHITE).map_err(fault)?;
        let bold = FontDesc::new(FontFamily::Name(FAMILY), 25.0, FontStyle::Bold);
        let style = TextStyle::from(bold).color(&INK);
        root.draw_text(title, &style, (30, 16)).map_err(fault)?;
        root.draw_text(subtitle, &font(17, FAINT), (30, 50))
            .map_err(fault)?;
        let below = at(font(15, INK), HPos::Center, VPos::Top);
        for value in ticks(range.0, range.1) {
            let x = across(value);
            let line = PathElement::new(vec![(x, HEAD - 8), (x, bottom)], GRID.stroke_width(1));
            root.draw(&line).map_err(fault)?;
            root.draw_text(&tick(value), &below, (x, bottom + 8))
                .map_err(fault)?;
        }
        let axis = at(font(17, INK), HPos::Left, VPos::Top);
        root.draw_text(
            "CPU seconds per simulated second [-], one thread",
            &axis,
            (LEFT, bottom + 36),
        )
        .map_err(fault)?;
        for (k, bar) in bars.iter().enumerate() {
            let before = k.checked_sub(1).map(|k| bars[k].cpu_rate);
            let y = HEAD + ROW * k as i32;
            let end = across(bar.cpu_rate);
            let body = Rectangle::new(
                [(LEFT, y + 8), (end, y + ROW - 22)],
                color(bar.method).filled(),
            );
            root.draw(&body).map_err(fault)?;
            let name = at(font(17, INK), HPos::Right, VPos::Top);
            root.draw_text(&bar.economy, &name, (LEFT - 14, y + 10))
                .map_err(fault)?;
            let name = at(font(14, FAINT), HPos::Right, VPos::Top);
            let what = format!("{}, {} triangles", bar.method.name(), bar.triangles);
            root.draw_text(&what, &name, (LEFT - 14, y + 32))
                .map_err(fault)?;
            let value = at(font(17, INK), HPos::Left, VPos::Top);
            root.draw_text(&worth(bar, before), &value, (end + 10, y + 10))
                .map_err(fault)?;
            let value = at(font(14, FAINT), HPos::Left, VPos::Top);
            root.draw_text(&quality(bar), &value, (end + 10, y + 32))
                .map_err(fault)?;
        }
        root.present().map_err(fault)?;
    }
    Ok(svg)
}

/// The cost, and by what factor it differs from the one before.
fn worth(bar: &Bar, before: Option<f64>) -> String {
    let cost = short(bar.cpu_rate);
    match before.map(|before| before / bar.cpu_rate) {
        None => cost,
        Some(factor) if factor < 1.0 => format!("{cost}  (x {})", short(1.0 / factor)),
        Some(factor) => format!("{cost}  (1/{})", short(factor)),
    }
}

fn quality(bar: &Bar) -> String {
    match bar.error {
        Some(error) => format!("{} % off", short(1e2 * error)),
        None => format!("left at {} s", short(bar.simulated)),
    }
}
