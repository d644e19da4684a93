//! Readings: means over points, between vertices too, and over regions.

use nalgebra::Vector2;
use toile::scene::{Override, library, parse};
use toile::sim::{Probe, Refused, Simulation};

use crate::lab::{built_in, simulation};

/// A square of 200 mm on a mesh of its own.
fn square(set: &[&str]) -> Simulation {
    simulation(&built_in("drape-table", set))
}

/// A field that is linear is read exactly wherever the vertices lie.
#[test]
fn a_point_is_read_where_it_is() {
    for triangles in ["sheet.triangles=150", "sheet.triangles=333"] {
        let flat = square(&[triangles, "perturbation.amplitude=0"]);
        let (mesh, places) = (&flat.model().mesh, &flat.state().positions);
        for point in [[0.1, 0.0], [0.0123, -0.0456], [-0.1, -0.1]].map(Vector2::from) {
            let read = Probe::at(mesh, &[point]).read(places);
            assert!(
                (read.xy() - point).norm() < 1e-15,
                "{point} is read at {read}"
            );
        }
    }
}

/// The mean over a side is that along it, over a part within by area; what is refined counts no more.
#[test]
fn a_region_is_read_as_its_mean() {
    let set = [
        "sheet.triangles=600",
        "perturbation.amplitude=0",
        "sheet.refine={ region = { kind = \"point\", at = [0.1, 0.1] }, factor = 0.2 }",
        "observe.side={ region = { kind = \"x-max\" }, axis = \"y\" }",
        "observe.rim={ region = { kind = \"boundary\" }, axis = \"x\" }",
    ];
    let flat = square(&set);
    for (reading, mean) in [("side", 0.0), ("rim", 0.0)] {
        let found = flat.model().readings.iter().find(|r| r.name == reading);
        let start = found.unwrap().start;
        assert!((start - mean).abs() < 1e-15, "{reading} starts at {start}");
    }
    let mean = |region| Probe::over(&flat.model().mesh, &region).read(&flat.state().positions);
    let quarter = toile::scene::Region::Box {
        min: [0.0, 0.0],
        max: [0.05, 0.05],
    };
    assert!((mean(quarter).xy() - Vector2::repeat(0.025)).norm() < 4e-3);
}

#[test]
fn what_cannot_be_read_is_refused() {
    let refusal = |set: &[&str]| {
        let set: Vec<Override> = set.iter().map(|s| Override::parse(s).unwrap()).collect();
        let refused = parse(library::text("drape-table").unwrap(), &set).unwrap_err();
        refused.to_string()
    };
    let side = "observe.corner.region={ kind = \"x-max\" }";
    for (set, parts) in [
        (
            &[side][..],
            ["observe.corner.region", "goes without points"],
        ),
        (
            &["observe.nothing.axis=x"],
            ["observe.nothing", "give it points or a region"],
        ),
        (
            &["observe.far={ axis = \"x\", region = { kind = \"point\", at = [1.0, 0.0] } }"],
            ["observe.far.region.at", "outside the sheet"],
        ),
    ] {
        let refused = refusal(set);
        assert!(parts.iter().all(|part| refused.contains(part)), "{refused}");
    }
    let between = "observe.between={ axis = \"x\", region = { kind = \"ring\", outer = 0.08, inner = 0.0799 } }";
    let scene = built_in("drape-table", &["sheet.triangles=50", between]);
    let refused = Simulation::new(&scene, 1).err().unwrap();
    assert_eq!(refused, Refused::NothingSeen("between".to_string()));
}
