use nalgebra::{Vector2, Vector3};

use super::{Mesh, MeshOptions, NO_FACE, Outline, generate, generate_graded, interpolate};

fn outlines() -> [Outline; 5] {
    [
        Outline::Rectangle {
            length: 0.2,
            width: 0.2,
        },
        Outline::Rectangle {
            length: 0.1,
            width: 0.025,
        },
        Outline::Disc { diameter: 0.3 },
        Outline::Annulus {
            outer: 0.3,
            inner: 0.18,
        },
        Outline::Sector {
            outer: 0.3,
            inner: 0.18,
            angle: 359.9,
        },
    ]
}

fn meshed(outline: &Outline, triangles: usize, jitter: f64, seed: u64) -> Mesh {
    let options = MeshOptions {
        edge: outline.edge_for(triangles),
        jitter,
        seed,
        warp_angle: 0.3,
    };
    generate(outline, &options)
}

/// Smallest angle \[degrees\] and shape quality 4 sqrt(3) A / (sum of squared sides), 1 if equilateral.
fn shape(mesh: &Mesh, face: usize) -> (f64, f64) {
    let p = mesh.faces[face].map(|v| mesh.material[v as usize]);
    let side = |k: usize| p[(k + 1) % 3] - p[k];
    let angle = |k: usize| side(k).angle(&-side((k + 2) % 3)).to_degrees();
    let squares: f64 = (0..3).map(|k| side(k).norm_squared()).sum();
    let quality = 4.0 * 3f64.sqrt() * mesh.face_areas[face] / squares;
    (angle(0).min(angle(1)).min(angle(2)), quality)
}

#[test]
fn meshes_have_the_wanted_count_and_good_shapes() {
    for outline in outlines() {
        for wanted in [216, 400, 850, 1500, 5750] {
            for seed in 0..2 {
                let mesh = meshed(&outline, wanted, 0.0, seed);
                let count = mesh.faces.len();
                let shapes: Vec<_> = (0..count).map(|f| shape(&mesh, f)).collect();
                let least = shapes.iter().fold(90.0, |m: f64, s| m.min(s.0));
                let mean = shapes.iter().map(|s| s.1).sum::<f64>() / count as f64;
                let name = format!("{outline:?} of {wanted}, seed {seed}");
                let off = (count as f64 / wanted as f64 - 1.0).abs();
                // Rows of the lattice come in one by one on either side, which on a coarse mesh is some per cent.
                let tolerance = if wanted < 1000 { 0.08 } else { 0.05 };
                assert!(off <= tolerance, "{name}: {count} triangles");
                assert!(least > 30.0, "{name}: an angle of {least} degrees");
                let round = if wanted < 1000 { 0.94 } else { 0.95 };
                assert!(mean > round, "{name}: mean quality {mean}");
            }
        }
    }
}

/// Edges a quarter as long in the left half of an outline, growing from there.
#[test]
fn graded_meshes_have_the_wanted_count_sizes_and_shapes() {
    for outline in outlines() {
        let size = |longest: f64, p: &nalgebra::Vector2<f64>| {
            (0.25 * longest + 0.25 * p.x.max(0.0)).min(longest)
        };
        for (wanted, seed) in [(1500, 0), (1500, 1), (6000, 0)] {
            let options = MeshOptions {
                edge: outline.edge_for_graded(wanted, size),
                jitter: 0.0,
                seed,
                warp_angle: 0.3,
            };
            let mesh = generate_graded(&outline, &options, &|p| size(options.edge, p));
            let count = mesh.faces.len();
            let name = format!("{outline:?} of {wanted}, seed {seed}");
            let off = (count as f64 / wanted as f64 - 1.0).abs();
            assert!(off <= 0.05, "{name}: {count} triangles");
            let shapes: Vec<_> = (0..count).map(|f| shape(&mesh, f)).collect();
            let least = shapes.iter().fold(90.0, |m: f64, s| m.min(s.0));
            let mean = shapes.iter().map(|s| s.1).sum::<f64>() / count as f64;
            assert!(least > 20.0, "{name}: an angle of {least} degrees");
            assert!(mean > 0.93, "{name}: mean quality {mean}");
            // Edge over the wanted size at its middle.
            let ratios: Vec<f64> = (0..mesh.edges.len())
                .map(|e| {
                    let [a, b] = mesh.edges[e].map(|v| mesh.outline[v as usize]);
                    mesh.edge_length(e) / size(options.edge, &(0.5 * (a + b)))
                })
                .collect();
            let mean = ratios.iter().sum::<f64>() / ratios.len() as f64;
            let near = ratios.iter().filter(|r| (0.6..1.6).contains(*r)).count();
            assert!(
                (mean - 1.0).abs() < 0.1,
                "{name}: edges {mean} of the wanted size"
            );
            assert!(
                near as f64 > 0.97 * ratios.len() as f64,
                "{name}: {near} of {}",
                ratios.len()
            );
        }
    }
}

/// The rounded rims are polygons: they lose 2/3 (pi/n)² of a disc's area.
#[test]
fn areas_add_up() {
    for outline in outlines() {
        let mesh = meshed(&outline, 1500, 0.2, 1);
        let (vertices, faces): (f64, f64) =
            (mesh.vertex_areas.iter().sum(), mesh.face_areas.iter().sum());
        assert!((vertices / faces - 1.0).abs() < 1e-12);
        let off = mesh.area() / outline.area() - 1.0;
        let polygon = match outline {
            Outline::Rectangle { .. } => 1e-12,
            _ => 3e-3,
        };
        assert!(off.abs() < polygon, "{outline:?}: area off by {off:e}");
        assert!(
            mesh.face_areas.iter().all(|&a| a > 0.0),
            "a face is turned over"
        );
    }
}

