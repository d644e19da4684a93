//! The whole state as a message, and back, bit for bit.

use nalgebra::{Quaternion, Translation3, UnitQuaternion, Vector3};

use super::inbound::Malformed;
use super::messages::geometry_msgs;
use super::messages::toile_msgs::{Air as WireAir, Keyframe, Obstacle as WireObstacle};
use super::{header, obstacles};
use crate::contact::surface::Triangles;
use crate::contact::{Obstacle, Overlap, Pose, Shape, Surface, Velocity};
use crate::sim::{Air, AirRegion, History, Ledger, Memory, State};

/// A state with its digest, at its simulated time \[s\].
pub fn keyframe(state: &State, digest: u64, time: f64) -> Keyframe {
    let bonds = state.bonds.iter();
    let offsets: Vec<_> = bonds.clone().map(|bond| bond.offset).collect();
    let layer_offsets: Vec<_> = state.layer_bonds.iter().map(|bond| bond.offset).collect();
    let History {
        dt,
        positions,
        velocities,
        accelerations,
    } = &state.history;
    Keyframe {
        header: header(time),
        step: state.step,
        began: state.began,
        digest,
        positions: flat(&state.positions),
        velocities: flat(&state.velocities),
        slopes: flat(&state.slopes),
        slope_rates: flat(&state.slope_rates),
        obstacles: state.obstacles.iter().map(obstacle).collect(),
        history_dt: *dt,
        history_positions: flat(positions),
        history_velocities: flat(velocities),
        accelerations: flat(accelerations),
        bond_keys: bonds.map(|bond| bond.key).collect(),
        bond_offsets: flat(&offsets),
        layer_bond_keys: state.layer_bonds.iter().map(|bond| bond.key).collect(),
        layer_bond_offsets: flat(&layer_offsets),
        air: air(&state.air),
        ledger_damping: state.ledger.damping,
        ledger_friction: state.ledger.friction,
        ledger_supports: state.ledger.supports,
        ledger_air: state.ledger.air,
    }
}

/// The state that a keyframe holds. Whether it fits a scene says `Simulation::resume`.
///
/// # Errors
/// A list is not made of vectors, bonds do not match, or a shape is none.
pub fn state(keyframe: &Keyframe) -> Result<State, Malformed> {
    let obstacles: Result<_, _> = keyframe.obstacles.iter().map(read).collect();
    Ok(State {
        step: keyframe.step,
        began: keyframe.began,
        positions: vectors("positions", &keyframe.positions)?,
        velocities: vectors("velocities", &keyframe.velocities)?,
        slopes: vectors("slopes", &keyframe.slopes)?,
        slope_rates: vectors("slope_rates", &keyframe.slope_rates)?,
        obstacles: obstacles?,
        air: read_air(&keyframe.air),
        history: History {
            dt: keyframe.history_dt,
            positions: vectors("history_positions", &keyframe.history_positions)?,
            velocities: vectors("history_velocities", &keyframe.history_velocities)?,
            accelerations: vectors("accelerations", &keyframe.accelerations)?,
        },
        bonds: memory("bond", &keyframe.bond_keys, &keyframe.bond_offsets)?,
        layer_bonds: memory(
            "layer_bond",
            &keyframe.layer_bond_keys,
            &keyframe.layer_bond_offsets,
        )?,
        ledger: Ledger {
            damping: keyframe.ledger_damping,
            friction: keyframe.ledger_friction,
            supports: keyframe.ledger_supports,
            air: keyframe.ledger_air,
        },
    })
}

fn memory(name: &str, keys: &[u64], offsets: &[f64]) -> Result<Vec<Memory>, Malformed> {
    let field = format!("{name}_offsets");
    let offsets = vectors(&field, offsets)?;
    if offsets.len() != keys.len() {
        let found = format_args!("{} offsets", offsets.len());
        let range = format!("must be as many as there are keys, {}", keys.len());
        return Err(Malformed::range(&field, found, &range));
    }
    let bonds = keys.iter().zip(offsets);
    Ok(bonds.map(|(&key, offset)| Memory { key, offset }).collect())
}

fn flat(list: &[Vector3<f64>]) -> Vec<f64> {
    list.iter().flatten().copied().collect()
}

fn vectors(field: &str, numbers: &[f64]) -> Result<Vec<Vector3<f64>>, Malformed> {
    match numbers.as_chunks::<3>() {
        (triples, []) => Ok(triples.iter().map(|t| Vector3::from(*t)).collect()),
        _ => {
            let found = format_args!("{} numbers", numbers.len());
            Err(Malformed::range(field, found, "must be three a vector"))
        }
    }
}

fn air(air: &Air) -> WireAir {
    let corner = |of: fn(&AirRegion) -> Vector3<f64>| {
        let v = air.region.as_ref().map_or(Vector3::zeros(), of);
        obstacles::wire_point(&v)
    };
    WireAir {
        fluid_damping: air.fluid_damping,
        in_region: air.region.is_some(),
        region_min: corner(|region| region.min),
        region_max: corner(|region| region.max),
        before: obstacles::wire_vector(&air.from),
        after: obstacles::wire_vector(&air.to),
        since: air.since,
        delay: air.delay,
        rise: air.rise,
        ends: air.hold.is_some(),
        hold: air.hold.unwrap_or_default(),
    }
}

