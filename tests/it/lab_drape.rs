//! The drapemeter: its readings on known shapes, its states, its refusals.

use std::f64::consts::PI;

use nalgebra::Vector3;
use toile::chart::drape::{Row, cell, chart, correlations, summary};
use toile::fabric::TwistRigidity;
use toile::instrument::drapemeter::paper::PUBLISHED;
use toile::instrument::drapemeter::{DIRECTIONS, RAYS, Shadow, drape, fold_list};
use toile::instrument::{DrapeSettings, Hold, Instrument, Settings};
use toile::scene::FabricSpec;
use toile::sheet::{MeshOptions, Outline, generate};

const PLATE: f64 = 0.075;
const RIM: f64 = 0.125;

fn fabric(name: &str) -> FabricSpec {
    FabricSpec {
        name: name.into(),
        ..FabricSpec::default()
    }
}

/// Shadow of a ring whose outline is `rim(angle)`: points between the plate and it keep their angle.
fn shadow_of(rim: impl Fn(f64) -> f64) -> Shadow {
    let outline = Outline::Annulus {
        outer: 2.0 * RIM,
        inner: 2.0 * PLATE,
    };
    let options = MeshOptions {
        edge: 2e-3,
        jitter: 0.0,
        seed: 0,
        warp_angle: 0.0,
    };
    let mesh = generate(&outline, &options);
    let place = |p: &nalgebra::Vector2<f64>| {
        let share = (p.norm() - PLATE) / (RIM - PLATE);
        let radius = PLATE + share * (rim(p.y.atan2(p.x)) - PLATE);
        (p.normalize() * radius).push(-0.01 * share)
    };
    let positions: Vec<Vector3<f64>> = mesh.outline.iter().map(place).collect();
    Shadow::of(&mesh, &positions)
}

/// Flat, hanging straight down, and a wave of seven folds, whose area is known.
#[test]
fn verify_the_shadow_of_known_shapes() {
    let flat = shadow_of(|_| RIM);
    assert!((flat.coefficient(PLATE, RIM) - 1.0).abs() < 1e-3);
    assert!((flat.coefficient_by_rays(PLATE, RIM) - 1.0).abs() < 1e-3);
    assert!(fold_list(&flat, RIM - PLATE).is_empty());
    let straight = shadow_of(|_| PLATE * 1.000_001);
    assert!(straight.coefficient(PLATE, RIM).abs() < 1e-3);

    let (mean, swing) = (0.1, 0.015);
    let wave = shadow_of(|angle| mean + swing * (7.0 * angle).cos());
    let area = PI * (mean * mean + 0.5 * swing * swing);
    let exact = (area - PI * PLATE * PLATE) / (PI * (RIM * RIM - PLATE * PLATE));
    let read = wave.coefficient(PLATE, RIM);
    assert!((read - exact).abs() < 2e-3, "{read}, not {exact}");
    let folds = fold_list(&wave, RIM - PLATE);
    assert_eq!(folds.len(), 7);
    for fold in folds {
        assert!((fold.tip - (mean + swing)).abs() < 3e-4, "{fold:?}");
        assert!((fold.depth - 2.0 * swing).abs() < 6e-4, "{fold:?}");
        let chord = 2.0 * (mean - swing) * (PI / 7.0).sin();
        assert!((fold.width - chord).abs() < 2e-3, "{fold:?}, not {chord}");
    }
    // Sixteen rays on eight folds see crests only: the alias that the paper's reading has.
    let eight = shadow_of(|angle| mean + swing * (16.0 * angle).cos());
    let off = eight.coefficient_by_rays(PLATE, RIM) - eight.coefficient(PLATE, RIM);
    assert!(off > 0.2, "{off}");
    assert_eq!(eight.radii.len(), DIRECTIONS);
    assert_eq!(DIRECTIONS % RAYS, 0);
}

