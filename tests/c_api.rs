//! The C face as C programs see it: each file of `tests/c` is a program that checks itself.
//!
//! They are compiled as strict C99 and linked with the static library, which is what a debugger or a sanitizer sees most of; one is linked with
//! the shared one. That no function is forgotten in the tables of `errors.c` is checked against the header.

#[path = "common/c.rs"]
mod c;

use c::Link;
use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

/// Compiles `tests/c/NAME`, C or C++, and runs it with `arguments` in its scratch folder; returns what it said.
fn passes(name: &str, link: Link, prepare: impl FnOnce(&Path) -> Vec<PathBuf>) {
    let Some(dir) = c::scratch(&format!("c_{name}")) else { return };
    let arguments = prepare(&dir);
    let file = if name.contains('.') { format!("tests/c/{name}") } else { format!("tests/c/{name}.c") };
    let program = c::build(&[Path::new(&file)], &dir.join("program"), link);
    let said = c::run(Command::new(program).args(arguments).current_dir(&dir));
    for line in said.lines() {
        eprintln!("{name}: {line}");
    }
}

fn no_arguments(_: &Path) -> Vec<PathBuf> {
    Vec::new()
}

#[test]
fn every_call_obeys_the_error_rules() {
    passes("errors", Link::Static, |dir| vec![dir.join("image.png")]);
}

#[test]
fn texts_live_on_and_say_what_was_wrong() {
    passes("texts", Link::Static, no_arguments);
}

#[test]
fn contexts_and_threads() {
    passes("threads", Link::Static, no_arguments);
}

