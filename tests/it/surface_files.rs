//! A scene that names a file of triangles: run, drawn and replayed without the file; one line for a broken one.

use std::fs;
use std::path::Path;

use tempfile::TempDir;
use toile::contact::Shape;
use toile::node::Recording;
use toile::scene::{parse, parse_with};
use toile::sim::Simulation;
use toile::wire::messages::geometry_msgs::Point;
use toile::wire::messages::moveit_msgs::CollisionObject;
use toile::wire::messages::shape_msgs::{Mesh, MeshTriangle};
use toile::wire::messages::toile_msgs::ObstacleCommand;
use toile::wire::messages::visualization_msgs::MarkerArray;
use toile::wire::{cdr, channels, inbound, keyframe};

use crate::cli::{assert_refusal, err, out, toile};
use crate::recording::assert_whole;
use crate::session::{order, pose};
use crate::surfaces::grid;

const SCENE: &str = "name = \"ring\"\ndescription = \"A square over a ring of triangles\"\nduration = 0.04\n\
    [sheet]\noutline = { kind = \"rectangle\", length = 0.08, width = 0.08 }\ntriangles = 150\n\
    position = [0.0, 0.0, 0.0105]\n[fabric]\nname = \"F1\"\n[output]\nrate = 50\nkeyframe_interval = 0.02\n\
    [obstacle.ring]\nshape = { kind = \"mesh\", file = \"parts/ring.stl\", scale = 1e-3 }\nfriction = 0.3\n\
    [obstacle.ring.motion]\ntimes = [0.0, 0.1]\npositions = [[0.0, 0.0, 0.0], [0.0, 0.0, 0.01]]\n\
    [method]\nscheme = \"central-difference\"\ndt = 4e-3\n";

/// A torus in millimetres, as a binary STL.
fn ring() -> Vec<u8> {
    let [big, small] = [25.0, 10.0];
    let torus = grid(28, 14, [true, true], |u, v| {
        let [u, v] = [u, v].map(|turn| turn * std::f64::consts::TAU);
        let around = big + small * v.cos();
        [around * u.cos(), around * u.sin(), small * v.sin()]
    });
    let corner = |v: u32| stl_io::Vertex::new(torus.vertices[v as usize].map(|c| c as f32));
    let triangles = torus.triangles.iter().map(|t| stl_io::Triangle {
        normal: stl_io::Normal::new([0.0; 3]),
        vertices: t.map(corner),
    });
    let triangles: Vec<_> = triangles.collect();
    let mut bytes = vec![];
    stl_io::write_stl(&mut bytes, triangles.iter()).expect("writes");
    bytes
}

fn put(dir: &Path, scene: &str, file: &[u8]) {
    fs::create_dir_all(dir.join("scenes/parts")).unwrap();
    fs::write(dir.join("scenes/ring.toml"), scene).unwrap();
    fs::write(dir.join("scenes/parts/ring.stl"), file).unwrap();
}

#[test]
fn a_recording_needs_no_file_of_triangles() {
    let dir = TempDir::new().unwrap();
    put(dir.path(), SCENE, &ring());
    let output = toile(dir.path(), &["run", "scenes/ring.toml", "-o", "a.mcap"]);
    assert_eq!(output.status.code(), Some(0), "{}", err(&output));
    fs::remove_dir_all(dir.path().join("scenes")).unwrap();
    let replayed = toile(dir.path(), &["replay", "a.mcap"]);
    assert_eq!(replayed.status.code(), Some(0), "{}", err(&replayed));
    assert!(
        out(&replayed).contains("the same bits"),
        "{}",
        out(&replayed)
    );
    // From a keyframe, which holds the triangles too.
    let later = toile(dir.path(), &["replay", "a.mcap", "--from", "8"]);
    assert_eq!(later.status.code(), Some(0), "{}", err(&later));
    let drawn = toile(dir.path(), &["show", "a.mcap", "-o", "a.png"]);
    assert_eq!(drawn.status.code(), Some(0), "{}", err(&drawn));
    let path = dir.path().join("a.mcap");
    assert_whole(&path);
    let bytes = fs::read(&path).unwrap();
    let messages = mcap::MessageStream::new(&bytes).expect("an MCAP file");
    let messages = messages.map(|message| message.expect("an undamaged message"));
    let drawn = messages.filter(|m| m.channel.topic == channels::OBSTACLE_MARKERS.topic);
    let drawn: Vec<MarkerArray> = drawn
        .map(|m| cdr::decode(&m.data).expect("decodes"))
        .collect();
    assert_eq!(drawn.len(), 1, "said once");
    let list = &drawn[0].markers[1];
    assert_eq!(
        (list.header.frame_id.as_str(), list.frame_locked),
        ("ring", true)
    );
    assert_eq!(list.points.len(), 3 * 2 * 28 * 14);
    Recording::open(&path).expect("opens");
}

/// The cloth comes down on the ring, and a keyframe gives back the state with its triangles, bit for bit.
#[test]
fn a_keyframe_holds_triangles() {
    let read = |_: &str| Ok(ring());
    let (scene, _) = parse_with(SCENE, &[], &read).unwrap_or_else(|e| panic!("{e}"));
    let again = parse(&scene.to_toml(), &[])
        .unwrap_or_else(|e| panic!("{e}"))
        .0;
    assert_eq!(again, scene);
    let mut simulation = Simulation::new(&scene, 1).unwrap_or_else(|e| panic!("{e}"));
    for _ in 0..5 {
        simulation.step().unwrap_or_else(|e| panic!("{e}"));
    }
    assert!(simulation.report().contacts > 0);
    let state = simulation.state();
    let kept = keyframe::keyframe(state, state.digest(), 0.0);
    let back = keyframe::state(&kept).unwrap_or_else(|e| panic!("{e}"));
    assert_eq!(
        (back.digest(), &back.obstacles),
        (state.digest(), &state.obstacles)
    );
    let mut broken = kept.clone();
    broken.obstacles[0].dimensions.pop();
    assert!(keyframe::state(&broken).is_err());
}

