//! Runs of other programs on a charted scene, as data with their source.

use nalgebra::Vector3;

use super::reference::Reference;

/// One run of another program.
#[derive(Clone, Debug, PartialEq)]
pub struct Peer {
    /// Program.
    pub name: String,
    /// Triangles of its mesh.
    pub triangles: usize,
    /// Step \[s\].
    pub dt: f64,
    /// CPU seconds per simulated second \[-\].
    pub cpu_rate: f64,
    /// Heights of the observed point over its start, by time \[s, m\].
    heights: Vec<(f64, f64)>,
}

/// The drape over the table by MuJoCo.
const DRAPE_TABLE: &str = include_str!("../../tests/references/peer_drape_table.csv");

impl Peer {
    /// Those on a scene.
    pub fn on(scene: &str) -> Vec<Self> {
        match scene {
            "drape-table" => read(DRAPE_TABLE),
            _ => vec![],
        }
    }

    /// Largest distance in height from a reference, at the times that both have \[m\].
    pub fn distance(&self, reference: &Reference) -> f64 {
        let places = reference.times.iter().zip(&reference.displacements);
        let apart = |(t, place): (&f64, &Vector3<f64>)| {
            let mine = self
                .heights
                .iter()
                .find(|(time, _)| (time - t).abs() < 1e-6)?;
            Some((mine.1 - place.z).abs())
        };
        places.filter_map(apart).fold(0.0, f64::max)
    }
}

/// Rows of `peer,triangles,dt_s,cpu_s_per_s,t_s,z_m` after comments and one header; one run after the other.
fn read(text: &str) -> Vec<Peer> {
    let mut peers: Vec<Peer> = vec![];
    for line in text.lines().filter(|l| !l.starts_with('#')).skip(1) {
        let cells: Vec<&str> = line.split(',').collect();
        let number = |k: usize| cells.get(k).and_then(|c| c.parse::<f64>().ok());
        let (Some(triangles), Some(dt), Some(cpu_rate), Some(t), Some(z)) =
            (number(1), number(2), number(3), number(4), number(5))
        else {
            continue;
        };
        let triangles = triangles as usize;
        let same = peers
            .last()
            .is_some_and(|p| p.triangles == triangles && p.dt == dt);
        if !same {
            peers.push(Peer {
                name: cells[0].to_string(),
                triangles,
                dt,
                cpu_rate,
                heights: vec![],
            });
        }
        if let Some(peer) = peers.last_mut() {
            peer.heights.push((t, z));
        }
    }
    peers
}
