//! `toile show`: a picture of a recording, without display or GPU, and what viewers need beside it.

use std::path::{Path, PathBuf};
use std::str::FromStr;

use clap::Args;
use nalgebra::{Rotation2, UnitQuaternion, Vector2, Vector3};

use super::{CliError, output};
use crate::chart::{self, Framing, Moment, Picture, Size, Subject, View};
use crate::node::{self, Frame, Recording};
use crate::scene::Scene;

/// Frames that decide what the camera must hold, at most.
const FRAMED: usize = 80;

/// Arguments of `toile show`.
#[derive(Args)]
pub struct ShowArgs {
    /// The recording: an MCAP file or a bag directory.
    #[arg(required_unless_present = "layouts")]
    file: Option<PathBuf>,
    /// Where the picture goes; without it, beside the recording as .png.
    #[arg(short, long, value_name = "PNG")]
    output: Option<PathBuf>,
    /// Simulated time to show [s]; the last state if not given.
    #[arg(long, value_name = "SECONDS", allow_negative_numbers = true)]
    time: Option<f64>,
    /// Shows this many states side by side, from the first to the last.
    #[arg(long, value_name = "N", conflicts_with = "time", value_parser = clap::value_parser!(u32).range(2..=64))]
    strip: Option<u32>,
    /// Viewer's azimuth from x and elevation over the horizon [degrees].
    #[arg(long, value_name = "AZ,EL", allow_hyphen_values = true, value_parser = view)]
    view: Option<View>,
    /// Size of the picture [px]; 1200x900, a strip fits its frames.
    #[arg(long, value_name = "WxH", value_parser = size)]
    size: Option<Size>,
    /// Writes the rerun blueprint and the Foxglove layout into this directory.
    #[arg(long, value_name = "DIR")]
    layouts: Option<PathBuf>,
}

impl ShowArgs {
    /// Writes what was asked for and prints the paths.
    pub fn run(&self) -> Result<(), CliError> {
        if let Some(directory) = &self.layouts {
            for path in node::viewers::write(directory)? {
                output::announce(&path)?;
            }
        }
        let Some(file) = &self.file else {
            return Ok(());
        };
        let picture = self.draw(&Recording::open(file)?)?;
        let path = self.output.clone().unwrap_or_else(|| beside(file));
        let png = picture.png().map_err(refused)?;
        output::save(&path, png)
    }

    fn draw(&self, recording: &Recording) -> Result<Picture, CliError> {
        let times = recording.times();
        if times.is_empty() {
            return Err(CliError::Input("the recording holds no state".into()));
        }
        let shown = self.shown(&times)?;
        let mut framing = Framing::new(self.view.unwrap_or_default());
        for index in spread(times.len(), FRAMED) {
            framing.include(&moment(recording.frame(index)?));
        }
        let mut moments = vec![];
        for index in shown {
            moments.push(moment(recording.frame(index)?));
        }
        moments.iter().for_each(|m| framing.include(m));
        let scene = recording.scene();
        let faces = recording.faces();
        let subtitle = format!(
            "{} · {} triangles · {} {} ms",
            scene.fabric.name,
            output::thousands(faces.len()),
            scene.method.scheme.name(),
            output::trimmed(scene.method.dt * 1e3),
        );
        let material = material(scene, &recording.frame(0)?);
        let subject = Subject {
            title: &scene.name,
            subtitle: &subtitle,
            faces,
            material: &material,
        };
        let picture = match self.strip {
            Some(_) => chart::draw_strip(&subject, &moments, &framing, self.size),
            None => chart::draw(
                &subject,
                &moments[0],
                &framing,
                self.size.unwrap_or_default(),
            ),
        };
        picture.map_err(refused)
    }

    /// Indices of the states to show.
    fn shown(&self, times: &[f64]) -> Result<Vec<usize>, CliError> {
        if let Some(count) = self.strip {
            return Ok(spread(times.len(), count as usize));
        }
        let last = times.len() - 1;
        let Some(time) = self.time else {
            return Ok(vec![last]);
        };
        let (from, to) = (times[0], times[last]);
        if !(time >= from - 1e-9 && time <= to + 1e-9) {
            return Err(CliError::Input(format!(
                "--time is {time}, the recording goes from {from} to {to} s"
            )));
        }
        let distance = |index: &usize| (times[*index] - time).abs();
        let nearest = (0..=last).min_by(|a, b| distance(a).total_cmp(&distance(b)));
        Ok(nearest.into_iter().collect())
    }
}

/// `count` indices spread evenly over `0..total`, both ends included; all of them if there are fewer.
fn spread(total: usize, count: usize) -> Vec<usize> {
    if total <= count {
        return (0..total).collect();
    }
    let at = |k: usize| (k * (total - 1) + (count - 1) / 2) / (count - 1);
    (0..count).map(at).collect()
}

fn moment(frame: Frame) -> Moment {
    Moment {
        time: frame.time,
        positions: frame.positions,
        obstacles: frame.obstacles,
    }
}

/// Warp and weft coordinates from the flat start, which a recording holds as its first state; none if the
/// first state is not flat (a recording that was resumed).
fn material(scene: &Scene, first: &Frame) -> Vec<Vector2<f64>> {
    let sheet = &scene.sheet;
    let [roll, pitch, yaw] = sheet.rotation.map(f64::to_radians);
    let turn = UnitQuaternion::from_euler_angles(roll, pitch, yaw).inverse();
    let local = |p: &Vector3<f64>| turn * (p - Vector3::from(sheet.position));
    let points: Vec<_> = first.positions.iter().map(local).collect();
    let flat = scene.perturbation.amplitude + 1e-3;
    if points.iter().any(|p| p.z.abs() > flat) {
        return vec![];
    }
    let warp = Rotation2::new(-sheet.warp_angle.to_radians());
    points.iter().map(|p| warp * p.xy()).collect()
}

fn beside(file: &Path) -> PathBuf {
    match file.file_stem() {
        Some(_) => file.with_extension("png"),
        None => PathBuf::from("toile.png"),
    }
}

fn refused(error: chart::DrawError) -> CliError {
    CliError::Input(error.to_string())
}

fn pair<T: FromStr>(text: &str, between: char) -> Option<(T, T)> {
    let (first, second) = text.split_once(between)?;
    Some((first.trim().parse().ok()?, second.trim().parse().ok()?))
}

fn view(text: &str) -> Result<View, String> {
    let found = pair::<f64>(text, ',').filter(|(a, e)| a.is_finite() && e.abs() <= 90.0);
    let (azimuth, elevation) =
        found.ok_or("wanted AZ,EL in degrees, elevation from -90 to 90, like -58,24")?;
    Ok(View { azimuth, elevation })
}

fn size(text: &str) -> Result<Size, String> {
    let sides = 64..=chart::picture::LARGEST_SIDE;
    let found = pair(text, 'x').filter(|(w, h)| sides.contains(w) && sides.contains(h));
    let (width, height) =
        found.ok_or_else(|| format!("wanted WxH in pixels, each {sides:?}, like 1200x900"))?;
    Ok(Size { width, height })
}
