//! Gives the shared library its SONAME, which cargo does not, and keeps it loaded for the life of the
//! process (its pool threads must not outlive their code).

fn main() {
    println!("cargo:rerun-if-changed=build.rs");
    println!("cargo:rerun-if-env-changed=OPENRT_NO_SONAME");
    // For those who build often: half of the kernels, in about half the time.
    println!("cargo:rerun-if-env-changed=OPENRT_FEW_LEVELS");
    if std::env::var_os("OPENRT_FEW_LEVELS").is_some() {
        println!("cargo:rustc-cfg=openrt_few_levels");
    }
    let target_os = std::env::var("CARGO_CFG_TARGET_OS").unwrap_or_default();
    // cargo-c sets its own SONAME; packagers who use it set OPENRT_NO_SONAME=1.
    if target_os == "linux" && std::env::var_os("OPENRT_NO_SONAME").is_none() {
        println!("cargo:rustc-cdylib-link-arg=-Wl,-soname,libopenrt.so.0");
        println!("cargo:rustc-cdylib-link-arg=-Wl,-z,nodelete");
    }
}
