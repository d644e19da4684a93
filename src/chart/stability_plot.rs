//! The stability map as SVG: a panel for each method and mesh, step against stiffness.

use plotters::element::DashedPathElement;
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, VPos};

use super::lettering::{DrawError, FAMILY};
use super::plot_frame::{Area, FAINT, GRID, INK, at, fault, font, tick, ticks, to_local};
use super::plot_marks::CROSS_GLYPH;
use super::plot_points::short;
use super::rows::{Asked, Row};
use super::stability::{Cell, Fate, MESHES, RIGHT, STEPS, STIFFNESSES};
use crate::scene::{Method, Scheme};

/// Width of a panel and height, in SVG units.
const PANEL: (u32, u32) = (620, 250);
const HEAD: u32 = 96;
const GOOD: RGBColor = RGBColor(0, 158, 115);
const BAD: RGBColor = RGBColor(230, 159, 0);
const GONE: RGBColor = RGBColor(200, 50, 50);

/// Draws the rows of the cells of one scene.
pub fn map(title: &str, cells: &[Cell], rows: &[Row]) -> Result<String, DrawError> {
    let mut svg = String::new();
    let size = (
        PANEL.0 * MESHES.len() as u32,
        HEAD + PANEL.1 * Method::IN_TIME.len() as u32,
    );
    {
        let root = SVGBackend::with_string(&mut svg, size).into_drawing_area();
        root.fill(&WHITE).map_err(fault)?;
        heading(&root, title)?;
        let body = root.margin(HEAD, 0, 0, 0);
        let panels = body.split_evenly((Method::IN_TIME.len(), MESHES.len()));
        let places = Method::IN_TIME
            .into_iter()
            .flat_map(|method| MESHES.map(|mesh| (method, mesh)));
        for (area, (method, triangles)) in panels.iter().zip(places) {
            let mine: Vec<&Cell> = cells.iter().filter(|c| c.triangles == triangles).collect();
            panel(area, method, &mine, rows)?;
        }
        root.present().map_err(fault)?;
    }
    Ok(svg)
}

fn heading(root: &Area, title: &str) -> Result<(), DrawError> {
    let bold = FontDesc::new(FontFamily::Name(FAMILY), 25.0, FontStyle::Bold);
    let style = TextStyle::from(bold).color(&INK);
    root.draw_text(title, &style, (30, 14)).map_err(fault)?;
    let mut x = 36;
    for (fate, text) in [
        (
            Fate::Right,
            format!("within {} % of the truth of its mesh", 1e2 * RIGHT),
        ),
        (Fate::Wrong, "finite but wrong".to_string()),
        (Fate::Lost, "stopped with an error".to_string()),
    ] {
        mark(root, fate, (x, 66))?;
        let style = at(font(17, INK), HPos::Left, VPos::Center);
        root.draw_text(&text, &style, (x + 16, 66)).map_err(fault)?;
        x += 40 + 9 * text.len() as i32;
    }
    let text = "- - -  2 / omega_max of the explicit scheme";
    let style = at(font(17, INK), HPos::Left, VPos::Center);
    root.draw_text(text, &style, (x, 66)).map_err(fault)
}

fn panel(area: &Area, method: Method, cells: &[&Cell], rows: &[Row]) -> Result<(), DrawError> {
    let triangles = cells.first().map_or(0, |c| c.triangles);
    let x = (1.5e-5, 1.4 * STEPS[0]);
    let y = (
        0.5 * STIFFNESSES[0],
        2.0 * STIFFNESSES[STIFFNESSES.len() - 1],
    );
    let caption = format!("{}, {triangles} triangles", method.name());
    let mut chart = ChartBuilder::on(area)
        .caption(caption, font(17, INK))
        .margin_left(14)
        .margin_right(20)
        .x_label_area_size(46)
        .y_label_area_size(62)
        .build_cartesian_2d(
            (x.0..x.1).log_scale().with_key_points(ticks(x.0, x.1)),
            (y.0..y.1).log_scale().with_key_points(ticks(y.0, y.1)),
        )
        .map_err(fault)?;
    chart
        .configure_mesh()
        .x_desc(match method.scheme {
            Scheme::CentralDifference => "substep [s]",
            _ => "step [s]",
        })
        .y_desc("stiffness / fabric's")
        .axis_desc_style(font(15, INK))
        .label_style(font(14, INK))
        .x_label_formatter(&|x| tick(*x))
        .y_label_formatter(&|y| tick(*y))
        .bold_line_style(GRID)
        .light_line_style(WHITE)
        .axis_style(FAINT)
        .draw()
        .map_err(fault)?;
    let limits: Vec<_> = cells
        .iter()
        .map(|c| (c.limit.clamp(x.0, x.1), c.stiffness))
        .collect();
    let line = DashedPathElement::new(limits, 7, 5, INK.stroke_width(2));
    chart.draw_series([line]).map_err(fault)?;
    for cell in cells {
        for row in rows.iter().filter(|r| r.key.method == method) {
            let Asked::Step(dt) = row.key.asked else {
                continue;
            };
            if row.key != cell.key(method, dt) {
                continue;
            }
            let place = to_local(area, chart.backend_coord(&(dt, cell.stiffness)));
            let fate = Fate::of(row);
            mark(area, fate, place)?;
            if let (Fate::Wrong, Some(error)) = (fate, row.error()) {
                let style = at(font(12, FAINT), HPos::Left, VPos::Center);
                let text = format!("{} %", short(1e2 * error));
                area.draw_text(&text, &style, (place.0 + 9, place.1 - 9))
                    .map_err(fault)?;
            }
        }
    }
    Ok(())
}

fn mark(area: &Area, fate: Fate, (x, y): (i32, i32)) -> Result<(), DrawError> {
    match fate {
        Fate::Right => area
            .draw(&Circle::new((x, y), 6, GOOD.filled()))
            .map_err(fault),
        Fate::Wrong => {
            let corners = vec![(x, y - 7), (x + 7, y + 6), (x - 7, y + 6)];
            area.draw(&Polygon::new(corners, BAD.filled()))
                .map_err(fault)
        }
        Fate::Lost => {
            let style = at(font(19, GONE), HPos::Center, VPos::Center);
            area.draw_text(CROSS_GLYPH, &style, (x, y)).map_err(fault)
        }
    }
}
