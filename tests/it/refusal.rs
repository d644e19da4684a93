//! What a scene is refused for: one line that names key, value, what is allowed, and where it was written.

use toile::scene::{Override, SceneError, parse};

use crate::scene::{GOOD, good, sets, with};

fn refusal(text: &str, overrides: &[&str]) -> SceneError {
    let error = parse(text, &sets(overrides)).unwrap_err();
    let message = error.to_string();
    assert!(
        !message.contains('\n'),
        "an error is one line, not {message:?}"
    );
    error
}

/// The refusal of the good scene with one line replaced names all of these.
#[track_caller]
pub fn refuses(line: &str, replacement: &str, parts: &[&str]) {
    let message = refusal(&with(line, replacement), &[]).to_string();
    for part in parts {
        assert!(message.contains(part), "`{part}` is not in: {message}");
    }
}

#[track_caller]
fn refuses_set(overrides: &[&str], parts: &[&str]) {
    let message = refusal(GOOD, overrides).to_string();
    for part in parts {
        assert!(message.contains(part), "`{part}` is not in: {message}");
    }
}

#[test]
fn an_unknown_key_names_itself_its_line_and_what_is_allowed() {
    refuses(
        "damping = 0.1",
        "dampin = 0.1",
        &[
            "line 4: dampin = 0.1: unknown key",
            "did you mean `damping`?",
            "duration, gravity",
        ],
    );
    refuses(
        "scheme = \"bdf2\"",
        "algebra = 1",
        &[
            "line 22: method.algebra = 1",
            "scheme, solver, dt, tolerance",
        ],
    );
    refuses(
        "{ kind = \"x-min\" }",
        "{ kind = \"x-min\", width = 2.0 }",
        &["support.left.region.width", "allowed here: kind"],
    );
}

#[test]
fn a_wrong_type_names_both_types() {
    let parts = [
        "line 3: duration = \"long\"",
        "must be a number from",
        "not a string",
    ];
    refuses("duration = 1.0", "duration = \"long\"", &parts);
    refuses(
        "edge = 0.01",
        "triangles = 10.5",
        &[
            "line 8: sheet.triangles = 10.5",
            "a whole number from",
            "not a number",
        ],
    );
    refuses(
        "name = \"mine\"",
        "name = 3",
        &["line 1: name = 3", "not a whole number"],
    );
    refuses(
        "[output]\nrate = 100.0",
        "[output.rate]",
        &["line 25: output.rate = {}", "a number", "not a table"],
    );
    refuses(
        "size = [0.1, 0.1, 0.1]",
        "size = [0.1, \"x\", 0.1]",
        &["line 18: obstacle.table.shape.size = \"x\"", "3 numbers"],
    );
    refuses(
        "damping = 0.1",
        "damping = 2026-11-22",
        &["damping = 2026-11-22", "not a date"],
    );
}

#[test]
fn a_missing_key_names_itself_and_its_table() {
    refuses(
        "axis = \"z\"",
        "",
        &["line 28: observe.tip.axis: missing", "one of x, y, z"],
    );
    refuses(
        "duration = 1.0\n",
        "",
        &["duration: missing; needs a number from 1e-6 to 100000 s"],
    );
    refuses(
        "kind = \"box\", ",
        "",
        &["obstacle.table.shape.kind: missing", "one of plane, box"],
    );
    refuses(
        "[fabric]\nname = \"F1\"",
        "[fabric]",
        &["fabric.name: missing"],
    );
}

#[test]
fn a_value_out_of_range_names_the_range_and_its_unit() {
    refuses(
        "damping = 0.1",
        "damping = -0.1",
        &["line 4: damping = -0.1", "from 0 to 10000 kg/(m²·s)"],
    );
    for value in ["nan", "inf", "-inf", "1e400", "0", "-1.0"] {
        let line = format!("dt = {value}");
        refuses(
            "dt = 5e-3",
            &line,
            &["line 23: method.dt", "from 1e-7 to 1 s"],
        );
    }
    refuses(
        "edge = 0.01",
        "triangles = 99999999999999999999999",
        &["sheet.triangles = 99999999999999999999999", "2000000"],
    );
    refuses(
        "points = [[0.1, 0.0]]",
        "points = []",
        &["observe.tip.points = []", "at least one"],
    );
    refuses(
        "points = [[0.1, 0.0]]",
        "points = [[0.1]]",
        &["observe.tip.points = [0.1]", "pairs"],
    );
    refuses(
        "friction = 0.3",
        "friction = 11",
        &["line 19: obstacle.table.friction = 11", "from 0 to 10"],
    );
}