/// A stiff disc stays flat, a limp one drapes, and both states are minima at the residual asked for.
#[test]
fn limp_cloth_drapes_more_than_stiff() {
    let set = DrapeSettings {
        triangles: 500,
        ..DrapeSettings::default()
    };
    let mut stiff = fabric("F9");
    stiff.rigidity_warp = Some(1e-2);
    stiff.rigidity_weft = Some(1e-2);
    let [stiff, limp] = [stiff, fabric("F9")].map(|f| drape(&f, &set, 1).unwrap());
    assert!(stiff.coefficient > 0.99, "{stiff:?}");
    assert!((0.4..0.8).contains(&limp.coefficient), "{limp:?}");
    for state in [&stiff, &limp] {
        assert!(
            state.residual <= 1e-6 && state.lowest_frequency > 0.1,
            "{state:?}"
        );
    }
    assert!(limp.folds >= 4 && stiff.folds == 0);
    assert!(limp.energy < 0.0 && limp.fold_length < 0.05);
}

/// What lies on the plate drapes more than what is clamped at its edge; twist rigidity makes cloth stiffer.
#[test]
fn the_hold_and_the_twist_matter() {
    let set = DrapeSettings {
        triangles: 800,
        ..DrapeSettings::default()
    };
    let resting = DrapeSettings {
        hold: Hold::Resting,
        ..set
    };
    let mut pliant = fabric("F9");
    pliant.twist = TwistRigidity::None;
    let mean = |f: &FabricSpec, set: &DrapeSettings| {
        let all = (1..=2).map(|seed| drape(f, set, seed).unwrap().coefficient);
        all.sum::<f64>() / 2.0
    };
    let clamped = mean(&fabric("F9"), &set);
    let lying = mean(&fabric("F9"), &resting);
    let pliant = mean(&pliant, &set);
    println!("F9: clamped {clamped:.3}, resting {lying:.3}, clamped without twist {pliant:.3}");
    assert!(lying < clamped - 0.02, "{lying} resting, {clamped} clamped");
    assert!(
        pliant < clamped - 0.02,
        "{pliant} without twist, {clamped} with"
    );
}

/// Every reading comes with its spread over seeds, and the states are in the report.
#[test]
fn a_drape_report_has_every_state() {
    let settings = Settings {
        drape: DrapeSettings {
            triangles: 300,
            seeds: 3,
            ..DrapeSettings::default()
        },
        ..Settings::default()
    };
    let report = Instrument::Drapemeter
        .measure(&fabric("F3"), &settings)
        .unwrap();
    assert_eq!(report.drapes.len(), 3);
    let reading = report.reading("drape coefficient, shadow").unwrap();
    let mean = report
        .drapes
        .iter()
        .map(|d| 1e2 * d.coefficient)
        .sum::<f64>()
        / 3.0;
    assert!((reading.value - mean).abs() < 1e-9 && reading.spread.unwrap() > 0.0);
    assert!(
        report
            .warnings
            .iter()
            .any(|w| w.contains("half the bending length"))
    );
    let again = drape(&fabric("F3"), &settings.drape, 2).unwrap();
    assert_eq!(again, report.drapes[1], "the same seed gives the same bits");
}

#[test]
fn a_disc_smaller_than_its_plate_is_refused() {
    let set = DrapeSettings {
        specimen: 0.14,
        ..DrapeSettings::default()
    };
    let error = drape(&fabric("F1"), &set, 1).unwrap_err().to_string();
    assert_eq!(
        error,
        "specimen = 0.14: must be at least 0.1575 m, 5 % more than the plate of 0.15 m"
    );
    let error = drape(&fabric("F99"), &DrapeSettings::default(), 1).unwrap_err();
    assert!(error.to_string().contains("F99"), "{error}");
}

