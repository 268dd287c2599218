//! The notebook, shown as a page of the guide: `MWD_BLESS=1 cargo test -p host-tests --test guide` writes the page.

use std::{env, fs};

use serde_json::Value;

use super::{guide, root};

const NOTEBOOK: &str = "bindings/python/notebooks/from_a_recording_to_plots.ipynb";

/// The notebook's cells as a page, with where it is and what runs it under its title.
fn shown() -> String {
    let notebook: Value = serde_json::from_str(&fs::read_to_string(root().join(NOTEBOOK)).unwrap()).unwrap();
    let cells = notebook["cells"].as_array().unwrap().iter().map(|cell| {
        let source: String = cell["source"].as_array().unwrap().iter().map(|line| line.as_str().unwrap()).collect();
        if cell["cell_type"] == "code" { format!("```python\n{source}\n```\n") } else { format!("{source}\n") }
    });
    let page = cells.collect::<Vec<String>>().join("\n");
    let (title, rest) = page.split_once("\n\n").unwrap();
    assert!(title.starts_with("# "), "{title}");
    let about = format!(
        "This page shows [the notebook]({NOTEBOOK}) with which to follow it: open it by `jupyter lab`. Its cells run as a test of the \
         Python package, from the first to the last, with their three figures."
    );
    format!("{title}\n\n{about}\n\n{rest}")
}

#[test]
fn the_page_of_the_notebook_has_its_cells() {
    let (path, expected) = (guide().join("notebook.md"), shown());
    assert!(expected.matches("```python").count() >= 6, "{expected}");
    if env::var_os("MWD_BLESS").is_some_and(|value| value == "1") {
        fs::write(&path, &expected).unwrap();
    }
    assert!(fs::read_to_string(&path).unwrap_or_default() == expected, "{}: MWD_BLESS=1 writes it", path.display());
}
