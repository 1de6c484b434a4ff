//! What `make -C include install` leaves behind serves C and C++ programs, each way that the README names.
//!
//! The programs find the library by what the installed files say, and nothing else: no LD_LIBRARY_PATH, no folder of this tree.

#[path = "common/c.rs"]
mod c;

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::LazyLock;

/// The prefix into which everything is installed once; None where that cannot be done, which was said aloud.
static PREFIX: LazyLock<Option<PathBuf>> = LazyLock::new(|| {
    if !c::have("make") {
        return None;
    }
    let dir = c::scratch("packaging")?;
    let built = dir.join("built");
    fs::create_dir(&built).expect("scratch");
    for file in ["libopenrt.so", "libopenrt.a"] {
        std::os::unix::fs::symlink(c::library(file), built.join(file)).expect("a link can be made");
    }
    let prefix = dir.join("prefix");
    install(&built, &format!("PREFIX={}", prefix.display()), "install");
    Some(prefix)
});

fn install(built: &Path, prefix: &str, target: &str) {
    let build = format!("BUILD={}", built.display());
    c::run(Command::new("make").args(["-C", "include", target, prefix, &build]).env_remove("MAKEFLAGS"));
}

/// A program that uses the library, with its `main` around `body`.
fn program(name: &str, includes: &str, body: &str) -> PathBuf {
    let source = Path::new(env!("CARGO_TARGET_TMPDIR")).join("packaging").join(name);
    let text = format!(
        "#define _POSIX_C_SOURCE 200809L\n#include <openrt/rt.h>\n#include <stdio.h>\n{includes}\n\
         int main(int argc, char **argv)\n{{\n    RThit hit;\n    rtInit(&argc, argv);\n    rtViewport(0, 0, 16, 16);\n\
         \x20   rtBegin(RT_TRIANGLES);\n    rtVertex3f(-9, -9, -1);\n    rtVertex3f(9, -9, -1);\n    rtVertex3f(0, 9, -1);\n    rtEnd();\n\
         \x20   rtRender();\n    if (!rtPick(8, 8, &hit) || rtGetError() != RT_NO_ERROR)\n        return 1;\n{body}\n\
         \x20   printf(\"seen at %.1f\\n\", hit.t);\n    rtExit();\n    return 0;\n}}\n"
    );
    fs::write(&source, text).expect("scratch");
    source
}

fn pkg_config(prefix: &Path, arguments: &[&str]) -> Vec<String> {
    let mut command = Command::new("pkg-config");
    command.args(arguments).env("PKG_CONFIG_PATH", prefix.join("lib/pkgconfig"));
    c::run(&mut command).split_whitespace().map(str::to_owned).collect()
}

fn compile_and_run(source: &Path, flags: &[String]) -> PathBuf {
    let out = source.with_extension("program");
    let cpp = source.extension().is_some_and(|e| e == "cpp");
    let mut cc = c::compiler(source);
    cc.args([if cpp { "-std=c++17" } else { "-std=c99" }, "-Wall", "-Wextra", "-Werror", "-o"]);
    c::run(cc.arg(&out).arg(source).args(flags));
    let said = c::run(Command::new(&out).env_remove("LD_LIBRARY_PATH"));
    assert_eq!(said, "seen at 1.0\n");
    out
}

fn needed(program: &Path) -> String {
    c::run(Command::new("readelf").args(["-d", "-W"]).arg(program))
}

#[test]
fn lopenrt_by_pkg_config() {
    let Some(prefix) = &*PREFIX else { return };
    if !c::have("pkg-config") {
        return;
    }
    let flags = pkg_config(prefix, &["--cflags", "--libs", "openrt"]);
    let program = compile_and_run(&program("plain.c", "", ""), &flags);
    assert!(needed(&program).contains("[libopenrt.so.0]"));
    assert_eq!(pkg_config(prefix, &["--modversion", "openrt"]), [env!("CARGO_PKG_VERSION")]);
}

