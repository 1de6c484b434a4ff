//! Hands what the environment says of a build to the sources.

fn main() {
    println!("cargo:rerun-if-changed=build.rs");
    // For those who build often: half of the kernels, in about half the time.
    println!("cargo:rerun-if-env-changed=OPENRT_FEW_LEVELS");
    if std::env::var_os("OPENRT_FEW_LEVELS").is_some() {
        println!("cargo:rustc-cfg=openrt_few_levels");
    }
}
