//! `include/openrt/rt.h` is what `src/capi` says.
//!
//! cbindgen writes a draft from the sources; here it gets what cbindgen cannot say: constants in hexadecimal, the table of built-in
//! shader classes, a heading for each group. The result is compared with the header that is checked in, so that neither packagers nor
//! ordinary builds need cbindgen. `OPENRT_BLESS=1 cargo test --test header` writes the header.

#[path = "common/c.rs"]
mod c;

use openrt::scene::{ParamDef, ParamScope, ParamType, ParamValue, ShaderKind};
use std::fmt::Write as _;
use std::fs;
use std::path::Path;

/// The files of `src/capi` that C sees, in the order of the manual.
const MANUAL: [&str; 21] = [
    "constants",
    "types",
    "context",
    "state",
    "frame_parameters",
    "objects",
    "immediate",
    "attributes",
    "colors",
    "arrays",
    "matrices",
    "view",
    "shaders",
    "shader_class",
    "parameters",
    "shading",
    "textures",
    "load",
    "frame",
    "queries",
    "scenes",
];

fn sources() -> Vec<String> {
    MANUAL.iter().map(|m| format!("src/capi/{m}.rs")).collect()
}

#[test]
fn manual_leaves_no_file_out() {
    for entry in fs::read_dir("src/capi").expect("src/capi is there") {
        let path = entry.expect("a folder can be listed").path();
        let code = fs::read_to_string(&path).expect("sources are text");
        let seen = code.contains("#[unsafe(no_mangle)]\n") || code.contains("#[repr(C)]\n");
        let name = path.file_stem().and_then(|n| n.to_str()).expect("a file of Rust");
        assert!(!seen || MANUAL.contains(&name), "{name} is not in the manual");
    }
}

fn draft() -> String {
    let config = cbindgen::Config::from_file("include/cbindgen.toml").expect("cbindgen.toml is valid");
    let builder = sources().iter().fold(cbindgen::Builder::new().with_config(config), |b, file| b.with_src(file));
    let mut out = Vec::new();
    builder.generate().expect("cbindgen reads src/capi").write(&mut out);
    String::from_utf8(out).expect("a header is text")
}

fn header() -> String {
    let mut text = draft();
    text = text.replace("@AFTER_INCLUDES@", &after_includes());
    for (from, to) in [("type_", "type"), ("capability_", "capability"), ("text_", "text")] {
        text = text.replace(&format!(" {from},"), &format!(" {to},"));
        text = text.replace(&format!(" {from};"), &format!(" {to};"));
        text = text.replace(&format!(" {from})"), &format!(" {to})"));
        text = text.replace(&format!("*{from})"), &format!("*{to})"));
    }
    text = hexadecimal(&text);
    text = one_line_comments(&text);
    for source in &sources() {
        text = with_heading(&text, source);
    }
    let classes = "/**\n * Returns a name for a shader class, and binds the class;";
    assert!(text.contains(classes), "the manual of rtGenNewShaderClass has moved");
    text = text.replacen(classes, &format!("{}\n{classes}", shader_table()), 1);
    text = wrapped(&text);
    let license = "/* openrt: an OpenGL-like API over a CPU ray tracing engine for scenes that move.\n *\n \
                   * Generated from src/capi by tests/header.rs; not to be edited.\n \
                   * SPDX-License-Identifier: MIT OR Apache-2.0 */\n";
    format!("{license}{}", text.trim_start())
}

fn after_includes() -> String {
    let mut out = String::new();
    for (name, value) in [
        ("MAJOR", env!("CARGO_PKG_VERSION_MAJOR")),
        ("MINOR", env!("CARGO_PKG_VERSION_MINOR")),
        ("PATCH", env!("CARGO_PKG_VERSION_PATCH")),
    ] {
        writeln!(out, "#define OPENRT_VERSION_{name} {value}").expect("writing to a string");
    }
    out + "\n/* Before every function. */\n\
           #ifndef RTAPI\n#if defined(_WIN32) && !defined(OPENRT_STATIC)\n#define RTAPI __declspec(dllimport)\n\
           #else\n#define RTAPI\n#endif\n#endif\n\n\
           /* Rules for all calls\n *\n \
           * A call that is in error changes nothing; rtGetError() returns the first error since it was last asked. No argument can\n \
           * crash the program, except a pointer to memory that is not there or is shorter than the manual says.\n *\n \
           * Coordinates are right-handed, matrices are stored column by column, angles are in degrees. The first row of a picture is\n \
           * the lowest. Colours are linear unless said otherwise.\n *\n \
           * A context is used by one thread at a time: the one on which it is current. Rendering is parallel inside the library. After\n \
           * fork() the child may go on using the context of the forking thread; a frame that was being rendered is the parent's, and\n \
           * rtEndRendering() in the child is RT_INVALID_OPERATION. The library does not change the floating-point environment of the\n \
           * caller, and flushing of denormals there does not change pictures. */"
}