fn read_air(air: &WireAir) -> Air {
    let corner = |p: &geometry_msgs::Point| Vector3::new(p.x, p.y, p.z);
    Air {
        fluid_damping: air.fluid_damping,
        region: air.in_region.then(|| AirRegion {
            min: corner(&air.region_min),
            max: corner(&air.region_max),
        }),
        from: vector(&air.before),
        to: vector(&air.after),
        since: air.since,
        delay: air.delay,
        rise: air.rise,
        hold: air.ends.then_some(air.hold),
    }
}

fn vector(v: &geometry_msgs::Vector3) -> Vector3<f64> {
    Vector3::new(v.x, v.y, v.z)
}

fn obstacle(obstacle: &Obstacle) -> WireObstacle {
    let (shape, dimensions) = match obstacle.shape {
        Shape::Mesh(ref surface) => (WireObstacle::MESH, numbers(surface)),
        Shape::Plane => (WireObstacle::PLANE, vec![]),
        Shape::Box { size } => (WireObstacle::BOX, size.to_vec()),
        Shape::Sphere { radius } => (WireObstacle::SPHERE, vec![radius]),
        Shape::Cylinder { radius, length } => (WireObstacle::CYLINDER, vec![length, radius]),
        Shape::Disc { radius } => (WireObstacle::DISC, vec![radius]),
        Shape::Capsule { radius, length } => (WireObstacle::CAPSULE, vec![length, radius]),
    };
    WireObstacle {
        name: obstacle.name.clone(),
        shape,
        dimensions,
        pose: obstacles::wire_pose(&obstacle.pose),
        twist: obstacles::wire_twist(&obstacle.velocity),
        friction: obstacle.friction,
        scripted: obstacle.scripted,
        overlap_depth: obstacle.overlap.depth,
        overlap_speed: obstacle.overlap.speed,
    }
}

/// A mesh as numbers: how many vertices, their coordinates, the corners of the triangles.
fn numbers(surface: &Surface) -> Vec<f64> {
    let vertices = surface.vertices();
    let corners = surface.triangles().iter().flatten();
    let mut numbers = vec![vertices.len() as f64];
    numbers.extend(vertices.iter().flatten());
    numbers.extend(corners.map(|v| f64::from(*v)));
    numbers
}

fn surface(numbers: &[f64]) -> Result<Surface, Malformed> {
    let count = numbers.first().map_or(0, |count| *count as usize);
    let rest = numbers.get(1..).unwrap_or_default();
    let (vertices, corners) = rest.split_at(count.saturating_mul(3).min(rest.len()));
    let whole = |c: &f64| *c as u32;
    let given = Triangles {
        vertices: vertices.as_chunks::<3>().0.to_vec(),
        triangles: corners
            .as_chunks::<3>()
            .0
            .iter()
            .map(|t| t.each_ref().map(whole))
            .collect(),
    };
    let malformed = |reason: &str| {
        let found = format_args!("{} numbers of a mesh", numbers.len());
        Malformed::range("obstacles.dimensions", found, reason)
    };
    if given.vertices.len() != count || corners.len() % 3 != 0 {
        return Err(malformed("must be three a vertex and three a triangle"));
    }
    Surface::try_from(given).map_err(|error| malformed(&error.to_string()))
}

fn read(obstacle: &WireObstacle) -> Result<Obstacle, Malformed> {
    let shape = match (obstacle.shape, &obstacle.dimensions[..]) {
        (WireObstacle::PLANE, []) => Shape::Plane,
        (WireObstacle::BOX, &[x, y, z]) => Shape::Box { size: [x, y, z] },
        (WireObstacle::SPHERE, &[radius]) => Shape::Sphere { radius },
        (WireObstacle::CYLINDER, &[length, radius]) => Shape::Cylinder { radius, length },
        (WireObstacle::DISC, &[radius]) => Shape::Disc { radius },
        (WireObstacle::CAPSULE, &[length, radius]) => Shape::Capsule { radius, length },
        (WireObstacle::MESH, numbers) => Shape::Mesh(surface(numbers)?),
        (shape, dimensions) => {
            let found = format_args!("{shape} with {} dimensions", dimensions.len());
            let range = "must be a known shape with its dimensions";
            return Err(Malformed::range("obstacles.shape", found, range));
        }
    };
    let (p, q) = (&obstacle.pose.position, &obstacle.pose.orientation);
    // Normalising would change the last bit.
    let rotation = UnitQuaternion::new_unchecked(Quaternion::new(q.w, q.x, q.y, q.z));
    Ok(Obstacle {
        name: obstacle.name.clone(),
        shape,
        pose: Pose::from_parts(Translation3::new(p.x, p.y, p.z), rotation),
        velocity: Velocity {
            linear: vector(&obstacle.twist.linear),
            angular: vector(&obstacle.twist.angular),
        },
        friction: obstacle.friction,
        scripted: obstacle.scripted,
        overlap: Overlap {
            depth: obstacle.overlap_depth,
            speed: obstacle.overlap_speed,
        },
    })
}
