//! The reader's test: the source tree keeps the layout that `src/lib.rs` draws.
//!
//! It reads the sources as text. A small lexer removes comments, strings and character literals, so that only
//! code counts; then paths (`crate::room`, chains of `super`), the word `unsafe` and file sizes are looked at.
//! The lexer and the path finder are themselves tested below on snippets that break each rule.

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

/// Rooms and the rooms each may use, in the order in which data flows. A room may always use itself.
const ROOMS: &[(&str, &[&str])] = &[
    ("capi", &["load", "api", "memory"]),
    // A user of the library like any other, so of the public API alone.
    ("load", &["api", "quiet"]),
    // Of `trace` the plain types Ray and Hit, which callers of the API see.
    ("api", &["backend", "trace", "scene", "frame", "memory"]),
    ("backend", &["render", "trace", "scene", "frame", "simd", "threads", "memory", "quiet"]),
    ("render", &["shade", "trace", "accel", "frame", "scene", "simd", "threads", "memory"]),
    ("shade", &["trace", "scene", "simd", "memory"]),
    ("trace", &["accel", "scene", "simd", "memory"]),
    ("accel", &["scene", "simd", "threads", "memory"]),
    ("frame", &["memory"]),
    ("scene", &["memory"]),
    ("simd", &[]),
    ("threads", &["memory"]),
    ("memory", &[]),
    ("quiet", &[]),
];

/// Rooms that may hold `unsafe`; the lint `undocumented_unsafe_blocks` asks each block for its reason.
const UNSAFE_ROOMS: &[&str] = &["capi", "simd", "trace", "threads", "memory"];

/// What the command-line program may name of the library: the safe API, not the engine.
const PUBLIC_TO_PROGRAMS: &[&str] = &["Context", "api", "load", "scene", "frame"];

const MAX_LINES: usize = 800;

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// Files below `dir` with one of the extensions, sorted, without build output.
fn files(dir: &str, extensions: &[&str]) -> Vec<PathBuf> {
    let mut found = Vec::new();
    let mut pending = vec![root().join(dir)];
    while let Some(dir) = pending.pop() {
        for entry in fs::read_dir(&dir).unwrap_or_else(|e| panic!("{}: {e}", dir.display())) {
            let path = entry.expect("a folder can be listed to its end").path();
            if path.is_dir() {
                let generated = ["out", "bin", "lib", "diffs"].iter().any(|g| path.ends_with(g));
                if !generated || path.starts_with(root().join("src")) {
                    pending.push(path);
                }
            } else if path.extension().is_some_and(|x| extensions.iter().any(|e| x == *e)) {
                found.push(path);
            }
        }
    }
    found.sort();
    assert!(!found.is_empty(), "no files in {dir}");
    found
}

fn read(path: &Path) -> String {
    fs::read_to_string(path).unwrap_or_else(|e| panic!("{}: {e}", path.display()))
}

fn shown(path: &Path) -> String {
    path.strip_prefix(root()).unwrap_or(path).display().to_string()
}

/// The room of a source file: `src/accel/bsp.rs` and `src/accel.rs` are in `accel`.
fn room_of(path: &Path) -> String {
    let inside = path.strip_prefix(root().join("src")).expect("a file below src");
    let first = inside.components().next().expect("a file has a name").as_os_str();
    first.to_str().expect("file names are UTF-8").trim_end_matches(".rs").to_owned()
}

/// Names of modules from the crate root down to the file: `src/a/mod.rs` is 1 deep, `src/a/b.rs` is 2.
fn module_depth(path: &Path) -> usize {
    let inside = path.strip_prefix(root().join("src")).expect("a file below src");
    let depth = inside.components().count();
    if inside.ends_with("mod.rs") || inside.ends_with("lib.rs") { depth - 1 } else { depth }
}

#[derive(Debug, Clone, PartialEq)]
enum Token {
    Word(String),
    /// `::`
    PathSep,
    Mark(char),
}