/// cbindgen writes all constants in decimal.
fn hexadecimal(text: &str) -> String {
    let mut out = String::new();
    for line in text.lines() {
        let constant = line.strip_prefix("#define RT_").and_then(|rest| rest.split_once(' '));
        match constant.and_then(|(name, value)| Some((name, value.parse::<u32>().ok()?))) {
            Some((name, value)) if value > 1 => writeln!(out, "#define RT_{name} 0x{value:04X}"),
            _ => writeln!(out, "{line}"),
        }
        .expect("writing to a string");
    }
    out
}

/// A comment that fits a line takes one; constants and structure members then stand closer together.
fn one_line_comments(text: &str) -> String {
    let lines: Vec<&str> = text.lines().collect();
    let mut out = String::new();
    let mut i = 0;
    while i < lines.len() {
        let indent = &lines[i][..lines[i].len() - lines[i].trim_start().len()];
        let is_block = lines[i].trim() == "/**" && i + 2 < lines.len() && lines[i + 2].trim() == "*/";
        let single = is_block.then(|| lines[i + 1].trim().trim_start_matches('*').trim());
        match single {
            Some(comment) if indent.len() + comment.len() + 7 <= 120 => {
                writeln!(out, "{indent}/** {comment} */").expect("writing to a string");
                i += 3;
            }
            _ => {
                writeln!(out, "{}", lines[i]).expect("writing to a string");
                i += 1;
            }
        }
        // No empty line between constants.
        let constant = |line: &str| line.starts_with("#define RT_");
        if i > 0 && i + 1 < lines.len() && constant(lines[i - 1]) && lines[i].is_empty() && lines[i + 1] == "/**" {
            i += 1;
        }
    }
    out
}

/// cbindgen was told to put each prototype on one line; long ones are broken after a comma.
fn wrapped(text: &str) -> String {
    let mut out = String::new();
    for line in text.lines() {
        let is_code = line.starts_with("RTAPI ") || line.starts_with("typedef ");
        let mut rest = line;
        let mut width = 110;
        while is_code && rest.len() > width {
            let Some(comma) = rest[..width].rfind(", ") else { break };
            writeln!(out, "{}", &rest[..=comma]).expect("writing to a string");
            out += "    ";
            rest = &rest[comma + 2..];
            width = 106;
        }
        writeln!(out, "{rest}").expect("writing to a string");
    }
    out
}

/// Puts the first line of the module head before the comment of the first function of the module.
fn with_heading(text: &str, source: &str) -> String {
    let code = fs::read_to_string(source).expect("a source of src/capi");
    let Some(function) = code.split("#[unsafe(no_mangle)]").nth(1).and_then(|c| c.split(" fn rt").nth(1)) else {
        return text.to_owned();
    };
    let name = function.split('(').next().expect("an export has a name");
    let title = code.lines().next().and_then(|l| l.strip_prefix("//! ")).expect("a module has a head");
    let title = title.replace('`', "").trim_end_matches('.').to_owned();
    let prototype = |line: &&str| line.starts_with("RTAPI ") && line.contains(&format!("rt{name}("));
    let prototype = text.lines().find(prototype).unwrap_or_else(|| panic!("rt{name} is not in the draft"));
    let at = text.find(prototype).expect("a line of the text");
    let comment = text[..at].rfind("/**").expect("every function has a comment");
    let dashes = "-".repeat(110_usize.saturating_sub(title.len()));
    format!("{}/* {title} {dashes} */\n\n{}", &text[..comment], &text[comment..])
}

fn shader_table() -> String {
    let mut out = String::from(
        "/* The shader classes of the library, and their parameters: name, number of values, default.\n\
         \x20* t: captured per triangle. v: captured per vertex and interpolated. The others hold for a whole shader.\n",
    );
    for (kind, title) in [
        (ShaderKind::Surface, "Surfaces, for rtBindShader()"),
        (ShaderKind::Light, "Lights, for rtUseLight()"),
        (ShaderKind::Camera, "Cameras, for rtUseCamera()"),
        (ShaderKind::Environment, "Environments, for rtUseEnvironmentShader()"),
        (ShaderKind::Renderer, "Rendering objects, for rtUseRenderingObject()"),
    ] {
        writeln!(out, " *\n * {title}").expect("writing to a string");
        for class in openrt::shade::builtin_classes().iter().filter(|c| c.kind == kind) {
            let params: Vec<String> = class.params.iter().map(described).collect();
            let mut line = format!(" *   {:<18}", class.name);
            // A name as wide as its column has a line of its own.
            if class.name.len() >= 18 {
                writeln!(out, "{line}").expect("writing to a string");
                line = format!(" *   {:<18}", "");
            }
            for param in &params {
                if line.len() + param.len() > 118 {
                    writeln!(out, "{}", line.trim_end()).expect("writing to a string");
                    line = format!(" *   {:<18}", "");
                }
                line += &format!("{param}; ");
            }
            writeln!(out, "{}", line.trim_end().trim_end_matches(';')).expect("writing to a string");
        }
    }
    out + " */\n"
}

