//! `toile plan`: the promise is kept against an independent, finer run, or it says why it cannot be made.

use cpu_time::ThreadTime;
use toile::chart::plan::{PlanError, Tolerance, check, plan};
use toile::chart::problems;
use toile::chart::rows::Asked;
use toile::chart::waterfall::{to_csv, waterfall};
use toile::chart::waterfall_plot::falls;
use toile::chart::work_precision::Problem;
use toile::scene::{Method, Scheme};

use crate::cli::{assert_refusal, err, out, toile};
use crate::lab::{built_in, reading, run};

fn clock() -> impl FnMut() -> f64 {
    let start = ThreadTime::now();
    move || start.elapsed().as_secs_f64()
}

#[test]
fn tolerances_are_read() {
    assert_eq!("1%".parse(), Ok(Tolerance(0.01)));
    assert_eq!("0.05".parse(), Ok(Tolerance(0.05)));
    for wrong in ["0", "-1%", "80%", "one", "nan"] {
        assert!(wrong.parse::<Tolerance>().is_err(), "{wrong}");
    }
}

/// Against central differences on four times the triangles, at the end of the run.
#[test]
fn validate_a_plan_keeps_its_promise() {
    for (name, set, share) in [
        (
            "strip-release",
            ["duration=0.15", "sheet.triangles=400", "damping=0.2"],
            0.05,
        ),
        (
            "four-edges",
            ["duration=0.1", "sheet.triangles=800", "damping=2"],
            0.05,
        ),
    ] {
        let scene = built_in(name, &set);
        let plan = plan(&scene, (Tolerance(share), 60.0), &mut clock(), &mut |_| {})
            .unwrap_or_else(|e| panic!("{name}: {e}"));
        let [space, time] = plan.errors;
        assert!(
            space + time <= share && plan.chosen.cpu > 0.0,
            "{name}: {plan:?}"
        );
        let dearer = plan
            .methods
            .iter()
            .filter(|t| t.error.is_some_and(|e| e + space <= share));
        assert!(dearer.min_by(|a, b| a.cpu.total_cmp(&b.cpu)).unwrap().cpu >= plan.chosen.cpu);
        let mut truth = scene.clone();
        truth.method = truth.method.with(Method::from(Scheme::CentralDifference));
        truth.sheet.triangles = Some(4 * plan.chosen.triangles);
        let (ours, truth) = (run(&plan.scene), run(&truth));
        let largest = scene
            .observe
            .keys()
            .map(|key| reading(&truth, key).abs())
            .fold(0.0, f64::max);
        for key in scene.observe.keys() {
            let off = (reading(&ours, key) - reading(&truth, key)).abs() / largest;
            println!(
                "{name}: {} at {:.2e} s on {} triangles, {key} off by {off:.4}",
                plan.chosen.method.name(),
                plan.chosen.dt,
                plan.chosen.triangles
            );
            assert!(off <= share, "{name}: {key} off by {off}");
        }
        let second_look = check(&plan, &mut clock()).unwrap();
        println!("{name}: {second_look:?}, order {:?}", plan.order);
        assert!(
            second_look.error <= share && second_look.change < second_look.error,
            "{name}: {second_look:?}"
        );
    }
}

/// Where each step ends at rest, the mesh alone is chosen; against four times the triangles.
#[test]
fn validate_a_plan_of_a_state_of_rest() {
    let share = 0.01;
    let scene = built_in("cantilever", &["method.scheme=equilibrium"]);
    let plan = plan(&scene, (Tolerance(share), 60.0), &mut clock(), &mut |_| {}).unwrap();
    assert_eq!(plan.chosen.method.scheme, Scheme::Equilibrium);
    assert!(plan.errors[0] <= share && plan.methods.is_empty());
    let mut truth = plan.scene.clone();
    truth.sheet.triangles = Some(4 * plan.chosen.triangles);
    let (ours, truth) = (run(&plan.scene), run(&truth));
    let off = |key: &str| (reading(&ours, key) - reading(&truth, key)).abs();
    let largest = reading(&truth, "tip_z").abs();
    assert!(0.0 < off("tip_z") && off("tip_z") <= share * largest);
    assert!(off("tip_x") <= share * largest);
    let second_look = check(&plan, &mut clock()).unwrap();
    assert!(second_look.error <= share, "{second_look:?}");
}

