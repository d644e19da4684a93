//! The scenes of the paper's figures, on coarse meshes: they run, and show what the figures are about.

use crate::lab::{built_in, reading, run, simulation};
use toile::sim::Simulation;

/// Largest membrane strain of a run's end: a mesh that is destroyed has strains of whole numbers.
fn intact(simulation: &Simulation) -> bool {
    simulation.report().largest_strain < 0.1
}

/// Fig. 9: the corners of a square held at its middle fall nearly as far as the cloth is long, and the mesh stays whole.
#[test]
fn a_square_held_at_a_point_hangs_whole() {
    let end = run(&built_in("held-point", &["sheet.triangles=400"]));
    let corner = reading(&end, "corner");
    println!("held point: corners at {:.1} mm", 1e3 * corner);
    assert!((-0.145..-0.08).contains(&corner), "{corner}");
    assert!(intact(&end), "{}", end.report().largest_strain);
}

/// Fig. 23-24: what stood half a metre above the hand ends below it.
#[test]
fn a_sheet_held_at_its_foot_falls_over() {
    for fabric in ["F10", "F1"] {
        let set = [
            "sheet.triangles=400",
            "duration=1.0",
            &format!("fabric.name={fabric}"),
        ];
        let end = run(&built_in("falling-sheet", &set));
        let top = 0.5 + reading(&end, "top");
        println!("falling sheet, {fabric}: top at {:.0} mm", 1e3 * top);
        assert!((-0.55..0.0).contains(&top), "{fabric}: {top}");
        assert!(intact(&end), "{}", end.report().largest_strain);
    }
}

/// Fig. 5, both treatments side by side, at rest: contact with friction, and the part on the table left out.
#[test]
fn both_treatments_of_the_table_bring_the_corners_down() {
    let set = [
        "sheet.triangles=1500",
        "method.scheme=equilibrium",
        "duration=0.01",
    ];
    let corner = |name: &str| {
        let mut simulation = simulation(&built_in(name, &set));
        simulation.step().unwrap_or_else(|e| panic!("{e}"));
        assert!(intact(&simulation));
        assert!(simulation.equilibrium().unwrap().lowest_frequency > 0.1);
        reading(&simulation, "corner")
    };
    let [lying, clamped] = ["drape-table", "drape-table-part"].map(corner);
    println!(
        "corners at {:.1} mm lying, {:.1} mm clamped",
        1e3 * lying,
        1e3 * clamped
    );
    for at in [lying, clamped] {
        assert!((-0.055..-0.025).contains(&at), "{at}");
    }
    assert!((lying - clamped).abs() < 0.01);
}
