//! The C libraries of this build.

use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::LazyLock;

/// `libopenrt.so` or `libopenrt.a` of the profile and the features under which this test runs.
///
/// They are a package of their own (`include/library`), which cargo does not build for the tests of this one; so it is asked to. What a
/// test run has compiled is used again, and only linking is left to do.
pub fn library(file: &str) -> PathBuf {
    static FOLDER: LazyLock<PathBuf> = LazyLock::new(build_libraries);
    let path = FOLDER.join(file);
    assert!(path.exists(), "cargo has built no {}", path.display());
    path
}

fn build_libraries() -> PathBuf {
    let program = std::env::current_exe().expect("a test knows its own path");
    let deps = program.parent().expect("a program is in a folder");
    let folder = deps.parent().expect("deps is in the folder of a profile").to_owned();
    let name = |path: &Path| path.file_name().and_then(|n| n.to_str()).map(str::to_owned);
    let profile = name(&folder).map(|n| if n == "debug" { "dev".to_owned() } else { n }).expect("a profile has a name");
    let mut target_dir = folder.parent().expect("a profile is in the target folder");
    let mut cargo = Command::new(std::env::var_os("CARGO").unwrap_or_else(|| env!("CARGO").into()));
    cargo.current_dir(env!("CARGO_MANIFEST_DIR")).args(["build", "--quiet", "-p", "openrt", "-p", "openrt-c"]);
    cargo.args(["--lib", "--profile", &profile]);
    // target/x86_64-unknown-linux-gnu/debug: built for a target that was named.
    if let Some(triple) = name(target_dir).filter(|n| n.split('-').count() >= 3 && n.contains(std::env::consts::ARCH)) {
        cargo.args(["--target", &triple]);
        target_dir = target_dir.parent().expect("a target is in the target folder");
    }
    cargo.arg("--target-dir").arg(target_dir);
    if !cfg!(feature = "images") {
        cargo.arg("--no-default-features");
    }
    for (on, feature) in [(cfg!(feature = "load"), "load"), (cfg!(feature = "cli"), "cli")] {
        if on {
            cargo.args(["--features", feature]);
        }
    }
    let built = cargo.output().unwrap_or_else(|e| panic!("{cargo:?}: {e}"));
    assert!(built.status.success(), "{cargo:?}: {}\n{}", built.status, String::from_utf8_lossy(&built.stderr));
    folder
}