/// The audit's table reads back as it was written, and its means and correlations are those of its rows.
#[test]
fn the_audit_reads_back_and_sums_up() {
    let set = DrapeSettings {
        triangles: 150,
        ..DrapeSettings::default()
    };
    let one = drape(&fabric("F9"), &set, 1).unwrap();
    let mut rows = vec![];
    for (k, published) in PUBLISHED.iter().enumerate() {
        for seed in [1, 2] {
            let mut drape = one.clone();
            drape.coefficient = 1e-2 * (0.5 * published.measured.0 + 20.0 + seed as f64);
            drape.seed = seed;
            drape.folds = 5 + k;
            drape.outline.clear();
            rows.push(Row::new(
                Row::key(&fabric(published.fabric), &set, seed),
                drape,
            ));
        }
    }
    let lines: String = rows.iter().map(Row::line).collect();
    let read = Row::read(&format!("{}{lines}", Row::head())).unwrap();
    assert_eq!(read.len(), rows.len());
    for (read, row) in read.iter().zip(&rows) {
        assert_eq!(read.key, row.key);
        assert!((read.drape.coefficient - row.drape.coefficient).abs() < 1e-6);
        assert_eq!(read.drape.folds, row.drape.folds);
    }
    let c = cell(&read, "F9", Hold::Clamped).unwrap();
    assert!((c.mean - 43.5).abs() < 1e-3 && c.count == 2, "{c:?}");
    assert!((c.range.1 - c.range.0 - 1.0).abs() < 1e-3);
    assert_eq!(cell(&read, "F9", Hold::Resting), None);
    // Ours is a linear function of the measured: the correlation is one.
    let [all, kept] = correlations(&read, Hold::Clamped);
    assert!((all.unwrap() - 1.0).abs() < 1e-6 && (kept.unwrap() - 1.0).abs() < 1e-6);
    let text = summary(&read);
    assert!(text.contains("| F7* | 93 (6) | 94 (7) |"), "{text}");
    let svg = chart(&read).unwrap();
    assert_eq!(svg.matches("F10").count(), 2, "once on each panel");
    assert!(Row::read("fabric,what\n").is_err());
    let broken = format!("{}F1,clamped,250\n", Row::head());
    assert_eq!(Row::read(&broken).unwrap_err(), "line 2: not a drape");
}

/// The numbers of Tables 3 and 4 that stand beside ours are those of the reference files.
#[test]
fn the_published_drape_is_that_of_the_tables() {
    let tables = [
        include_str!("../references/paper_table3_drape_measured.csv"),
        include_str!("../references/paper_table4_drape_simulated.csv"),
    ];
    for (published, k) in PUBLISHED.iter().flat_map(|p| [(p, 0), (p, 1)]) {
        let table = crate::lab::Table::new(tables[k]);
        let ours = [published.measured, published.simulated][k];
        assert_eq!(ours.0, table.get(published.fabric, "drape_coefficient_pct"));
        assert_eq!(f64::from(ours.1), table.get(published.fabric, "nodes"));
    }
}

/// What the kept audit shows: drape falls as the bending length does, and F7 and F9, alike in Table 2, drape alike.
#[test]
fn regress_the_kept_audit() {
    let rows = Row::read(include_str!("../../recordings/drapemeter/drapemeter.csv")).unwrap();
    for hold in Hold::ALL {
        let mut fabrics: Vec<(f64, f64)> = PUBLISHED
            .iter()
            .map(|published| {
                let fabric = toile::fabric::find(published.fabric).unwrap();
                let rigidity = (fabric.rigidity_warp * fabric.rigidity_weft).sqrt();
                let cell = cell(&rows, published.fabric, hold).unwrap();
                assert!(
                    cell.count >= 8,
                    "{}: {} drapes",
                    published.fabric,
                    cell.count
                );
                (rigidity / fabric.areal_density, cell.mean)
            })
            .collect();
        fabrics.sort_by(|a, b| a.0.total_cmp(&b.0));
        for pair in fabrics.windows(2) {
            assert!(pair[1].1 > pair[0].1 - 2.0, "{hold:?}: {pair:?}");
        }
        let mean = |name: &str| cell(&rows, name, hold).unwrap().mean;
        assert!((mean("F7") - mean("F9")).abs() < 4.0);
        // No deterministic model of Table 2 follows the measured drape.
        let [all, kept] = correlations(&rows, hold).map(Option::unwrap);
        println!("{hold:?}: correlation {all:.3} over all, {kept:.3} over nine");
        assert!(all < 0.9, "{all}");
    }
    for row in &rows {
        let drape = &row.drape;
        assert!(
            drape.residual <= 1e-6 && drape.lowest_frequency > 0.0,
            "{row:?}"
        );
    }
}
