//! On a chip: the tests' board, its start-up and newlib.

fn main() {
    if std::env::var("CARGO_CFG_TARGET_OS").unwrap() != "none" {
        return;
    }
    let boards = format!("{}/../../../port/boards", std::env::var("CARGO_MANIFEST_DIR").unwrap());
    let objects = cc::Build::new().file(format!("{boards}/cortex_m.c")).compile_intermediates();
    println!("cargo::rustc-link-arg={}", objects[0].display());
    for argument in [&format!("-L{boards}"), &format!("-T{boards}/mps2.ld"), "-nostartfiles", "-mthumb", "-march=armv7e-m+fp", "-mfloat-abi=hard"] {
        println!("cargo::rustc-link-arg={argument}");
    }
    for argument in ["-Wl,--gc-sections", "-Wl,--start-group", "-lc", "-lrdimon", "-lm", "-lgcc", "-Wl,--end-group"] {
        println!("cargo::rustc-link-arg={argument}");
    }
}
