//! Rows of one scene arranged for drawing: curves, failures, front, ranges.

use super::rows::{Asked, Outcome, Row};
use crate::scene::Method;

/// A run that ended, in the coordinates of both panels.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Point {
    pub dt: f64,
    pub cpu: f64,
    pub error: f64,
    pub label: String,
}

/// A run that died, or was left unfinished.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Cross {
    pub method: Method,
    pub died: bool,
    pub dt: f64,
    pub cpu: f64,
    pub label: String,
}

/// Runs of one method on one mesh.
#[derive(Clone, Debug)]
pub(super) struct Curve {
    pub method: Method,
    pub points: Vec<Point>,
}

/// All that one chart shows.
#[derive(Clone, Debug, Default)]
pub(super) struct Arranged {
    /// One curve a method and mesh that has points, by rising step.
    pub curves: Vec<Curve>,
    /// Runs that died, then those that were left.
    pub crosses: Vec<Cross>,
    /// Corners (CPU, error) of the runs that no other run beats in both.
    pub front: Vec<(f64, f64)>,
}

/// Where an error of exactly nothing is drawn on a logarithmic axis.
const LEAST: f64 = 1e-9;

pub(super) fn arrange(rows: &[&Row]) -> Arranged {
    let mut out = Arranged::default();
    let mut meshes: Vec<&str> = rows.iter().map(|r| r.key.mesh.as_str()).collect();
    meshes.sort_unstable();
    meshes.dedup();
    let all = Method::IN_TIME.into_iter();
    for (method, mesh) in all.flat_map(|method| meshes.iter().map(move |mesh| (method, *mesh))) {
        let mut points: Vec<Point> = rows
            .iter()
            .filter(|r| r.key.method == method && r.key.mesh == mesh)
            .filter_map(|r| point(r))
            .collect();
        points.sort_by(|a, b| a.dt.total_cmp(&b.dt));
        if !points.is_empty() {
            out.curves.push(Curve { method, points });
        }
    }
    out.crosses = rows.iter().filter_map(|r| cross(r)).collect();
    out.crosses.sort_by_key(|cross| !cross.died);
    out.front = front(&out.curves);
    out
}

fn point(row: &Row) -> Option<Point> {
    let error = row.error().filter(|e| e.is_finite())?.max(LEAST);
    Some(Point {
        dt: row.dt,
        cpu: row.cpu_rate().max(1e-6),
        error,
        label: step_text(row),
    })
}

fn cross(row: &Row) -> Option<Cross> {
    let (died, how, time) = match &row.outcome {
        Outcome::Died { time, .. } => (true, "died", time),
        Outcome::Unfinished { time } => (false, "too dear, left", time),
        Outcome::Done { .. } => return None,
    };
    let label = format!("{}, {how} at {} s", step_text(row), short(*time));
    Some(Cross {
        method: row.key.method,
        died,
        dt: step(row),
        cpu: row.cpu_rate(),
        label,
    })
}

/// The step that was asked for \[s\]; of a share or multiple of the limit, what that came to.
fn step(row: &Row) -> f64 {
    match row.key.asked {
        Asked::Step(dt) => dt,
        Asked::Limit(_) | Asked::Past(_) => row.dt,
    }
}

/// The step as a person writes it.
fn step_text(row: &Row) -> String {
    match step(row) {
        dt if dt < 0.995e-4 => format!("{} µs", short(dt * 1e6)),
        dt => format!("{} ms", short(dt * 1e3)),
    }
}

/// Three significant digits at most, no trailing zeros.
pub(super) fn short(x: f64) -> String {
    if x == 0.0 {
        return "0".to_string();
    }
    let decimals = (2 - x.abs().log10().floor() as i32).clamp(0, 6) as usize;
    let text = format!("{x:.decimals$}");
    match text.contains('.') {
        true => text.trim_end_matches('0').trim_end_matches('.').to_string(),
        false => text,
    }
}

fn front(curves: &[Curve]) -> Vec<(f64, f64)> {
    let mut all: Vec<(f64, f64)> = curves
        .iter()
        .flat_map(|c| &c.points)
        .map(|p| (p.cpu, p.error))
        .collect();
    all.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.total_cmp(&b.1)));
    let mut front: Vec<(f64, f64)> = vec![];
    for (cpu, error) in all {
        if front.last().is_none_or(|(_, best)| error < *best) {
            front.push((cpu, error));
        }
    }
    front
}

/// A range in whole thirds of a decade around values, at least one and a half decades wide.
pub(super) fn log_range(values: impl Iterator<Item = f64>) -> (f64, f64) {
    let logs = values.filter(|v| *v > 0.0 && v.is_finite()).map(f64::log10);
    let (low, high) = logs.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), v| {
        (a.min(v), b.max(v))
    });
    if low > high {
        return (1e-3, 1.0);
    }
    let widen = (0.5 * (1.5 - (high - low))).max(0.2);
    let third = |x: f64| 10f64.powf(x / 3.0);
    (
        third((3.0 * (low - widen)).floor()),
        third((3.0 * (high + widen)).ceil()),
    )
}