/// Words and marks of Rust source, without comments, strings, characters and lifetimes.
fn tokens(source: &str) -> Vec<Token> {
    let s: Vec<char> = source.chars().collect();
    let at = |i: usize| s.get(i).copied().unwrap_or('\0');
    let mut out = Vec::new();
    let mut i = 0;
    while i < s.len() {
        let c = s[i];
        if c == '/' && at(i + 1) == '/' {
            while i < s.len() && s[i] != '\n' {
                i += 1;
            }
        } else if c == '/' && at(i + 1) == '*' {
            let mut depth = 1;
            i += 2;
            while i < s.len() && depth > 0 {
                match (s[i], at(i + 1)) {
                    ('/', '*') => (depth, i) = (depth + 1, i + 2),
                    ('*', '/') => (depth, i) = (depth - 1, i + 2),
                    _ => i += 1,
                }
            }
        } else if c == '"' {
            i += 1;
            while i < s.len() && s[i] != '"' {
                i += if s[i] == '\\' { 2 } else { 1 };
            }
            i += 1;
        } else if c == '\'' {
            // 'x' and '\n' are characters; 'a without a closing quote is a lifetime.
            if at(i + 1) == '\\' {
                i += 3;
                while i < s.len() && s[i] != '\'' {
                    i += 1;
                }
                i += 1;
            } else if at(i + 2) == '\'' {
                i += 3;
            } else {
                i += 1;
            }
        } else if c.is_alphanumeric() || c == '_' {
            let start = i;
            while at(i).is_alphanumeric() || at(i) == '_' {
                i += 1;
            }
            let word: String = s[start..i].iter().collect();
            let hashes = s[i..].iter().take_while(|&&c| c == '#').count();
            if ["r", "br", "cr"].contains(&&*word) && at(i + hashes) == '"' {
                // A raw string ends at a quote followed by as many hashes.
                i += hashes + 1;
                while i < s.len() && !(s[i] == '"' && (1..=hashes).all(|k| at(i + k) == '#')) {
                    i += 1;
                }
                i += 1 + hashes;
            } else {
                out.push(Token::Word(word));
            }
        } else if c == ':' && at(i + 1) == ':' {
            out.push(Token::PathSep);
            i += 2;
        } else {
            if !c.is_whitespace() {
                out.push(Token::Mark(c));
            }
            i += 1;
        }
    }
    out
}

fn word(token: Option<&Token>) -> Option<&str> {
    match token {
        Some(Token::Word(w)) => Some(w),
        _ => None,
    }
}

/// First names after `base::` wherever it is written: one for `base::a::b`, several for `base::{a::b, c}`.
fn first_names(tokens: &[Token], base: &str) -> BTreeSet<String> {
    let mut names = BTreeSet::new();
    for i in 0..tokens.len() {
        // `crate` in `pub(crate)` has no separator after it, `x::crate_name` is another word.
        if word(tokens.get(i)) == Some(base) && tokens.get(i + 1) == Some(&Token::PathSep) {
            names.extend(names_after(&tokens[i + 2..]));
        }
    }
    names
}

/// The first name of a path, or the first names of a group in braces.
fn names_after(rest: &[Token]) -> Vec<String> {
    if let Some(name) = word(rest.first()) {
        return vec![name.to_owned()];
    }
    let (mut names, mut depth, mut expected) = (Vec::new(), 0, false);
    for token in rest {
        match token {
            Token::Mark('{') => {
                depth += 1;
                expected = depth == 1;
            }
            Token::Mark('}') => depth -= 1,
            Token::Mark(',') => expected = depth == 1,
            Token::Word(name) if expected => {
                names.push(name.clone());
                expected = false;
            }
            _ => {}
        }
        if depth == 0 {
            break;
        }
    }
    names
}

/// First names that chains of `super` reach at the crate root, from a file `depth` modules deep.
fn names_over_super(tokens: &[Token], depth: usize) -> BTreeSet<String> {
    let mut names = BTreeSet::new();
    // Whether each open brace belongs to an inline `mod name {`.
    let mut braces: Vec<bool> = Vec::new();
    let mut i = 0;
    while i < tokens.len() {
        match &tokens[i] {
            Token::Mark('{') => braces.push(i >= 2 && word(tokens.get(i - 2)) == Some("mod")),
            Token::Mark('}') => drop(braces.pop()),
            Token::Word(w) if w == "super" => {
                let mut supers = 0;
                while word(tokens.get(i)) == Some("super") && tokens.get(i + 1) == Some(&Token::PathSep) {
                    supers += 1;
                    i += 2;
                }
                let here = depth + braces.iter().filter(|&&is_module| is_module).count();
                if supers == here {
                    names.extend(names_after(&tokens[i..]));
                }
                // Back to the last token of the chain; `pub(super)` is a chain of none.
                i -= usize::from(supers > 0);
            }
            _ => {}
        }
        i += 1;
    }
    names
}

/// Rooms that a source of `room` uses although it may not.
fn forbidden_rooms(room: &str, tokens: &[Token], depth: usize) -> Vec<String> {
    let (_, allowed) = ROOMS.iter().find(|(name, _)| *name == room).unwrap_or_else(|| panic!("unknown room {room}"));
    let mut used = first_names(tokens, "crate");
    used.extend(names_over_super(tokens, depth));
    used.retain(|name| name != room && !allowed.contains(&&**name));
    used.into_iter().collect()
}

fn report(what: &str, faults: Vec<String>) {
    assert!(faults.is_empty(), "{what}:\n  {}", faults.join("\n  "));
}