#[test]
fn a_word_that_is_no_choice_lists_the_choices() {
    refuses(
        "scheme = \"bdf2\"",
        "scheme = \"bdf3\"",
        &[
            "line 22: method.scheme = \"bdf3\"",
            "one of backward-euler, bdf2, generalised-alpha, central-difference",
            "did you mean `bdf2`?",
        ],
    );
    refuses(
        "kind = \"clamp\"",
        "kind = \"glue\"",
        &["support.left.kind = \"glue\"", "one of pin, clamp"],
    );
    refuses(
        "\"rectangle\"",
        "\"triangle\"",
        &["sheet.outline.kind", "rectangle, disc, annulus, sector"],
    );
}

#[test]
fn text_that_is_not_toml_names_the_line() {
    refuses("damping = 0.1", "damping = ", &["line 4: not TOML"]);
    refuses("damping = 0.1", "damping 0.1", &["line 4: not TOML"]);
    refuses("damping = 0.1", "duration = 0.1", &["line 4: not TOML"]);
    refuses("[method]", "[[method]]", &["line 21: method", "an array"]);
}

#[test]
fn exactly_one_of_triangles_and_edge() {
    refuses(
        "edge = 0.01",
        "edge = 0.01\ntriangles = 100",
        &["line 9: sheet.triangles = 100", "exactly one"],
    );
    refuses("edge = 0.01", "", &["line 6: sheet", "exactly one"]);
    refuses(
        "edge = 0.01",
        "edge = 1e-5",
        &["line 8: sheet.edge = 1e-5", "2 million triangles"],
    );
}

#[test]
fn names_are_safe_in_files_and_topics() {
    for name in ["", "../up", "a/b", ".hidden", "-o", "a b", "a\\n"] {
        let line = format!("name = \"{name}\"");
        refuses("name = \"mine\"", &line, &["line 1: name =", "letters"]);
    }
    for name in [
        "\"a b\"", "1st", "a__b", "a_", "a-b", "world", "\"ä\"", "\"\"",
    ] {
        let line = format!("[obstacle.{name}]");
        refuses(
            "[obstacle.table]",
            &line,
            &["line 17: obstacle.", "not a name"],
        );
    }
}

#[test]
fn supports_and_observations_must_meet_the_sheet() {
    refuses(
        "{ kind = \"rectangle\", length = 0.2, width = 0.1 }",
        "{ kind = \"disc\", diameter = 0.3 }",
        &[
            "line 15: support.left.region.kind = \"x-min\"",
            "only a rectangle",
        ],
    );
    refuses(
        "{ kind = \"x-min\" }",
        "{ kind = \"box\", min = [0.2, 0.0], max = [0.3, 0.1] }",
        &["support.left.region", "outside the sheet"],
    );
    refuses(
        "{ kind = \"x-min\" }",
        "{ kind = \"box\", min = [0.2, 0.0], max = [0.1, 0.1] }",
        &["support.left.region.min = [0.2, 0]", "must not exceed max"],
    );
    refuses(
        "[[0.1, 0.0]]",
        "[[0.1, 0.0], [0.11, 0.0]]",
        &[
            "line 29: observe.tip.points",
            "[0.11, 0]",
            "outside the sheet",
        ],
    );
    for axes in ["", "xx", "xw", "XYZ"] {
        let line = format!("kind = \"clamp\"\naxes = \"{axes}\"");
        refuses(
            "kind = \"clamp\"",
            &line,
            &["line 15: support.left.axes", "letters x, y, z"],
        );
    }
}

#[test]
fn a_fabric_is_known_or_complete_and_physical() {
    refuses(
        "name = \"F1\"",
        "name = \"F13\"",
        &[
            "line 11: fabric.name = \"F13\"",
            "F1, F2",
            "lacks areal_density",
        ],
    );
    refuses(
        "name = \"F1\"",
        "name = \"F1\"\nyoung_warp = -1e6",
        &["line 12: fabric.young_warp = -1e6", "from 1 to 1e13 Pa"],
    );
    // S12² >= S11 S22: pulling the warp would widen the weft more than it lengthens the warp.
    refuses(
        "name = \"F1\"",
        "name = \"F1\"\npoisson = \"symmetrised\"\npoisson_warp = 5.0",
        &["line 13: fabric.poisson_warp = 5", "not positive definite"],
    );
}

