use std::{fs, path::Path};

/// The guide promises the four functions of `Part` in fewer than 50 lines; `cargo test` builds and runs the example.
#[test]
fn the_adapter_of_the_guide_has_fewer_than_50_lines() {
    let example = fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("../examples/own_sensor.rs")).unwrap();
    let lines = example.lines().skip_while(|line| !line.contains("Part<1> for")).take_while(|line| *line != "}");
    let adapter: Vec<&str> = lines.filter(|line| !line.trim().is_empty()).collect();
    assert!(adapter.iter().any(|line| line.contains("fn is_configured")), "the end of the adapter was not found");
    assert!(adapter.len() < 50, "{} lines", adapter.len());
}
