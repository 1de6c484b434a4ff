//! The shared library is what the header promises: the same names, a SONAME, and it stays loaded.

#[path = "common/c.rs"]
mod c;

use std::collections::BTreeSet;
use std::fs;
use std::process::Command;

/// Functions that `rt.h` declares.
fn declared() -> BTreeSet<String> {
    let header = fs::read_to_string("include/openrt/rt.h").expect("the header is checked in");
    let prototypes = header.lines().filter_map(|line| line.strip_prefix("RTAPI "));
    prototypes
        .map(|p| {
            let before = p.split('(').next().expect("split gives at least one part");
            before.rsplit([' ', '*']).next().expect("a prototype has a name").to_owned()
        })
        .collect()
}

/// Functions that `src/capi` exports, found without cbindgen.
fn written() -> BTreeSet<String> {
    let mut names = BTreeSet::new();
    for entry in fs::read_dir("src/capi").expect("src/capi is there") {
        let code = fs::read_to_string(entry.expect("a folder can be listed").path()).expect("sources are text");
        for export in code.split("#[unsafe(no_mangle)]").skip(1) {
            let name = export.split(" fn ").nth(1).and_then(|rest| rest.split('(').next());
            names.insert(name.expect("no_mangle stands before a function").to_owned());
        }
    }
    names
}

#[test]
fn header_declares_every_export() {
    let (declared, written) = (declared(), written());
    assert!(declared.len() > 150, "the reader of the header found only {declared:?}");
    assert_eq!(declared, written);
    for name in &declared {
        assert!(name.starts_with("rt"), "{name}");
        let next = name.trim_start_matches("rts").trim_start_matches("rt").chars().next();
        assert!(next.is_some_and(|c| c.is_ascii_uppercase()), "{name}: rt_ names are BRL-CAD's");
    }
}

#[test]
fn shared_library_exports_the_header_and_nothing_else() {
    if !c::have("nm") {
        return;
    }
    let symbols = c::run(Command::new("nm").args(["-D", "--defined-only"]).arg(c::library("libopenrt.so")));
    let exported: BTreeSet<String> = symbols
        .lines()
        .filter_map(|line| {
            let mut words = line.split_whitespace().skip(1);
            let kind = words.next()?;
            // Versions and the linker's own marks are not functions.
            matches!(kind, "T" | "t" | "W" | "D" | "B" | "R")
                .then(|| words.next().expect("a symbol has a name").to_owned())
        })
        .collect();
    assert_eq!(exported, declared());
}

#[test]
fn shared_library_has_a_soname_and_stays_loaded() {
    if !c::have("readelf") {
        return;
    }
    let dynamic = c::run(Command::new("readelf").args(["-d", "-W"]).arg(c::library("libopenrt.so")));
    let line = |what: &str| dynamic.lines().find(|l| l.contains(what)).unwrap_or_default();
    assert!(line("(SONAME)").ends_with("[libopenrt.so.0]"), "glibc owns librt.so.1, cargo sets none: {dynamic}");
    assert!(line("(FLAGS_1)").contains("NODELETE"), "pool threads must not outlive their code: {dynamic}");
    for needed in dynamic.lines().filter(|l| l.contains("(NEEDED)")) {
        let system = ["libc.so", "libm.so", "libgcc_s.so", "libpthread.so", "libdl.so", "librt.so.1", "ld-linux"];
        assert!(system.iter().any(|s| needed.contains(s)), "the core needs nothing but the system: {needed}");
    }
}

/// The line that programs need which link the static library; it stands in `openrt.pc` and `OpenRTConfig.cmake`, too.
#[test]
fn static_link_line_is_documented() {
    let line = c::NATIVE_STATIC_LIBS.join(" ");
    let pc = fs::read_to_string("include/package/openrt.pc.in").expect("openrt.pc.in is there");
    assert!(pc.contains(&format!("Libs.private: {line}")), "{line}");
    let cmake = fs::read_to_string("include/package/OpenRTConfig.cmake.in").expect("OpenRTConfig.cmake.in is there");
    let names: Vec<&str> = c::NATIVE_STATIC_LIBS.iter().map(|l| l.trim_start_matches("-l")).collect();
    assert!(cmake.contains(&format!("\"{}\"", names.join(";"))), "{names:?}");
}

/// The version stands in one place.
#[test]
fn version_is_that_of_cargo() {
    let header = fs::read_to_string("include/openrt/rt.h").expect("the header is checked in");
    for (name, value) in [
        ("MAJOR", env!("CARGO_PKG_VERSION_MAJOR")),
        ("MINOR", env!("CARGO_PKG_VERSION_MINOR")),
        ("PATCH", env!("CARGO_PKG_VERSION_PATCH")),
    ] {
        assert!(header.contains(&format!("#define OPENRT_VERSION_{name} {value}\n")), "{name} is not {value}");
    }
}
