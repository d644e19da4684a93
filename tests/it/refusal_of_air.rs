//! What the air of a scene, and the commands that it accepts, are refused for.

use crate::refusal::refuses;

#[test]
fn air_is_within_its_ranges() {
    let air = |value: &str, parts: &[&str]| {
        let text = format!("[air]\nfluid_damping = 0.1\n{value}\n[method]");
        refuses("[method]", &text, parts);
    };
    air(
        "velocity = [0, 0, 300]",
        &["line 23: air.velocity =", "from -200 to 200 m/s"],
    );
    air(
        "rise = -1",
        &["line 23: air.rise = -1", "from 0 to 100000 s"],
    );
    air(
        "speed = 1",
        &["air.speed = 1: unknown key", "fluid_damping, velocity"],
    );
    air(
        "region = { min = [0, 0, 0], max = [1, 1, 0] }",
        &[
            "line 23: air.region.min = [0, 0, 0]",
            "less than max in x, y and z",
        ],
    );
    refuses(
        "[method]",
        "[air]\nrise = 1\n[method]",
        &["air.fluid_damping: missing"],
    );
}

#[test]
fn a_scene_accepts_known_kinds_of_commands_once() {
    let accept = |value: &str, parts: &[&str]| {
        let line = format!("damping = 0.1\naccept = {value}");
        refuses("damping = 0.1", &line, parts);
    };
    let known = "some of obstacles, air, each at most once";
    accept(
        "[\"obstacle\"]",
        &[
            "line 5: accept = \"obstacle\"",
            known,
            "did you mean `obstacles`?",
        ],
    );
    accept(
        "[\"air\", \"air\"]",
        &["line 5: accept = [\"air\", \"air\"]", known],
    );
    accept(
        "\"air\"",
        &["line 5: accept = \"air\"", known, "not a string"],
    );
    accept("[1]", &["line 5: accept = 1", known]);
}