#[test]
fn lrt_by_pkg_config() {
    let Some(prefix) = &*PREFIX else { return };
    if !c::have("pkg-config") {
        return;
    }
    let flags = pkg_config(prefix, &["--cflags", "--libs", "openrt-librt"]);
    assert!(flags.contains(&"-lrt".to_owned()), "{flags:?}");
    let program = compile_and_run(&program("librt.c", "", ""), &flags);
    let needed = needed(&program);
    assert!(needed.contains("[libopenrt.so.0]") && !needed.contains("[librt.so]"), "{needed}");
}

/// Programs that ask for glibc's librt go on finding it, beside ours under either name.
#[test]
fn system_librt_beside_ours() {
    let Some(prefix) = &*PREFIX else { return };
    if !c::have("pkg-config") {
        return;
    }
    let includes = "#include <signal.h>\n#include <string.h>\n#include <sys/mman.h>\n#include <time.h>";
    let body = "    {\n        timer_t timer;\n        struct sigevent event;\n        memset(&event, 0, sizeof event);\n\
                \x20       event.sigev_notify = SIGEV_NONE;\n\
                \x20       if (timer_create(CLOCK_MONOTONIC, &event, &timer) != 0 || timer_delete(timer) != 0)\n            return 2;\n\
                \x20       shm_unlink(\"/openrt-test-that-is-not-there\");\n    }";
    // The system's -lrt first, in its own words; then ours.
    let mut flags = vec!["-lrt".to_owned()];
    flags.extend(pkg_config(prefix, &["--cflags", "--libs", "openrt"]));
    flags.push("-lrt".to_owned());
    compile_and_run(&program("both_plain.c", includes, body), &flags);
    let flags = pkg_config(prefix, &["--cflags", "--libs", "openrt-librt"]);
    let program = program("both_librt.c", includes, body);
    compile_and_run(&program, &flags);
    // A program that does not ask for us does not get us.
    let stranger = program.with_file_name("stranger.c");
    fs::write(&stranger, "int main(void) { return 0; }\n").expect("scratch");
    let out = stranger.with_extension("program");
    let mut cc = c::compiler(&stranger);
    c::run(cc.arg("-o").arg(&out).arg(&stranger).arg("-L").arg(prefix.join("lib")).arg("-lrt"));
    assert!(!needed(&out).contains("openrt"));
}

#[test]
fn static_library_by_pkg_config() {
    let Some(prefix) = &*PREFIX else { return };
    if !c::have("pkg-config") {
        return;
    }
    let flags = pkg_config(prefix, &["--cflags", "--static", "--libs", "openrt"]);
    let flags: Vec<String> = flags
        .into_iter()
        .map(|f| if f == "-lopenrt" { prefix.join("lib/libopenrt.a").display().to_string() } else { f })
        .collect();
    let program = compile_and_run(&program("static.c", "", ""), &flags);
    assert!(!needed(&program).contains("openrt"));
}

#[test]
fn cpp_with_rt_hpp() {
    let Some(prefix) = &*PREFIX else { return };
    let source = prefix.with_file_name("face.cpp");
    fs::copy("tests/c/face.cpp", &source).expect("scratch");
    let p = prefix.display();
    let flags = [format!("-I{p}/include"), format!("-L{p}/lib"), "-lopenrt".to_owned(), format!("-Wl,-rpath,{p}/lib")];
    compile_and_run(&source, &flags);
    let without = [&flags[..], &["-fno-exceptions".to_owned(), "-DOPENRT_NO_EXCEPTIONS".to_owned()]].concat();
    compile_and_run(&source, &without);
}

