use std::{fs, path::Path};

/// The guide promises an adapter in fewer than 50 lines; it is compiled and run with the library's
/// documentation.
#[test]
fn the_adapter_of_the_guide_has_fewer_than_50_lines() {
    let guide = fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("../docs/sensors.md")).unwrap();
    let code = guide.split("```rust").nth(1).and_then(|rest| rest.split("```").next()).unwrap();
    let adapter: Vec<&str> =
        code.lines().take_while(|line| !line.starts_with("# ")).filter(|line| !line.trim().is_empty()).collect();
    assert!(adapter.iter().any(|line| line.contains("fn is_configured")), "the end of the adapter was not found");
    assert!(adapter.len() < 50, "{} lines", adapter.len());
}
