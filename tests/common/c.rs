//! Compiling and running C programs against the library that cargo has just built.
#![allow(dead_code, reason = "each test program uses a part of it")]

#[path = "library.rs"]
mod library;
#[path = "skip.rs"]
mod skip;

pub use library::library;
pub use skip::skipped;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

/// What a static link with libopenrt.a needs of the system, as `cargo rustc -p openrt-c -- --print native-static-libs` says.
pub const NATIVE_STATIC_LIBS: [&str; 7] = ["-lgcc_s", "-lutil", "-lrt", "-lpthread", "-lm", "-ldl", "-lc"];

/// Longest time that a program may take; one that hangs is a failed test, not a test run without end.
const DEADLINE: Duration = Duration::from_secs(180);

/// Whether `program` can be run here; says so aloud if not.
pub fn have(program: &str) -> bool {
    let found = Command::new(program).arg("--version").stdout(Stdio::null()).stderr(Stdio::null()).status();
    if found.is_err() {
        skipped(format_args!("{program} is not there"));
    }
    found.is_ok()
}

fn tool(variable: &str, otherwise: &str) -> String {
    std::env::var(variable).ok().filter(|v| !v.is_empty()).unwrap_or_else(|| otherwise.to_owned())
}

/// A fresh folder for the outputs of test `name`; None, aloud, where there is no C or C++ compiler.
pub fn scratch(name: &str) -> Option<PathBuf> {
    if !have(&tool("CC", "cc")) || !have(&tool("CXX", "c++")) {
        return None;
    }
    let dir = Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
    if dir.exists() {
        fs::remove_dir_all(&dir).expect("the scratch folder of the run before can be removed");
    }
    fs::create_dir_all(&dir).expect("a scratch folder can be made");
    Some(dir)
}

/// The compiler for `source`: C++ for `.cpp`, else C.
pub fn compiler(source: &Path) -> Command {
    let cpp = source.extension().is_some_and(|e| e == "cpp");
    Command::new(if cpp { tool("CXX", "c++") } else { tool("CC", "cc") })
}

/// How a program is linked with the library.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Link {
    Static,
    Shared,
}

/// Compiles `sources` strictly and links them with the library of this build.
pub fn build(sources: &[&Path], out: &Path, link: Link) -> PathBuf {
    let mut cc = compiler(sources[0]);
    let cpp = sources[0].extension().is_some_and(|e| e == "cpp");
    cc.arg(if cpp { "-std=c++17" } else { "-std=c99" });
    cc.args(["-D_POSIX_C_SOURCE=200809L", "-pedantic", "-Wall", "-Wextra", "-Werror", "-O1", "-g", "-Iinclude", "-o"]);
    cc.arg(out).args(sources);
    match link {
        Link::Static => {
            cc.arg(library("libopenrt.a")).args(NATIVE_STATIC_LIBS);
        }
        Link::Shared => {
            // The program asks for the SONAME, which cargo does not make.
            let lib = out.with_extension("lib");
            fs::create_dir_all(&lib).expect("scratch");
            for name in ["libopenrt.so", "libopenrt.so.0"] {
                let _ = fs::remove_file(lib.join(name));
                std::os::unix::fs::symlink(library("libopenrt.so"), lib.join(name)).expect("a link can be made");
            }
            cc.arg("-L").arg(&lib).args(["-lopenrt", "-lm", "-lpthread"]);
            cc.arg(format!("-Wl,-rpath,{}", lib.display()));
        }
    }
    run(&mut cc);
    out.to_owned()
}

/// Runs a command, which must succeed, and returns what it wrote to its standard output.
pub fn run(command: &mut Command) -> String {
    let (status, out, err) = outcome(command);
    assert!(status == Some(0), "{command:?} ended with {status:?}\n--- stdout\n{out}\n--- stderr\n{err}");
    out.lines().filter_map(|line| line.strip_prefix("SKIPPED: ")).for_each(skipped);
    out
}

/// Exit status (None after a signal or the deadline), standard output and standard error.
pub fn outcome(command: &mut Command) -> (Option<i32>, String, String) {
    let child = command.stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn();
    let mut child = child.unwrap_or_else(|e| panic!("{command:?}: {e}"));
    let (out, err) = (child.stdout.take().expect("piped"), child.stderr.take().expect("piped"));
    let (out, err) = (std::thread::spawn(|| text(out)), std::thread::spawn(|| text(err)));
    let status = wait(&mut child);
    (status, out.join().expect("no panic in it"), err.join().expect("no panic in it"))
}

fn text(mut from: impl std::io::Read) -> String {
    let mut bytes = Vec::new();
    from.read_to_end(&mut bytes).expect("a pipe can be read");
    String::from_utf8_lossy(&bytes).into_owned()
}

fn wait(child: &mut Child) -> Option<i32> {
    let end = Instant::now() + DEADLINE;
    loop {
        match child.try_wait().expect("a child can be waited for") {
            Some(status) => return status.code(),
            None if Instant::now() > end => {
                child.kill().expect("a child can be killed");
                child.wait().expect("a killed child ends");
                eprintln!("killed after {DEADLINE:?}");
                return None;
            }
            None => std::thread::sleep(Duration::from_millis(10)),
        }
    }
}