/// A ring that folds: the mean height of its rim against four times the triangles, whose folds are the same.
#[test]
fn validate_a_plan_of_a_drape() {
    let share = 0.1;
    let scene = built_in("drapemeter", &["fabric.name=F5"]);
    let plan = plan(&scene, (Tolerance(share), 60.0), &mut clock(), &mut |_| {}).unwrap();
    assert!(plan.errors[0] <= share && plan.chosen.triangles < 3000);
    assert_eq!(plan.scene.method.coarsest, Some(plan.meshes[0].triangles));
    let truth = run(&plan.scene.on_mesh(4 * plan.chosen.triangles));
    let (ours, truth) = (reading(&run(&plan.scene), "rim"), reading(&truth, "rim"));
    println!(
        "{} triangles: rim at {ours}, not {truth}",
        plan.chosen.triangles
    );
    assert!(0.0 < (ours / truth - 1.0).abs() && (ours / truth - 1.0).abs() <= share);
}

/// Each way costs less than the one before it, and one that was left has no error; all of them are drawn.
#[test]
fn verify_what_each_economy_saves() {
    let scene = built_in(
        "four-edges",
        &["duration=0.1", "sheet.triangles=800", "damping=60"],
    );
    let within = (Tolerance(0.05), 2.0);
    let bars = waterfall(&scene, within, &mut clock(), &mut |_| {}).unwrap();
    assert_eq!(bars.len(), 5);
    for pair in bars[..4].windows(2) {
        assert!(pair[1].cpu_rate < pair[0].cpu_rate, "{pair:?}");
    }
    let finished = bars.iter().filter_map(|bar| bar.error);
    assert!(finished.clone().count() >= 3);
    assert!(finished.fold(0.0, f64::max) < 0.05, "{bars:?}");
    assert_eq!(to_csv(&bars).lines().count(), 6);
    let svg = falls("a <title>", "F1", &bars).unwrap();
    for bar in &bars {
        assert!(svg.contains(&bar.method.name()), "{bar:?}");
    }
    assert_eq!(svg.matches("triangles").count(), 5);
}

/// Coarse meshes have no vertex where the scene looks: they are left out. A mesh as fine as the scene's own is not.
#[test]
fn a_mesh_too_coarse_for_the_scene_is_left_out() {
    let planned = |width: f64| {
        let looks = format!(
            "observe.small={{ axis = \"z\", region = {{ kind = \"ring\", outer = 0.06, inner = {} }} }}",
            0.06 - width
        );
        let set = ["sheet.triangles=1600", "duration=0.02", &looks];
        let scene = built_in("strip-release", &set);
        plan(&scene, (Tolerance(0.2), 60.0), &mut clock(), &mut |_| {})
    };
    let [wide, narrow] = [0.05, 1e-3].map(|width| planned(width).unwrap());
    assert_eq!(wide.meshes[0].triangles, 50);
    assert!(narrow.meshes[0].triangles > 50, "{:?}", narrow.meshes);
    let refused = planned(1e-9).unwrap_err().to_string();
    let told = "observe.small.region holds no vertex";
    assert!(refused.contains(told), "{refused}");
}