#[test]
fn find_package_in_cmake() {
    let Some(prefix) = &*PREFIX else { return };
    if !c::have("cmake") {
        return;
    }
    let dir = prefix.with_file_name("cmake");
    fs::create_dir_all(&dir).expect("scratch");
    fs::copy(program("by_cmake.c", "", ""), dir.join("main.c")).expect("scratch");
    let series = concat!(env!("CARGO_PKG_VERSION_MAJOR"), ".", env!("CARGO_PKG_VERSION_MINOR"));
    fs::write(
        dir.join("CMakeLists.txt"),
        format!(
            "cmake_minimum_required(VERSION 3.13)\nproject(user C)\nfind_package(OpenRT {series} REQUIRED)\n\
             add_executable(shared main.c)\ntarget_link_libraries(shared OpenRT::OpenRT)\n\
             add_executable(static main.c)\ntarget_link_libraries(static OpenRT::OpenRT_static)\n"
        ),
    )
    .expect("scratch");
    let path = format!("-DCMAKE_PREFIX_PATH={}", prefix.display());
    c::run(Command::new("cmake").current_dir(&dir).args(["-S", ".", "-B", "build", &path]));
    c::run(Command::new("cmake").current_dir(&dir).args(["--build", "build"]));
    for program in ["shared", "static"] {
        assert_eq!(c::run(&mut Command::new(dir.join("build").join(program))), "seen at 1.0\n");
    }
}

/// The CMake files are checked for what they name even where there is no cmake.
#[test]
fn installed_files_are_complete_and_go_away() {
    let Some(prefix) = &*PREFIX else { return };
    for (link, to) in [
        ("lib/libopenrt.so", "libopenrt.so.0"),
        ("lib/libopenrt.so.0", concat!("libopenrt.so.", env!("CARGO_PKG_VERSION"))),
        ("lib/openrt/librt.so", "../libopenrt.so"),
        ("lib/openrt/librt.a", "../libopenrt.a"),
    ] {
        assert_eq!(fs::read_link(prefix.join(link)).expect(link), Path::new(to), "{link}");
        assert!(prefix.join(link).exists(), "{link} leads nowhere");
    }
    for file in ["include/openrt/rt.h", "include/openrt/rt.hpp", "lib/libopenrt.a"] {
        assert!(prefix.join(file).is_file(), "{file}");
    }
    let files = ["pkgconfig/openrt.pc", "pkgconfig/openrt-librt.pc", "cmake/OpenRT/OpenRTConfig.cmake"];
    for file in files.iter().chain(&["cmake/OpenRT/OpenRTConfigVersion.cmake"]) {
        let text = fs::read_to_string(prefix.join("lib").join(file)).expect(file);
        assert!(!text.contains('@'), "{file}: {text}");
        for line in text.lines().filter(|l| l.contains("IMPORTED_LOCATION")) {
            let path = line.split('"').nth(1).expect("a path in quotes");
            let path = path.replace("${OpenRT_PREFIX}", &prefix.display().to_string());
            assert!(Path::new(&path).is_file(), "{file}: {path}");
        }
    }

    // A staged install writes below DESTDIR only, and an uninstall leaves nothing.
    let stage = prefix.with_file_name("stage");
    let built = prefix.with_file_name("built");
    let destination = format!("DESTDIR={}", stage.display());
    let prefix_argument = "PREFIX=/opt/openrt-that-is-not-there";
    for (target, left) in [("install", true), ("uninstall", false)] {
        let build = format!("BUILD={}", built.display());
        c::run(Command::new("make").args(["-C", "include", target, prefix_argument, &destination, &build]));
        assert_eq!(count_files(&stage) > 0, left, "after {target}");
        assert!(!Path::new("/opt/openrt-that-is-not-there").exists());
        let pc = stage.join("opt/openrt-that-is-not-there/lib/pkgconfig/openrt.pc");
        if left {
            let pc = fs::read_to_string(pc).expect("staged");
            assert!(!pc.contains(&stage.display().to_string()), "{pc}");
        }
    }
}

