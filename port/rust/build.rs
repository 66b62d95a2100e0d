//! Compiles the C library, with the flags that its figures are measured with.

use std::path::Path;

fn main() {
    let here = std::env::var("CARGO_MANIFEST_DIR").unwrap();
    assert!(Path::new(&here).join("src/sys.rs").exists(), "src/sys.rs is made from the C headers: python3 {here}/bindings.py writes it");
    let staged = Path::new(&here).join("core");
    let root = if staged.exists() { staged } else { Path::new(&here).join("../..") };
    println!("cargo::rerun-if-changed={}", root.join("src").display());
    println!("cargo::rerun-if-changed={}", root.join("include").display());
    let mut build = cc::Build::new();
    build.std("c11").include(root.join("include")).opt_level(2);
    for flag in ["-fno-math-errno", "-ffp-contract=off", "-fno-tree-loop-distribute-patterns"] {
        build.flag_if_supported(flag);
    }
    let sources = std::fs::read_dir(root.join("src")).expect("the C library's src/");
    let mut files: Vec<_> = sources.map(|one| one.unwrap().path()).collect();
    files.retain(|path| path.extension().is_some_and(|end| end == "c"));
    files.sort();
    build.files(files).compile("kalmanq");
    if std::env::var("CARGO_CFG_UNIX").is_ok() {
        println!("cargo::rustc-link-lib=m");
    }
}