#[test]
fn a_fabric_of_ones_own_needs_every_constant() {
    let own = "name = \"felt\"\nareal_density = 0.3\nthickness = 1e-3\nyoung_warp = 1e6\nyoung_weft = 2e6\n\
               shear_modulus = 5e5\nrigidity_warp = 2e-5\nrigidity_weft = 3e-5";
    let text = with("name = \"F1\"", own);
    let fabric = good(&text, &[]).fabric.resolve().unwrap();
    assert_eq!((fabric.name.as_str(), fabric.young_weft), ("felt", 2e6));
    let lacking = text.replace("shear_modulus = 5e5\n", "");
    let message = refusal(&lacking, &[]).to_string();
    assert!(message.ends_with("lacks shear_modulus"), "{message}");
    // The constants were those of felt; none of them may colour F5.
    let other = good(&text, &["fabric.name=F5"]).fabric.resolve().unwrap();
    assert_eq!(other, toile::fabric::find("F5").unwrap());
}

#[test]
fn times_must_fit_each_other() {
    refuses(
        "rate = 100.0",
        "rate = 1000.0",
        &[
            "line 26: output.rate = 1000",
            "at most 1/method.dt = 200 Hz",
        ],
    );
    refuses_set(
        &["duration=1e-3"],
        &["--set duration=1e-3: duration = 0.001", "at least one step"],
    );
    refuses_set(
        &["method.substep=0.01"],
        &["method.substep = 0.01", "at most method.dt = 0.005 s"],
    );
    good(GOOD, &["method.substep=5e-3"]);
    // A third of a second and back is one step, whatever the rounding.
    good(GOOD, &["method.dt=0.333333333333333333", "output.rate=3"]);
}

#[test]
fn an_override_takes_the_place_of_what_it_contradicts() {
    let scene = good(GOOD, &["sheet.triangles=500"]);
    assert_eq!((scene.sheet.triangles, scene.sheet.edge), (Some(500), None));
    let shape = ["shape.kind=sphere", "shape.radius=0.05"];
    let set: Vec<_> = shape
        .iter()
        .map(|s| format!("obstacle.table.{s}"))
        .collect();
    good(GOOD, &[&set[0], &set[1]]);
    refuses_set(
        &["sheet.triangles=500", "sheet.edge=0.01"],
        &["--set sheet.triangles=500", "exactly one"],
    );
}

#[test]
fn a_refused_override_names_itself() {
    refuses_set(
        &["method.dt=-1"],
        &["--set method.dt=-1: method.dt = -1: out of range", "1e-7"],
    );
    refuses_set(
        &["method.dt=fast"],
        &["--set method.dt=fast: method.dt = \"fast\"", "not a string"],
    );
    refuses_set(
        &["dampin=0"],
        &["--set dampin=0: dampin = 0: unknown key", "`damping`"],
    );
    refuses_set(
        &["obstacle.tabel.friction=0.1"],
        &["--set obstacle.tabel.friction=0.1: obstacle.tabel.shape: missing"],
    );
    refuses_set(
        &["damping.x=1"],
        &["--set damping.x=1: damping: must be a table"],
    );
    refuses_set(&["method..dt=1"], &["--set method..dt=1", "dotted key"]);
    refuses_set(&["=1"], &["--set =1", "dotted key"]);
    refuses_set(
        &["damping=1\nduration=2"],
        &["damping", "must be a number", "not a string"],
    );
    let message = Override::parse("damping").unwrap_err().to_string();
    assert!(
        message.contains("--set damping: must be KEY=VALUE"),
        "{message}"
    );
}

#[test]
fn a_load_and_a_refined_part_have_a_place_and_a_range() {
    refuses_set(
        &["load.hem={ region = { kind = \"x-max\" }, force = [0.0, 0.0, 1e9] }"],
        &["load.hem.force", "N"],
    );
    refuses_set(
        &["load.hem={ region = { kind = \"point\", at = [9.0, 0.0] }, force = [0.0, 0.0, 1.0] }"],
        &["load.hem.region.at", "outside the sheet"],
    );
    refuses_set(
        &["sheet.refine={ region = { kind = \"point\", at = [9.0, 0.0] }, factor = 0.5 }"],
        &["sheet.refine.region.at", "outside the sheet"],
    );
    refuses_set(
        &["sheet.refine={ region = { kind = \"x-min\" }, factor = 0.0 }"],
        &["sheet.refine.factor = 0", "from 0.02 to 1"],
    );
    refuses_set(
        &["sheet.refine={ region = { kind = \"ring\", outer = 0.1, inner = 0.2 }, factor = 0.5 }"],
        &["sheet.refine.region.inner", "must not exceed outer = 0.1 m"],
    );
}