#[test]
fn the_lexer_sees_only_code() {
    let source = r##"
        // use crate::api; /* not closed
        /* crate::api /* nested */ still a comment crate::api */
        let s = "crate::api \" unsafe"; let r = r#"unsafe " crate::api"#; let c = '"'; let q = '\'';
        fn f<'a>(x: &'a str) {}
    "##;
    let t = tokens(source);
    assert!(first_names(&t, "crate").is_empty(), "{t:?}");
    assert!(!t.contains(&Token::Word("unsafe".into())));
    assert!(t.contains(&Token::Word("f".into())), "code after literals is still seen: {t:?}");
}

#[test]
fn the_path_finder_sees_every_way_to_another_room() {
    let uses = |source: &str, depth| forbidden_rooms("scene", &tokens(source), depth);
    assert_eq!(uses("use crate::api::Context;", 2), ["api"]);
    assert_eq!(uses("use crate::{scene::Mesh, trace::{Ray, accel}, render};", 2), ["render", "trace"]);
    assert_eq!(uses("fn f() { crate::shade::g() }", 2), ["shade"]);
    assert_eq!(uses("use super::super::accel;", 2), ["accel"]);
    assert_eq!(uses("mod tests { use super::super::Mesh; }", 2), Vec::<String>::new());
    assert_eq!(uses("mod tests { use super::super::super::{accel}; }", 2), ["accel"]);
    assert_eq!(uses("fn f() { let a = super::Mesh; } use super::super::capi;", 2), ["capi"]);
    assert_eq!(uses("use super::accel;", 1), ["accel"]);
    assert_eq!(uses("pub(super) fn f() {} use super::accel;", 1), ["accel"]);
    assert_eq!(uses("pub(crate) struct S; use crate::scene::Mesh; use self::api::x;", 2), Vec::<String>::new());
}

#[test]
fn rooms_use_later_rooms_only() {
    let mut faults = Vec::new();
    for path in files("src", &["rs"]) {
        let room = room_of(&path);
        if room == "lib" || room == "bin" {
            continue;
        }
        for other in forbidden_rooms(&room, &tokens(&read(&path)), module_depth(&path)) {
            faults.push(format!("{} uses `{other}`", shown(&path)));
        }
    }
    report("a room uses one that it may not (table in tests/house.rs, map in src/lib.rs)", faults);
}

#[test]
fn the_program_uses_the_public_api_only() {
    let mut faults = Vec::new();
    for path in files("src/bin", &["rs"]) {
        for name in first_names(&tokens(&read(&path)), "openrt") {
            if !PUBLIC_TO_PROGRAMS.contains(&&*name) {
                faults.push(format!("{} uses `openrt::{name}`", shown(&path)));
            }
        }
    }
    report("the command-line program reaches into the engine", faults);
}

#[test]
fn unsafe_stays_in_its_rooms() {
    let mut faults = Vec::new();
    let mut seen = 0;
    for path in files("src", &["rs"]) {
        if tokens(&read(&path)).contains(&Token::Word("unsafe".into())) {
            seen += 1;
            if !UNSAFE_ROOMS.contains(&&*room_of(&path)) {
                faults.push(shown(&path));
            }
        }
    }
    assert!(seen > 0, "the C boundary cannot be without `unsafe`: the search is broken");
    report("`unsafe` outside capi, simd, trace, threads and memory", faults);
}

#[test]
fn the_other_rooms_forbid_unsafe() {
    let mut faults = Vec::new();
    for (room, _) in ROOMS.iter().filter(|(room, _)| !UNSAFE_ROOMS.contains(room)) {
        let head = root().join("src").join(room).join("mod.rs");
        if !read(&head).contains("\n#![forbid(unsafe_code)]\n") {
            faults.push(shown(&head));
        }
    }
    report("rooms without #![forbid(unsafe_code)]", faults);
}

/// `src/lib.rs` is the map: module declarations and re-exports, no items of its own.
#[test]
fn the_map_holds_no_code() {
    let source = read(&root().join("src/lib.rs"));
    let tokens = tokens(&source);
    for (i, token) in tokens.iter().enumerate() {
        if let Token::Word(w) = token {
            let code = ["fn", "struct", "enum", "trait", "impl", "const", "static", "type", "macro_rules", "let"];
            assert!(!code.contains(&&**w), "`{w}` in src/lib.rs (token {i})");
        }
    }
    for (room, _) in ROOMS {
        // A room that is behind a feature cannot be linked to.
        let shown = source.contains(&format!("[`{room}`]")) || source.contains(&format!("| `{room}` |"));
        assert!(shown, "the map in src/lib.rs does not show `{room}`");
    }
}

#[test]
fn every_folder_of_src_is_a_room() {
    let known: BTreeSet<String> =
        ROOMS.iter().map(|(room, _)| room.to_string()).chain(["lib", "bin"].map(String::from)).collect();
    let found: BTreeSet<String> = files("src", &["rs"]).iter().map(|path| room_of(path)).collect();
    assert_eq!(found, known, "rooms in src and rooms in the table differ");
}