/// In a library with the readers or without.
#[test]
fn scene_files() {
    passes("scenes", Link::Static, |dir| {
        vec![dir.to_owned(), Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/every.aff")]
    });
}

#[test]
fn small_calls() {
    passes("small_calls", Link::Static, |dir| vec![dir.to_owned()]);
}

#[test]
fn cpp_classes() {
    let data = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/every.aff");
    passes("classes.cpp", Link::Static, |dir| vec![dir.to_owned(), data]);
    passes("face.cpp", Link::Static, no_arguments);
}

/// Nothing is written to the standard error: no panic was caught on the way.
#[test]
fn contexts_are_destroyed_at_exit() {
    let Some(dir) = c::scratch("c_atexit") else { return };
    for link in [Link::Static, Link::Shared] {
        let program = c::build(&[Path::new("tests/c/atexit.c")], &dir.join(format!("atexit_{link:?}")), link);
        let ended = c::outcome(Command::new(program).current_dir(&dir));
        assert_eq!(ended, (Some(0), "after exit\n".to_owned(), String::new()));
    }
}

#[test]
fn image_files_need_no_stack() {
    passes("small_stack", Link::Static, no_arguments);
}

#[test]
fn child_of_fork_renders() {
    passes("fork", Link::Static, no_arguments);
}

#[test]
fn cancelled_frames_end_soon() {
    passes("cancel", Link::Static, no_arguments);
}

#[test]
fn a_defect_does_not_end_the_program() {
    passes("panic", Link::Static, no_arguments);
}

#[test]
fn floating_point_environment_is_left_alone() {
    passes("fenv", Link::Static, no_arguments);
}

/// With the shared library, through which the shader library finds the rts functions.
#[test]
fn shaders_of_c_functions_and_shader_libraries() {
    passes("shaders", Link::Shared, |dir| {
        let mut cc = c::compiler(Path::new("plugin.c"));
        cc.args(["-std=c99", "-pedantic", "-Wall", "-Wextra", "-Werror", "-shared", "-fPIC", "-Iinclude", "-o"]);
        c::run(cc.arg(dir.join("plugin.so")).arg("tests/c/plugin.c"));
        vec![dir.to_owned()]
    });
}

/// The prototypes of the header: name and arguments.
fn prototypes() -> BTreeMap<String, String> {
    let header = fs::read_to_string("include/openrt/rt.h").expect("the header is checked in");
    let declared = header.split("\nRTAPI ").skip(1).map(|p| {
        let prototype = p.split(';').next().expect("split gives at least one part").replace('\n', " ");
        let (head, arguments) = prototype.split_once('(').expect("a prototype has arguments");
        let name = head.rsplit([' ', '*']).next().expect("a prototype has a name");
        (name.to_owned(), arguments.trim_end_matches(')').to_owned())
    });
    declared.collect()
}

/// Functions that need no current context, which `errors.c` calls by hand.
fn needs_no_context(name: &str) -> bool {
    let by_hand = [
        "rtInit",
        "rtExit",
        "rtCreateContext",
        "rtCreateContextThreads",
        "rtThreads",
        "rtDestroyContext",
        "rtMakeCurrent",
        "rtGetCurrentContext",
        "rtGetError",
        "rtGetErrorString",
        "rtCancelContext",
        "rtReleaseScene",
    ];
    by_hand.contains(&name) || name.starts_with("rts")
}

fn rows(file: &str, start: &str) -> Vec<Vec<String>> {
    let text = fs::read_to_string(file).expect("the table is there");
    let rows = text.lines().filter_map(|line| line.strip_prefix(start));
    rows.map(|row| row.split(',').take(2).map(|cell| cell.trim().to_owned()).collect()).collect()
}

#[test]
fn tables_leave_no_function_out() {
    let prototypes = prototypes();
    assert!(prototypes.len() > 150, "the reader of the header found only {prototypes:?}");
    let calls: BTreeSet<String> = rows("tests/c/calls.inc", "X(").into_iter().map(|row| row[0].clone()).collect();
    let program = fs::read_to_string("tests/c/errors.c").expect("the program is there");
    for name in prototypes.keys() {
        if needs_no_context(name) {
            assert!(program.contains(&format!("{name}(")), "errors.c does not call {name}");
        } else {
            assert!(calls.contains(name), "tests/c/calls.inc has no call of {name}");
        }
    }
    for name in &calls {
        assert!(prototypes.contains_key(name), "{name} is not in the header");
    }
}

/// Every function with such an argument has rows in which it is NULL, no accepted constant, out of range, or not a name.
#[test]
fn tables_have_wrong_calls_for_every_kind_of_argument() {
    let mut wrong = BTreeMap::<String, BTreeSet<String>>::new();
    for row in rows("tests/c/bad.inc", "B(") {
        wrong.entry(row[0].clone()).or_default().insert(row[1].clone());
    }
    // Where the wrong argument is right after all, or is found by another call.
    let exceptions = [
        ("rtErrorCallback", "NULLP"),
        ("rtFrameCallback", "NULLP"),
        ("rtNormalPointer", "NULLP"),
        ("rtColorPointer", "NULLP"),
        ("rtTexCoordPointer", "NULLP"),
        // NULL makes an image without content.
        ("rtTexImage2D", "NULLP"),
        // Any name may be asked for, and names that are not in use are passed over.
        ("rtIsObject", "NAME"),
        ("rtIsShader", "NAME"),
        ("rtIsTexture", "NAME"),
    ];
    let mut missing = Vec::new();
    for (name, arguments) in prototypes().iter().filter(|(name, _)| !needs_no_context(name)) {
        // Vertices and their attributes take any number.
        let attribute = ["rtVertex", "rtNormal3", "rtTexCoord", "rtColor", "rtParameter"];
        let attribute = attribute.iter().any(|a| name.starts_with(a)) && name.chars().any(|c| c.is_ascii_digit());
        for argument in arguments.split(',').map(str::trim) {
            let (ty, variable) = argument.rsplit_once([' ', '*']).unwrap_or((argument, ""));
            let kind = if argument.contains('*') {
                "NULLP"
            } else if ty == "RTenum" {
                "ENUM"
            } else if (ty == "RTsizei" || ty == "RTint") && !attribute {
                "RANGE"
            } else if ["object", "shader", "texture", "shaderClass", "handle"].contains(&variable) {
                "NAME"
            } else {
                continue;
            };
            // A parameter of another shader class is a name that means nothing here; those with v share the look-up.
            let has = wrong.get(name).is_some_and(|kinds| kinds.contains(kind));
            if !has && !exceptions.contains(&(name.as_str(), kind)) {
                missing.push(format!("{name}: {kind} for {argument}"));
            }
        }
    }
    assert!(missing.is_empty(), "tests/c/bad.inc has no rows for\n{}", missing.join("\n"));
}