#[test]
fn the_hole_of_an_annulus_is_empty() {
    let mesh = meshed(&outlines()[3], 1500, 0.0, 0);
    for face in &mesh.faces {
        let centre = face
            .iter()
            .map(|&v| mesh.outline[v as usize])
            .sum::<nalgebra::Vector2<f64>>()
            / 3.0;
        assert!(centre.norm() > 0.085, "a face at {centre}");
    }
    // Euler: V - E + F = 0 for a ring, 1 for a disc.
    let euler = |mesh: &Mesh| {
        mesh.material.len() as i64 - mesh.edges.len() as i64 + mesh.faces.len() as i64
    };
    assert_eq!(euler(&mesh), 0);
    assert_eq!(euler(&meshed(&outlines()[2], 1500, 0.0, 0)), 1);
}

#[test]
fn the_same_arguments_give_the_same_mesh() {
    for outline in outlines() {
        let [first, again, other] = [1, 1, 2].map(|seed| meshed(&outline, 400, 0.2, seed));
        assert_eq!(first.material, again.material);
        assert_eq!(first.faces, again.faces);
        assert_ne!(first.material, other.material, "the seed does nothing");
    }
}

#[test]
fn edges_and_faces_know_each_other() {
    let mesh = meshed(&outlines()[0], 400, 0.2, 5);
    let mut seen = vec![0; mesh.edges.len()];
    for f in 0..mesh.faces.len() {
        for k in 0..3 {
            let e = mesh.face_edges[f][k] as usize;
            let corner = mesh.faces[f][k];
            assert!(
                !mesh.edges[e].contains(&corner),
                "edge k is opposite to corner k"
            );
            assert!(mesh.edges[e].iter().all(|v| mesh.faces[f].contains(v)));
            assert!(mesh.edge_faces[e].contains(&(f as u32)));
            seen[e] += 1;
        }
    }
    for (e, count) in seen.iter().enumerate() {
        let [a, b] = mesh.edges[e];
        assert!(a < b && mesh.edge_faces[e][0] != NO_FACE);
        assert_eq!(*count, if mesh.is_boundary(e) { 1 } else { 2 });
    }
    let rim: f64 = (0..mesh.edges.len())
        .filter(|&e| mesh.is_boundary(e))
        .map(|e| mesh.edge_length(e))
        .sum();
    assert!((rim - 0.8).abs() < 1e-12, "perimeter {rim}");
}

/// Shape functions sum to one, and reproduce a linear field.
#[test]
fn shape_gradients_reproduce_linear_fields() {
    let mesh = meshed(&outlines()[2], 400, 0.2, 5);
    let slope = nalgebra::Vector2::new(1.7, -0.4);
    for f in 0..mesh.faces.len() {
        let gradients = mesh.shape_gradients(f);
        let size = gradients[0].norm();
        assert!((gradients[0] + gradients[1] + gradients[2]).norm() < 1e-12 * size);
        let field: nalgebra::Vector2<f64> = (0..3)
            .map(|k| gradients[k] * slope.dot(&mesh.material[mesh.faces[f][k] as usize]))
            .sum();
        assert!((field - slope).norm() < 1e-10);
    }
}

/// The warp lies at the wanted angle from sheet x: a point on that line has no weft coordinate.
#[test]
fn the_warp_lies_at_its_angle() {
    let mesh = meshed(&outlines()[0], 400, 0.0, 0);
    let along = nalgebra::Vector2::new(0.3f64.cos(), 0.3f64.sin());
    for (outline, material) in mesh.outline.iter().zip(&mesh.material) {
        assert!((material.x - outline.dot(&along)).abs() < 1e-15);
    }
}

/// Values at the vertices of a finer mesh from those of a coarser one, at most off by.
fn interpolation_error(coarse: usize, field: impl Fn(&Vector2<f64>) -> Vector3<f64>) -> f64 {
    let [from, to] = [coarse, 5000].map(|n| meshed(&outlines()[2], n, 0.2, n as u64));
    let values: Vec<_> = from.material.iter().map(&field).collect();
    let found = interpolate(&from, &values, &to.material);
    let off = found
        .iter()
        .zip(&to.material)
        .map(|(v, p)| (v - field(p)).norm());
    off.fold(0.0, f64::max)
}

/// A quadratic field is met everywhere, beyond the chords of the rim, too; of a wave the error falls with the third power.
#[test]
fn interpolation_is_of_third_order() {
    let quadratic = |p: &Vector2<f64>| {
        let [x, y] = [p.x / 0.1, p.y / 0.1];
        Vector3::new(1.0 + x - y * y, x * y, 2.0 * x * x - 3.0 * y)
    };
    assert!(interpolation_error(100, quadratic) < 1e-11);
    let wave = |p: &Vector2<f64>| Vector3::new((30.0 * p.x).sin(), (20.0 * p.y).cos(), 0.0);
    let [coarse, fine] = [300, 4800].map(|n| interpolation_error(n, wave));
    let order = (coarse / fine).log(4.0);
    assert!(order > 2.7 && coarse < 0.03, "order {order}");
}

/// At the vertices themselves it is what was given, but for rounding.
#[test]
fn interpolation_goes_through_what_is_given() {
    let mesh = meshed(&outlines()[3], 400, 0.2, 1);
    let values: Vec<_> = (0..mesh.material.len())
        .map(|v| Vector3::new(v as f64, 0.0, -1.0))
        .collect();
    for (found, given) in interpolate(&mesh, &values, &mesh.material)
        .iter()
        .zip(&values)
    {
        assert!(
            (found - given).norm() < 1e-9 * given.norm(),
            "{found} for {given}"
        );
    }
}