#[test]
fn files_are_short_enough_to_read() {
    let mut faults = Vec::new();
    for dir in ["src", "tests", "c_examples"] {
        for path in files(dir, &["rs", "c", "cpp"]) {
            let lines = read(&path).lines().count();
            let limit = if dir == "c_examples" { 200 } else { MAX_LINES };
            if lines > limit {
                faults.push(format!("{}: {lines} lines, limit {limit}", shown(&path)));
            }
        }
    }
    report("files that have grown past what a reader takes in at once", faults);
}

#[test]
fn nothing_is_left_unfinished() {
    // Written in two halves, so that this file does not find itself.
    let marks = [["TO", "DO"], ["FIX", "ME"], ["XX", "X"], ["todo", "!"], ["unimplemented", "!"]].map(|w| w.concat());
    let mut faults = Vec::new();
    for dir in ["src", "include", "tests", "c_examples"] {
        for path in files(dir, &["rs", "c", "cpp", "h", "hpp"]) {
            for (n, line) in read(&path).lines().enumerate() {
                if marks.iter().any(|mark| line.contains(mark.as_str())) {
                    faults.push(format!("{}:{}: {}", shown(&path), n + 1, line.trim()));
                }
            }
        }
    }
    report("unfinished places", faults);
}

/// Words of `text` that start with `prefix` and go on with a capital letter, or with an underscore for `RT`.
fn words<'a>(text: &'a str, keep: impl Fn(&str) -> bool + 'a) -> impl Iterator<Item = &'a str> {
    text.split(|c: char| !c.is_ascii_alphanumeric() && c != '_').filter(move |w| keep(w))
}

/// `rtBegin`, `rtsTrace`: a function of the C API.
fn is_function(word: &str) -> bool {
    let rest = word.strip_prefix("rts").or_else(|| word.strip_prefix("rt")).unwrap_or("");
    rest.starts_with(|c: char| c.is_ascii_uppercase())
}

/// `RT_TRIANGLES`; not `RT_`, the family of constants.
fn is_constant(word: &str) -> bool {
    word.len() > 3 && word.starts_with("RT_")
}

#[test]
fn header_and_readme_mention_only_what_exists() {
    let header = read(&root().join("include/openrt/rt.h"));
    let declared: BTreeSet<&str> = header
        .lines()
        .filter(|line| !line.starts_with(" *") && !line.starts_with("/*"))
        .flat_map(|line| words(line, |w| is_function(w) || is_constant(w)))
        .collect();
    assert!(declared.contains("rtBegin") && declared.contains("RT_TRIANGLES"), "the header is read as it is written");
    let mut faults = Vec::new();
    for path in ["include/openrt/rt.h", "include/openrt/rt.hpp", "README.md"] {
        for word in words(&read(&root().join(path)), |w| is_function(w) || is_constant(w)) {
            // Families of functions are named without the letters of their types: rtVertex, rtColor.
            let family = declared.iter().any(|d| d.starts_with(word) && is_function(word));
            if !declared.contains(word) && !family {
                faults.push(format!("{path}: {word}"));
            }
        }
    }
    report("names that the C API does not have", faults);
}

#[test]
fn readme_and_sources_agree_on_environment_variables() {
    let readme = read(&root().join("README.md"));
    let of_readme: BTreeSet<&str> = words(&readme, |w| w.starts_with("OPENRT_")).collect();
    let mut of_sources = BTreeSet::new();
    for path in files("src", &["rs"]).into_iter().chain(files("tests", &["rs"])).chain([root().join("build.rs")]) {
        let source = read(&path);
        // A variable is read by its quoted name.
        of_sources.extend(
            source
                .split('"')
                .filter(|s| s.starts_with("OPENRT_") && words(s, |_| true).count() == 1)
                .map(str::to_owned),
        );
    }
    // What one test tells another, and macros of the header.
    let private = ["OPENRT_TEST_", "OPENRT_VERSION"];
    of_sources.retain(|name| name != "OPENRT_" && !private.iter().any(|p| name.starts_with(p)));
    for name in &of_readme {
        assert!(of_sources.contains(*name), "README names {name}, which nothing reads");
    }
    for name in &of_sources {
        assert!(of_readme.contains(name.as_str()), "README does not name {name}");
    }
}

#[test]
fn readme_points_to_files_that_exist() {
    let readme = read(&root().join("README.md"));
    let targets: Vec<&str> = readme.split("](").skip(1).filter_map(|rest| rest.split(')').next()).collect();
    assert!(!targets.is_empty());
    for target in targets.into_iter().filter(|t| !t.starts_with("http")) {
        assert!(root().join(target).exists(), "README points to {target}");
    }
}