/// Packages of the system lie where the loader looks, and their files are found through links such as /lib → /usr/lib.
#[test]
fn system_packages_have_absolute_paths_and_no_rpath() {
    let Some(prefix) = &*PREFIX else { return };
    let (stage, built) = (prefix.with_file_name("system"), prefix.with_file_name("built"));
    let lib = "usr/lib/x86_64-linux-gnu";
    let arguments = [
        "PREFIX=/usr".to_owned(),
        format!("LIBDIR=/{lib}"),
        format!("DESTDIR={}", stage.display()),
        format!("BUILD={}", built.display()),
    ];
    c::run(Command::new("make").args(["-C", "include", "install"]).args(arguments).env_remove("MAKEFLAGS"));
    let pc = fs::read_to_string(stage.join(lib).join("pkgconfig/openrt.pc")).expect("staged");
    assert!(pc.contains("prefix=/usr\n") && pc.contains("libdir=${prefix}/lib/x86_64-linux-gnu\n"), "{pc}");
    assert!(!pc.contains("rpath"), "{pc}");
    let cmake = fs::read_to_string(stage.join(lib).join("cmake/OpenRT/OpenRTConfig.cmake")).expect("staged");
    assert!(cmake.contains("get_filename_component(OpenRT_PREFIX \"/usr\" ABSOLUTE)"), "{cmake}");
}

/// A relative prefix counts from where the command is typed, whatever folder make goes to; and an installed tree can be moved.
#[test]
fn relative_prefix_and_moved_tree() {
    let Some(prefix) = &*PREFIX else { return };
    let dir = prefix.with_file_name("typed");
    let built = prefix.with_file_name("built");
    fs::create_dir_all(&dir).expect("scratch");
    for (from, lib, to) in [("include", "lib", "moved"), ("c_examples", "lib/deep/er", "moved_deep")] {
        // A library that is built is installed without cargo, as root may lack it.
        let target = dir.join("target");
        let _ = fs::remove_file(target.join("release"));
        fs::create_dir_all(&target).expect("scratch");
        std::os::unix::fs::symlink(&built, target.join("release")).expect("a link can be made");
        let line = format!(
            "cd {} && make -C {}/{from} install PREFIX=here LIBDIR=here/{lib} BUILD={} CARGO=cargo-that-is-not-there CARGO_TARGET_DIR={}",
            dir.display(),
            env!("CARGO_MANIFEST_DIR"),
            built.display(),
            target.display()
        );
        let said = c::run(Command::new("sh").args(["-c", &line]).env_remove("MAKEFLAGS"));
        assert!(said.contains(&format!("is in {}/here/{lib}", dir.display())), "{said}");
        let moved = prefix.with_file_name(to);
        let _ = fs::remove_dir_all(&moved);
        fs::rename(dir.join("here"), &moved).expect("a tree can be moved");
        if c::have("pkg-config") {
            let path = moved.join(lib).join("pkgconfig");
            for package in ["openrt", "openrt-librt"] {
                let mut command = Command::new("pkg-config");
                command.args(["--cflags", "--libs", package]).env("PKG_CONFIG_PATH", &path);
                let flags: Vec<String> = c::run(&mut command).split_whitespace().map(str::to_owned).collect();
                compile_and_run(&program(&format!("{to}_{package}.c"), "", ""), &flags);
            }
        }
        for file in ["pkgconfig/openrt.pc", "pkgconfig/openrt-librt.pc", "cmake/OpenRT/OpenRTConfig.cmake"] {
            let text = fs::read_to_string(moved.join(lib).join(file)).expect(file);
            assert!(!text.contains(&dir.display().to_string()), "{file}: {text}");
        }
    }
}

