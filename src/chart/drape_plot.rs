//! The chart of the drape audit: by fabric, and against overhang over bending length.

use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, VPos};

use super::drape::{Row, cell};
use super::lettering::{DrawError, FAMILY};
use super::plot_frame::{Area, FAINT, GRID, INK, at, fault, font};
use crate::fabric::{Fabric, find};
use crate::instrument::Hold;
use crate::instrument::drapemeter::paper::{INCONSISTENT, PUBLISHED, STRIP_LIMIT};

const SIZE: (u32, u32) = (1500, 640);
const MEASURED: RGBColor = INK;
const PRINTED: RGBColor = RGBColor(196, 94, 30);
/// Overhang of the paper's apparatus \[m\].
const OVERHANG: f64 = 0.05;

fn color(hold: Hold) -> RGBColor {
    match hold {
        Hold::Clamped => RGBColor(30, 100, 170),
        Hold::Resting => RGBColor(60, 130, 70),
    }
}

/// Draws the audit as SVG.
///
/// # Errors
/// There are no rows.
pub fn chart(rows: &[Row]) -> Result<String, DrawError> {
    if rows.is_empty() {
        return Err(DrawError::Empty("a drape table without rows"));
    }
    let mut svg = String::new();
    {
        let root = SVGBackend::with_string(&mut svg, SIZE).into_drawing_area();
        root.fill(&WHITE).map_err(fault)?;
        let bold = FontDesc::new(FontFamily::Name(FAMILY), 24.0, FontStyle::Bold);
        let title = "Drape coefficient of the paper's fabrics: measured, printed, ours";
        let style = TextStyle::from(bold).color(&INK);
        root.draw_text(title, &style, (30, 16)).map_err(fault)?;
        legend(&root)?;
        let (left, right) = root.margin(84, 10, 0, 0).split_horizontally(860);
        fabrics(&left, rows)?;
        master(&right, rows)?;
        root.present().map_err(fault)?;
    }
    Ok(svg)
}

fn legend(root: &Area) -> Result<(), DrawError> {
    let entries = [
        ("measured (Table 3)", MEASURED),
        ("simulated in the paper (Table 4)", PRINTED),
        ("ours, clamped: mean and range", color(Hold::Clamped)),
        ("ours, resting: mean and range", color(Hold::Resting)),
        ("strips that do not feel each other", FAINT),
    ];
    let mut x = 36;
    for (name, ink) in entries {
        root.draw(&Circle::new((x, 62), 5, ink.filled()))
            .map_err(fault)?;
        let style = at(font(16, INK), HPos::Left, VPos::Center);
        root.draw_text(name, &style, (x + 12, 62)).map_err(fault)?;
        x += 46 + 8 * name.len() as i32;
    }
    Ok(())
}

type Panel<'a, 'b> = ChartContext<
    'a,
    SVGBackend<'b>,
    Cartesian2d<plotters::coord::types::RangedCoordf64, plotters::coord::types::RangedCoordf64>,
>;

fn panel<'a, 'b>(
    area: &'a Area<'b>,
    (low, high): (f64, f64),
    label: &str,
    names: &dyn Fn(&f64) -> String,
    ticks: usize,
) -> Result<Panel<'a, 'b>, DrawError> {
    let mut panel = ChartBuilder::on(area)
        .margin_left(20)
        .margin_right(20)
        .x_label_area_size(52)
        .y_label_area_size(70)
        .build_cartesian_2d(low..high, 0.0..100.0)
        .map_err(fault)?;
    panel
        .configure_mesh()
        .x_desc(label)
        .y_desc("drape coefficient [%]")
        .x_labels(ticks)
        .x_label_formatter(names)
        .axis_desc_style(font(17, INK))
        .label_style(font(15, INK))
        .bold_line_style(GRID)
        .light_line_style(WHITE)
        .axis_style(FAINT)
        .draw()
        .map_err(fault)?;
    Ok(panel)
}

/// Mean with the range over the drapes.
fn ours(
    panel: &mut Panel,
    rows: &[Row],
    fabric: &str,
    hold: Hold,
    x: f64,
) -> Result<(), DrawError> {
    let Some(cell) = cell(rows, fabric, hold) else {
        return Ok(());
    };
    let (low, high) = cell.range;
    let bar = PathElement::new(vec![(x, low), (x, high)], color(hold).stroke_width(3));
    panel.draw_series([bar]).map_err(fault)?;
    dot(panel, (x, cell.mean), color(hold))
}

fn dot(panel: &mut Panel, place: (f64, f64), ink: RGBColor) -> Result<(), DrawError> {
    let dot = Circle::new(place, 5, ink.filled());
    panel.draw_series([dot]).map(|_| ()).map_err(fault)
}

fn fabrics(area: &Area, rows: &[Row]) -> Result<(), DrawError> {
    let name = |x: &f64| {
        let k = x.round() as usize;
        let published = PUBLISHED.get(k.wrapping_sub(1));
        published.map_or(String::new(), |p| {
            let mark = if INCONSISTENT.contains(&p.fabric) {
                "*"
            } else {
                ""
            };
            format!("{}{mark}", p.fabric)
        })
    };
    let label = "fabric (* measured drape contradicts the fabric's own constants)";
    let mut panel = panel(area, (0.4, 12.6), label, &name, 13)?;
    for (k, published) in PUBLISHED.iter().enumerate() {
        let x = k as f64 + 1.0;
        dot(&mut panel, (x - 0.24, published.measured.0), MEASURED)?;
        dot(&mut panel, (x - 0.08, published.simulated.0), PRINTED)?;
        ours(&mut panel, rows, published.fabric, Hold::Clamped, x + 0.08)?;
        ours(&mut panel, rows, published.fabric, Hold::Resting, x + 0.24)?;
    }
    Ok(())
}

fn master(area: &Area, rows: &[Row]) -> Result<(), DrawError> {
    let label = "overhang / bending length";
    let mut panel = panel(area, (0.8, 4.0), label, &|x| format!("{x:.1}"), 8)?;
    let strip = STRIP_LIMIT.iter().filter(|p| (0.8..=4.0).contains(&p[0]));
    let strip = strip.map(|[x, y]| (*x, *y));
    let line = PathElement::new(strip.collect::<Vec<_>>(), FAINT.stroke_width(2));
    panel.draw_series([line]).map_err(fault)?;
    for published in &PUBLISHED {
        let Some(fabric) = find(published.fabric) else {
            continue;
        };
        let x = OVERHANG / bending_length(&fabric);
        dot(&mut panel, (x, published.measured.0), MEASURED)?;
        for hold in Hold::ALL {
            ours(&mut panel, rows, published.fabric, hold, x)?;
        }
        let name = Text::new(
            published.fabric,
            (x, published.measured.0 + 3.0),
            font(13, FAINT),
        );
        panel.draw_series([name]).map_err(fault)?;
    }
    Ok(())
}

/// Of the mean of both directions \[m\].
fn bending_length(fabric: &Fabric) -> f64 {
    let rigidity = (fabric.rigidity_warp * fabric.rigidity_weft).sqrt();
    (rigidity / (fabric.areal_density * 9.81)).cbrt()
}