#[test]
fn what_cannot_be_planned_is_told() {
    let mut silent = |_: &str| {};
    let nothing = built_in("strip-release", &[]);
    let nothing = toile::scene::Scene {
        observe: Default::default(),
        ..nothing
    };
    let refused = plan(&nothing, (Tolerance(0.01), 60.0), &mut clock(), &mut silent);
    assert!(matches!(refused, Err(PlanError::NothingObserved(_))));
    let fine = built_in("strip-release", &["sheet.triangles=60", "duration=0.05"]);
    let refused = plan(&fine, (Tolerance(1e-5), 1.0), &mut clock(), &mut silent).unwrap_err();
    let PlanError::TooFine { finer, dearer, .. } = refused else {
        panic!("{refused}");
    };
    assert!(1.0 < finer && finer < dearer, "{refused}");
    let hasty = plan(&fine, (Tolerance(0.01), 1e-9), &mut clock(), &mut silent);
    assert_eq!(hasty, Err(PlanError::TooDear { budget: 1e-9 }));
    let still = built_in("drapemeter", &["sheet.triangles=100"]);
    let refused = waterfall(&still, (Tolerance(0.1), 60.0), &mut clock(), &mut silent);
    assert_eq!(refused, Err(PlanError::NoTime("drapemeter".to_string())));
    let within = (Tolerance(1e-5), 0.1);
    let refused = plan(&still, within, &mut clock(), &mut silent).unwrap_err();
    assert!(!refused.to_string().contains("duration"), "{refused}");
    // A large sheet sinks in something thick: all meshes agree, and its substep is as long as the sinking takes to set in.
    let set = [
        "damping=100",
        "duration=0.05",
        "sheet.triangles=60",
        "sheet.outline.length=5",
        "sheet.outline.width=5",
    ];
    let sinks = built_in("free-fall", &set);
    let refused = plan(&sinks, (Tolerance(1e-5), 60.0), &mut clock(), &mut silent).unwrap_err();
    let PlanError::TooSensitive { space, time, .. } = refused else {
        panic!("{refused}");
    };
    assert!(space < 1e-6 && 1e-3 < time && time < 1e-2, "{refused}");
}

#[test]
fn the_command_line_plans_and_checks() {
    let dir = tempfile::tempdir().unwrap();
    let scene = [
        "strip-release",
        "--set",
        "sheet.triangles=200",
        "--set",
        "damping=1",
        "--duration",
        "0.1",
        "--tolerance",
        "10%",
    ];
    let output = toile(dir.path(), &[&["plan"], &scene[..]].concat());
    assert_eq!(output.status.code(), Some(0), "{}", err(&output));
    let text = out(&output);
    for part in [
        "strip-release within 10 %",
        "estimated error",
        "central-difference",
        "quasi-newton",
    ] {
        assert!(text.contains(part), "{part} is not in {text}");
    }
    let output = toile(dir.path(), &[&["run"], &scene[..], &["--json"]].concat());
    assert_eq!(output.status.code(), Some(0), "{}", err(&output));
    let said: serde_json::Value = serde_json::from_str(&out(&output)).unwrap();
    assert!(said["tolerance"]["error"].as_f64().unwrap() > 0.0, "{said}");
    let refused = ["run", "strip-release", "--tolerance", "1%", "--dt", "1e-3"];
    assert_refusal(&toile(dir.path(), &refused), 2, &["--tolerance"]);
    let refused = ["plan", "strip-release", "--tolerance", "0"];
    assert_refusal(&toile(dir.path(), &refused), 2, &["0.001%"]);
}

/// Every charted scene has a problem whose runs can begin.
#[test]
fn consistency_of_the_charted_scenes() {
    let all = problems::CHARTED.map(|name| Problem::all_of(built_in(name, &[])).unwrap());
    for problem in all.into_iter().flatten() {
        let name = &problem.name;
        assert!(
            problem.meshes.len() >= 2 && !problem.steps.is_empty(),
            "{name}"
        );
        for dt in &problem.steps {
            for time in &problem.times {
                let count = time / dt;
                assert!(
                    (count - count.round()).abs() < 1e-6,
                    "{name}: {dt} s does not divide {time} s"
                );
            }
        }
        let key = problem.key(Scheme::Bdf2.into(), Asked::Step(problem.steps[0]), 50);
        let scene = problem.scene_of(&key).unwrap();
        assert_eq!(scene.sheet.triangles, Some(50));
        let mut simulation = crate::lab::simulation(&scene);
        simulation.step().unwrap_or_else(|e| panic!("{name}: {e}"));
    }
}