#[test]
fn nothing_is_installed_before_it_is_built() {
    let Some(prefix) = &*PREFIX else { return };
    let nowhere = prefix.with_file_name("not_built");
    for from in ["include", "c_examples"] {
        let mut make = Command::new("make");
        make.args(["-C", from, "install", "CARGO=cargo-that-is-not-there"]).env_remove("MAKEFLAGS");
        make.arg(format!("PREFIX={}", nowhere.display())).arg(format!("CARGO_TARGET_DIR={}", nowhere.display()));
        let (status, _, err) = c::outcome(&mut make);
        assert!(status != Some(0) && err.contains("first"), "{from}: {err}");
        assert_eq!(count_files(&nowhere), 0);
    }
}

/// The Makefile of the examples, in a copy of its folder, with each compiler that is there.
#[test]
fn examples_link_with_every_compiler() {
    let Some(prefix) = &*PREFIX else { return };
    let tree = prefix.with_file_name("tree");
    let release = tree.join("target/release");
    fs::create_dir_all(tree.join("c_examples")).expect("scratch");
    fs::create_dir_all(release.parent().expect("target")).expect("scratch");
    let link = |from: &Path, to: &Path| {
        let _ = fs::remove_file(to);
        std::os::unix::fs::symlink(from, to).expect("a link can be made");
    };
    link(&prefix.with_file_name("built"), &release);
    link(&Path::new(env!("CARGO_MANIFEST_DIR")).join("include"), &tree.join("include"));
    for entry in fs::read_dir("c_examples").expect("c_examples is there") {
        let path = entry.expect("a folder can be listed").path();
        if path.is_file() {
            fs::copy(&path, tree.join(&path)).expect("scratch");
        }
    }
    let zig = if c::have("zig") { "zig" } else { "python3 -m ziglang" };
    for (probe, cc, cxx) in [
        ("clang --version", "clang", "clang++"),
        // Its first C++ program would have it build a library for minutes.
        (&*format!("{zig} version"), &*format!("{zig} cc"), "no-c++"),
    ] {
        if c::outcome(Command::new("sh").args(["-c", probe])).0 != Some(0) {
            c::skipped(format_args!("examples by {cc}, which is not there"));
            continue;
        }
        let mut make = Command::new("make");
        make.current_dir(tree.join("c_examples")).args(["-B", "CARGO=true", "CARGO_TARGET_DIR=../target"]);
        make.arg(format!("CC={cc}")).arg(format!("CXX={cxx}")).env_remove("MAKEFLAGS");
        c::run(&mut make);
        let picture = tree.join("triangle.png");
        let _ = fs::remove_file(&picture);
        c::run(Command::new(tree.join("c_examples/build/triangle")).args(["--size", "32x24", "--out"]).arg(&tree));
        assert!(picture.is_file(), "{cc}");
    }
}

/// Rust programs that depend on the crate link neither of the C libraries, and without its features it needs three crates.
#[test]
fn rust_programs_link_no_c_library() {
    let cargo = || Command::new(env!("CARGO"));
    let metadata = c::run(cargo().args(["metadata", "--no-deps", "--format-version", "1", "--offline"]));
    let lib = metadata.split("{\"kind\":[").filter(|t| t.contains("/src/lib.rs"));
    let kinds: Vec<&str> = lib.map(|t| t.split(']').next().expect("a list ends")).collect();
    assert_eq!(kinds, ["\"lib\""], "crate types of openrt");
    let tree = ["tree", "-p", "openrt", "--no-default-features", "-e", "normal", "--depth", "1", "--prefix", "none"];
    let tree = c::run(cargo().args(tree).arg("--offline"));
    let needed: Vec<&str> = tree.lines().skip(1).filter_map(|line| line.split(' ').next()).collect();
    assert_eq!(needed, ["glam", "libc", "rayon"]);
}

fn count_files(dir: &Path) -> usize {
    let Ok(entries) = fs::read_dir(dir) else { return 0 };
    entries
        .map(|e| e.expect("a folder can be listed").path())
        .map(|p| if p.is_dir() && !p.is_symlink() { count_files(&p) } else { 1 })
        .sum()
}
