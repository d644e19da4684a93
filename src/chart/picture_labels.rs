//! What is written over a picture: name, time, scale bar, thread distance, axes.

use std::fmt::Write;

use nalgebra::Vector3;

use super::lettering::{FAMILY, escape};
use super::picture_camera::Camera;

const INK: &str = "#26282b";
const FAINT: &str = "#6b7078";

/// The largest of 1, 2, 5 times a power of ten that is not above `x`.
pub(super) fn round_down(x: f64) -> f64 {
    let decade = 10f64.powf(x.log10().floor());
    let steps = [5.0, 2.0, 1.0];
    steps
        .iter()
        .map(|s| s * decade)
        .find(|s| *s <= x * (1.0 + 1e-9))
        .unwrap_or(decade)
}

/// A length as a person writes it.
pub(super) fn length(metres: f64) -> String {
    match metres {
        m if m >= 0.9995 => format!("{} m", trim(m)),
        m => format!("{} mm", trim(m * 1e3)),
    }
}

fn trim(x: f64) -> String {
    let text = format!("{x:.3}");
    text.trim_end_matches('0').trim_end_matches('.').to_string()
}

/// A time as a person writes it.
pub(super) fn time(seconds: f64) -> String {
    format!("t = {seconds:.3} s")
}

/// Collects labels into one SVG document.
pub(super) struct Labels {
    width: f64,
    height: f64,
    unit: f64,
    body: String,
}

impl Labels {
    /// Labels for a picture of this size; `unit` is the height of plain text \[px\].
    pub fn new(width: f64, height: f64, unit: f64) -> Self {
        Self {
            width,
            height,
            unit,
            body: String::new(),
        }
    }

    fn text(&mut self, x: f64, y: f64, anchor: &str, style: (f64, &str, u32), text: &str) {
        let (size, ink, weight) = style;
        let _ = write!(
            self.body,
            r#"<text x="{x:.2}" y="{y:.2}" font-family="{FAMILY}, sans-serif" font-size="{size:.2}" font-weight="{weight}" font-stretch="condensed" fill="{ink}" text-anchor="{anchor}">{}</text>"#,
            escape(text)
        );
    }

    fn stroke(&mut self, from: [f64; 2], to: [f64; 2], width: f64, ink: &str) {
        let [[x1, y1], [x2, y2]] = [from, to];
        let _ = write!(
            self.body,
            r#"<line x1="{x1:.2}" y1="{y1:.2}" x2="{x2:.2}" y2="{y2:.2}" stroke="{ink}" stroke-width="{width:.2}" stroke-linecap="butt"/>"#
        );
    }

    /// The name at the top left, what it is under it.
    pub fn title(&mut self, title: &str, subtitle: &str) {
        let u = self.unit;
        self.text(1.5 * u, 2.3 * u, "start", (1.3 * u, INK, 700), title);
        self.text(1.5 * u, 3.8 * u, "start", (0.95 * u, FAINT, 400), subtitle);
    }

    /// A time stamp whose right end is at `x`.
    pub fn stamp(&mut self, x: f64, y: f64, time_text: &str) {
        self.text(x, y, "end", (1.15 * self.unit, INK, 400), time_text);
    }

    /// A scale bar at the bottom left, at most `longest` \[px\], and the distance of the lines on the cloth.
    pub fn scale_bar(&mut self, camera: &Camera, longest: f64, spacing: Option<f64>) {
        let u = self.unit;
        let bar = round_down(longest / camera.scale());
        let (x, y, w) = (1.5 * u, self.height - 1.6 * u, bar * camera.scale());
        self.stroke([x, y], [x + w, y], 0.16 * u, INK);
        for end in [x + 0.05 * u, x + w - 0.05 * u] {
            self.stroke([end, y - 0.35 * u], [end, y + 0.35 * u], 0.1 * u, INK);
        }
        self.text(
            x + 0.5 * w,
            y - 0.65 * u,
            "middle",
            (u, INK, 400),
            &length(bar),
        );
        if let Some(spacing) = spacing {
            let note = format!("lines on the cloth every {}", length(spacing));
            self.text(
                x + w + 1.2 * u,
                y + 0.35 * u,
                "start",
                (0.9 * u, FAINT, 400),
                &note,
            );
        }
    }

    /// The world axes, their origin at x, y.
    pub fn axes(&mut self, camera: &Camera, x: f64, y: f64) {
        let u = self.unit;
        let names = [("x", "#b8434a"), ("y", "#3f8a4f"), ("z", "#3b62b0")];
        for (k, (name, ink)) in names.into_iter().enumerate() {
            let mut axis = Vector3::zeros();
            axis[k] = 1.0;
            let to = [camera.right.dot(&axis), -camera.up.dot(&axis)];
            let tip = [x + 2.1 * u * to[0], y + 2.1 * u * to[1]];
            self.stroke([x, y], tip, 0.14 * u, ink);
            let at = [x + 2.75 * u * to[0], y + 2.75 * u * to[1] + 0.32 * u];
            self.text(at[0], at[1], "middle", (0.95 * u, ink, 700), name);
        }
    }

    /// A thin frame line between panels.
    pub fn rule(&mut self, from: [f64; 2], to: [f64; 2]) {
        self.stroke(from, to, 1.0, "#e3e4e6");
    }

    /// The document.
    pub fn svg(&self) -> String {
        let (w, h) = (self.width, self.height);
        format!(
            r#"<svg xmlns="http://www.w3.org/2000/svg" width="{w}" height="{h}" viewBox="0 0 {w} {h}">{}</svg>"#,
            self.body
        )
    }
}
