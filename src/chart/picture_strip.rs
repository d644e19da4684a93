//! Moments side by side with the same camera: how a run went, on one page.

use resvg::tiny_skia::{Color, Pixmap};

use super::lettering::{DrawError, draw_over};
use super::picture::{LARGEST_SIDE, Moment, Picture, Size, Subject, panel, spacing};
use super::picture_framing::Framing;
use super::picture_labels::{Labels, time};

/// Width of a strip that fits its frames \[px\].
const WIDTH: f64 = 1600.0;

/// Where the panels are on the page.
struct Layout {
    columns: u32,
    size: Size,
    cell: Size,
    unit: f64,
    head: u32,
}

/// Draws moments side by side with the same camera; `size` is of the whole, or one is chosen to fit.
pub fn draw_strip(
    subject: &Subject,
    moments: &[Moment],
    framing: &Framing,
    size: Option<Size>,
) -> Result<Picture, DrawError> {
    let layout = Layout::new(moments.len() as u32, framing.camera.aspect(), size)?;
    let (w, h) = (f64::from(layout.cell.width), f64::from(layout.cell.height));
    let mut framing = framing.clone();
    framing
        .camera
        .fit(w, h, [0.05 * w, 2.2 * layout.unit, 1.4 * layout.unit]);
    let mut page =
        Pixmap::new(layout.size.width, layout.size.height).ok_or(DrawError::Empty("no pixels"))?;
    page.fill(Color::WHITE);
    for (k, moment) in (0..).zip(moments) {
        let drawn = panel(subject, moment, &framing, layout.cell)?;
        let (x, y) = layout.corner(k);
        copy(&drawn, &mut page, x, y);
    }
    draw_over(&mut page, &layout.letter(subject, moments, &framing), 1.0)?;
    Ok(Picture { pixmap: page })
}

impl Layout {
    fn new(count: u32, aspect: f64, size: Option<Size>) -> Result<Self, DrawError> {
        if count == 0 {
            return Err(DrawError::Empty("no frames"));
        }
        let aspect = aspect.clamp(0.4, 2.5);
        let columns = columns(count, aspect);
        let rows = count.div_ceil(columns);
        let fitting = || {
            let height = WIDTH / f64::from(columns.max(3)) / aspect * f64::from(rows) + 200.0;
            let width = WIDTH / f64::from(columns.max(3)) * f64::from(columns);
            Size {
                width: width as u32,
                height: (height as u32).min(LARGEST_SIDE),
            }
        };
        let size = size.unwrap_or_else(fitting).check()?;
        let unit = (f64::from(size.width) / 72.0).clamp(8.0, 22.0);
        let (head, foot) = ((5.0 * unit) as u32, (4.0 * unit) as u32);
        let height = size.height.saturating_sub(head + foot) / rows;
        let cell = Size {
            width: size.width / columns,
            height,
        }
        .check()?;
        Ok(Self {
            columns,
            size,
            cell,
            unit,
            head,
        })
    }

    /// Upper left corner of a panel \[px\].
    fn corner(&self, k: u32) -> (u32, u32) {
        let (column, row) = (k % self.columns, k / self.columns);
        (column * self.cell.width, self.head + row * self.cell.height)
    }

    fn letter(&self, subject: &Subject, moments: &[Moment], framing: &Framing) -> String {
        let unit = self.unit;
        let (width, height) = (f64::from(self.size.width), f64::from(self.size.height));
        let (w, h) = (f64::from(self.cell.width), f64::from(self.cell.height));
        let mut labels = Labels::new(width, height, unit);
        labels.title(subject.title, subject.subtitle);
        labels.scale_bar(&framing.camera, 0.35 * w, spacing(subject));
        labels.axes(&framing.camera, width - 4.2 * unit, 3.4 * unit);
        for (k, moment) in (0..).zip(moments) {
            let (x, y) = self.corner(k);
            let (x, y) = (f64::from(x), f64::from(y));
            labels.stamp(x + w - unit, y + 1.6 * unit, &time(moment.time));
            if k % self.columns > 0 {
                labels.rule([x, y], [x, y + h]);
            }
            if k >= self.columns {
                labels.rule([x, y], [x + w, y]);
            }
        }
        labels.svg()
    }
}

/// Columns that make the whole about 16:10 without a ragged last row, if some number does.
fn columns(count: u32, aspect: f64) -> u32 {
    let badness = |c: u32| {
        let rows = count.div_ceil(c);
        let shape = (f64::from(c) * aspect / (f64::from(rows) * 1.6)).ln().abs();
        shape + 3.0 * f64::from(c * rows - count) / f64::from(c)
    };
    let best = (1..=count.min(8)).min_by(|a, b| badness(*a).total_cmp(&badness(*b)));
    best.unwrap_or(1)
}

fn copy(from: &Pixmap, to: &mut Pixmap, x: u32, y: u32) {
    let (row, stride) = (4 * from.width() as usize, 4 * to.width() as usize);
    for (k, line) in from.data().chunks_exact(row).enumerate() {
        let at = (y as usize + k) * stride + 4 * x as usize;
        to.data_mut()[at..at + row].copy_from_slice(line);
    }
}