fn described(param: &ParamDef) -> String {
    let numbers = |values: &[f32]| values.iter().map(f32::to_string).collect::<Vec<_>>().join(" ");
    let (kind, default) = match (&param.ty, &param.default) {
        (ParamType::Int(n), ParamValue::Int(v)) => {
            (format!("{n}i"), v[..usize::from(*n)].iter().map(i32::to_string).collect::<Vec<_>>().join(" "))
        }
        (ParamType::Float(n), ParamValue::Float(v)) => (format!("{n}f"), numbers(&v[..usize::from(*n)])),
        (ParamType::Matrix, _) => ("16f".to_owned(), "identity".to_owned()),
        (ParamType::String, ParamValue::String(s)) => {
            let others = param.choices.iter().filter(|choice| **choice != &**s);
            let others = others.map(|choice| format!("\"{choice}\"")).collect::<Vec<_>>().join(", ");
            ("string".to_owned(), format!("\"{s}\" (or {others})"))
        }
        (ParamType::Texture, _) => ("texture".to_owned(), "none".to_owned()),
        (ty, value) => panic!("{}: a built-in parameter of type {ty:?} with default {value:?}", param.name),
    };
    let scope = match param.scope {
        ParamScope::Shader => "",
        ParamScope::Triangle => " t",
        ParamScope::Vertex => " v",
    };
    format!("{} {kind}{scope} {default}", param.name)
}

#[test]
fn header_is_what_the_sources_say() {
    let path = Path::new("include/openrt/rt.h");
    let wanted = header();
    if std::env::var_os("OPENRT_BLESS").is_some() {
        fs::write(path, &wanted).expect("the header can be written");
        return;
    }
    let found = fs::read_to_string(path).unwrap_or_default();
    let difference = found.lines().zip(wanted.lines()).enumerate().find(|(_, (f, w))| f != w);
    if found != wanted {
        panic!(
            "{} is out of date (first difference: {difference:?}); OPENRT_BLESS=1 cargo test --test header",
            path.display()
        );
    }
}

/// The manual is for readers of C.
#[test]
fn header_has_no_rust_in_it() {
    for (number, line) in header().lines().enumerate() {
        for rust in ["[`", "::", "&mut", "Option<", "Result<", "Some(", "_:", "type_", "Safety"] {
            assert!(!line.contains(rust), "line {}: {rust} in {line}", number + 1);
        }
    }
}

#[test]
fn header_compiles_as_c_and_as_cpp() {
    let Some(dir) = c::scratch("header") else { return };
    // As the sources say now, whether or not the checked-in file is up to date.
    fs::create_dir_all(dir.join("openrt")).expect("scratch");
    fs::write(dir.join("openrt/rt.h"), header()).expect("scratch");
    let program = "#include <openrt/rt.h>\nint main(void) { RThit hit = {0}; return (int)hit.object; }\n";
    for (file, standard) in [("c99.c", "-std=c99"), ("c17.c", "-std=c17"), ("cpp17.cpp", "-std=c++17")] {
        let source = dir.join(file);
        fs::write(&source, program.replace("{0}", if file.ends_with("cpp") { "{}" } else { "{0}" })).expect("scratch");
        let mut cc = c::compiler(&source);
        cc.args([standard, "-pedantic", "-Wall", "-Wextra", "-Werror", "-Wconversion", "-c", "-I"]).arg(&dir).arg("-o");
        c::run(cc.arg(dir.join("out.o")).arg(&source));
    }
}

/// Every constant has one meaning among those that share its first words, and none is beyond the range of `int`.
#[test]
fn constants_are_distinct_where_they_meet() {
    let mut seen = std::collections::BTreeMap::<i64, Vec<String>>::new();
    for line in header().lines() {
        if let Some((name, value)) = line.strip_prefix("#define RT_").and_then(|l| l.split_once(' ')) {
            let value = match value.strip_prefix("0x") {
                Some(hex) => i64::from_str_radix(hex, 16),
                None => value.parse(),
            };
            let value = value.unwrap_or_else(|e| panic!("{line}: {e}"));
            // The names of things may be any.
            assert!((0..1 << 31).contains(&value) || name == "IMMEDIATE_OBJECT", "{line}");
            seen.entry(value).or_default().push(name.to_owned());
        }
    }
    // Synonyms, and small numbers that are not enumerants.
    let allowed: [&[&str]; 6] = [
        &["COMPILE", "DEFINE"],
        &["COMPILE_AND_INSTANTIATE", "DEFINE_AND_INSTANTIATE"],
        &["FALSE", "NONE", "NO_ERROR"],
        &["TRUE", "SHADER_CLASS_VERSION", "COHERENT", "CAMERA_RAYS"],
        // Bits of masks.
        &["TRIANGLES", "REFLECTION_RAYS"],
        &["QUAD_STRIP", "QUERY_RAYS"],
    ];
    for (value, mut names) in seen {
        names.sort();
        let known = allowed.iter().any(|a| names.iter().all(|n| a.contains(&n.as_str())));
        assert!(names.len() == 1 || known, "{value:#x} is {names:?}");
    }
}
