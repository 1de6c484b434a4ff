//! Compiles the programs of `c_examples` against the shared library that this test run built.

#[path = "library.rs"]
mod library;

use library::library;
use std::ffi::OsStr;
use std::path::{Path, PathBuf};
use std::process::Command;

/// Runs a command; its output becomes the error when it fails.
pub fn run(command: &mut Command) -> Result<(), String> {
    let output = command.output().map_err(|e| format!("{command:?}: {e}"))?;
    if output.status.success() {
        return Ok(());
    }
    let text = [output.stdout, output.stderr].concat();
    Err(format!("{command:?}: {}\n{}", output.status, String::from_utf8_lossy(&text)))
}

fn works(compiler: &OsStr) -> bool {
    Command::new(compiler).arg("--version").output().is_ok_and(|o| o.status.success())
}

pub struct Builder {
    cc: PathBuf,
    cxx: PathBuf,
    folder: PathBuf,
}

impl Builder {
    /// A builder that leaves programs in `folder`, with a private link folder as the Makefile makes it.
    /// The error says what is missing.
    pub fn new(folder: PathBuf) -> Result<Self, String> {
        let from_env = |name: &str, default: &str| PathBuf::from(std::env::var_os(name).unwrap_or(default.into()));
        let (cc, cxx) = (from_env("CC", "cc"), from_env("CXX", "c++"));
        if !cfg!(target_os = "linux") {
            return Err("the examples are linked as on Linux".into());
        }
        if !works(cc.as_os_str()) {
            return Err(format!("no C compiler ({})", cc.display()));
        }
        let library = library("libopenrt.so");
        let links = folder.join("lib");
        std::fs::create_dir_all(&links).map_err(|e| e.to_string())?;
        for name in ["librt.so", "libopenrt.so.0"] {
            let link = links.join(name);
            // The link is absent on the first run.
            let _ = std::fs::remove_file(&link);
            std::os::unix::fs::symlink(&library, &link).map_err(|e| format!("{}: {e}", link.display()))?;
        }
        Ok(Self { cc, cxx, folder })
    }

    pub fn has_cxx(&self) -> bool {
        works(self.cxx.as_os_str())
    }

    /// Compiles `c_examples/NAME.c` (or `.cpp`), and `NAME_shader.c` into a plug-in beside it if there is one.
    pub fn build(&self, name: &str) -> Result<PathBuf, String> {
        let root = Path::new(env!("CARGO_MANIFEST_DIR"));
        let sources = root.join("c_examples");
        let compiler = |source: &Path| {
            let cxx = source.extension().is_some_and(|x| x == "cpp");
            let mut command = Command::new(if cxx { &self.cxx } else { &self.cc });
            command.arg(if cxx { "-std=c++17" } else { "-std=c99" });
            command.args(["-O2", "-Wall", "-Wextra", "-Werror", "-pedantic", "-I"]).arg(root.join("include"));
            command.arg(source);
            command
        };
        let plugin = sources.join(format!("{name}_shader.c"));
        if plugin.exists() {
            let so = self.folder.join(format!("{name}_shader.so"));
            run(compiler(&plugin).args(["-shared", "-fPIC", "-lm", "-o"]).arg(so))?;
        }
        let c = sources.join(format!("{name}.c"));
        let source = if c.exists() { c } else { sources.join(format!("{name}.cpp")) };
        let program = self.folder.join(name);
        let mut command = compiler(&source);
        command.arg("-o").arg(&program).arg("-L").arg(self.folder.join("lib"));
        run(command.args(["-lrt", "-lm", "-Wl,-rpath,$ORIGIN/lib"]))?;
        Ok(program)
    }
}