#[test]
fn a_broken_file_is_one_line() {
    let refuses = |scene: &str, file: &[u8], parts: &[&str]| {
        let dir = TempDir::new().unwrap();
        put(dir.path(), scene, file);
        let output = toile(dir.path(), &["run", "scenes/ring.toml"]);
        let named = ["obstacle.ring.shape"].iter().chain(parts);
        assert_refusal(&output, 2, &named.copied().collect::<Vec<_>>());
    };
    let file = "obstacle.ring.shape.file = \"parts/ring.stl\"";
    let line = "line 14";
    refuses(SCENE, b"", &[file, line, "cannot be read as STL"]);
    refuses(SCENE, &ring()[..400], &[file, "cannot be read as STL"]);
    refuses(
        SCENE,
        b"v 0 0 0\nv 1 0 0\n",
        &[file, "no triangles", "1 to 200000"],
    );
    let beyond = b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 7\n";
    refuses(
        SCENE,
        beyond,
        &[file, "cannot be read as OBJ", "out of bounds"],
    );
    let flat = b"v 0 0 0\nv 1 0 0\nv 2 0 0\nf 1 2 3\n";
    refuses(SCENE, flat, &[file, "triangle 0 has no area"]);
    let far = b"v 0 0 0\nv 1e9 0 0\nv 0 1 0\nf 1 2 3\n";
    refuses(SCENE, far, &[file, "from -1000 to 1000 m"]);
    let nan = b"v 0 0 0\nv nan 0 0\nv 0 1 0\nf 1 2 3\n";
    refuses(SCENE, nan, &[file]);
    let missing = SCENE.replace("parts/ring.stl", "parts/rong.stl");
    refuses(&missing, b"", &["scenes/parts/rong.stl", "No such file"]);
    let shape = "{ kind = \"mesh\", file = \"parts/ring.stl\", scale = 1e-3 }";
    let with = |other: &str| SCENE.replace(shape, other);
    let bare = with("{ kind = \"mesh\" }");
    refuses(&bare, b"", &["needs file", "vertices and triangles"]);
    let both = with("{ kind = \"mesh\", file = \"parts/ring.stl\", triangles = [[0, 1, 2]] }");
    refuses(&both, b"", &[".file", "not both"]);
    let corners = "vertices = [[0, 0, 0], [0, 0.1, 0], [0.1, 0, 0]]";
    let index = with(&format!(
        "{{ kind = \"mesh\", {corners}, triangles = [[0, 1, 3]] }}"
    ));
    refuses(
        &index,
        b"",
        &[".triangles", "has vertex 3: must be from 0 to 2"],
    );
    let fraction = with(&format!(
        "{{ kind = \"mesh\", {corners}, triangles = [[0, 1, 1.5]] }}"
    ));
    refuses(&fraction, b"", &[".triangles", "whole numbers from 0"]);
    let scaled = with(&format!(
        "{{ kind = \"mesh\", {corners}, triangles = [[0, 1, 2]], scale = 2.0 }}"
    ));
    refuses(&scaled, b"", &[".scale", "goes with file"]);
}

/// A command brings triangles, as our own message and as a planner's object; the obstacle stands in the next step.
#[test]
fn commands_bring_triangles() {
    let corners = [
        [0.0; 3],
        [0.02, 0.0, 0.0],
        [0.0, 0.02, 0.0],
        [0.0, 0.0, 0.02],
    ];
    let sides = [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]];
    let mesh = Mesh {
        vertices: corners.map(|[x, y, z]| Point { x, y, z }).to_vec(),
        triangles: sides
            .map(|vertex_indices| MeshTriangle { vertex_indices })
            .to_vec(),
    };
    let own = ObstacleCommand {
        operation: ObstacleCommand::ADD,
        name: "tip".to_string(),
        shape: ObstacleCommand::MESH,
        mesh: mesh.clone(),
        pose: pose(0.0, 0.0, -0.5),
        ..ObstacleCommand::default()
    };
    let object = CollisionObject {
        operation: CollisionObject::ADD,
        id: "top".to_string(),
        meshes: vec![mesh],
        mesh_poses: vec![pose(0.0, 0.0, -0.6)],
        ..CollisionObject::default()
    };
    let (scene, _) =
        parse_with(SCENE, &[], &|_: &str| Ok(ring())).unwrap_or_else(|e| panic!("{e}"));
    let mut simulation = Simulation::new(&scene, 1).unwrap_or_else(|e| panic!("{e}"));
    let sent = [
        order("/toile/cmd/obstacle", &own),
        order("/toile/cmd/collision_object", &object),
    ];
    for order in sent {
        let request = inbound::decode(order.inlet, &order.bytes).unwrap_or_else(|e| panic!("{e}"));
        for command in request.commands(&simulation.state().obstacles) {
            simulation.apply(&command).unwrap_or_else(|e| panic!("{e}"));
        }
    }
    simulation.step().unwrap_or_else(|e| panic!("{e}"));
    for name in ["tip", "top"] {
        let at = simulation.state().find_obstacle(name).expect("was added");
        let shape = &simulation.state().obstacles[at].shape;
        assert!(matches!(shape, Shape::Mesh(surface) if surface.is_closed()));
    }
}
