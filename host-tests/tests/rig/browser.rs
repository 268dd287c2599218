//! Pages in a browser, and what they tell of themselves. Chromium draws them; without one a test prints SKIPPED, and
//! with `MWD_REQUIRE_BROWSER=1` it fails.

use std::{
    env, fs,
    path::{Path, PathBuf},
    process::Command,
};

use serde_json::Value;
use tempfile::TempDir;

/// Runs in the page before everything else.
const LISTEN: &str =
    "<script>window.wrong = []; window.onerror = text => { window.wrong.push(String(text)); };</script>";

/// Runs when the page is there. It awaits no timer, so it is done before the browser writes the page out.
const CHECK: &str = "<script>(async () => {
  const told = { wrong: window.wrong, dark: matchMedia('(prefers-color-scheme: dark)').matches, width: innerWidth };
  try {
    if (window.report) report.buildAll();
    await 0; await 0;
    told.page = document.documentElement.scrollWidth;
    const inside = node => node.closest('.scroll, pre, .uplot');
    told.wide = [...document.querySelectorAll('main *')].filter(node => !inside(node) && node.getBoundingClientRect().right > innerWidth + 1)
      .map(node => node.tagName + ' ' + node.className);
    told.blank = [...document.querySelectorAll('.uplot canvas')].filter(canvas => {
      const pixels = canvas.getContext('2d').getImageData(0, 0, canvas.width, canvas.height).data;
      const seen = new Set();
      for (let k = 0; k < pixels.length; k += 4) if (pixels[k + 3] > 200) seen.add(pixels[k] << 16 | pixels[k + 1] << 8 | pixels[k + 2]);
      return seen.size < 3;
    }).length;
    told.plots = document.querySelectorAll('.uplot').length;
    told.small = [...document.querySelectorAll('main *')].filter(node => node.childNodes.length && parseFloat(getComputedStyle(node).fontSize) < 12).length;
    if (window.report) {
    const first = report.plots[0];
    first.isSeen = true;
    const press = key => first.place.dispatchEvent(new KeyboardEvent('keydown', { key, bubbles: true }));
    const span = () => document.querySelector('.bar .span').textContent;
    const before = span();
    press('+');
    told.zooms = span() !== before;
    press('Home');
    told.returns = span() === before;
    first.u.setScale('x', { min: first.u.data[0][0], max: first.u.data[0][first.u.data[0].length - 1] });
    await 0; await 0;
    press('ArrowRight');
    told.reads = first.figure.querySelector('.legend output').textContent;
    report.plots.slice(0, 3).forEach(plot => { plot.isSeen = true; });
    const [from, to] = [first.u.data[0][0], first.u.data[0][first.u.data[0].length - 1]];
    const began = performance.now(), moves = 20;
    for (let k = 0; k < moves; k++) { report.show(from + k, from + k + 0.9 * (to - from)); await 0; await 0; }
    told.move_ms = (performance.now() - began) / moves;
    }
  } catch (error) { told.wrong.push(String(error)); }
  document.body.dataset.told = JSON.stringify(told);
})();</script>";

/// The browser; `None`, said so, where there is none.
pub fn browser() -> Option<PathBuf> {
    let path = env::var_os("PATH").unwrap_or_default();
    let names = ["chromium-headless-shell", "chromium", "chromium-browser", "google-chrome"];
    let found =
        env::split_paths(&path).flat_map(|folder| names.map(|name| folder.join(name))).find(|path| path.is_file());
    if found.is_none() {
        assert!(env::var_os("MWD_REQUIRE_BROWSER").is_none(), "no browser: apt install chromium-headless-shell");
        println!("SKIPPED: no browser (apt install chromium-headless-shell)");
    }
    found
}

/// What a page tells of itself in a browser.
pub fn told(browser: &Path, page: &Path, width: u32, is_dark: bool) -> Value {
    told_by(CHECK, browser, page, width, is_dark)
}

/// What a script tells of a page in a browser, by `data-told` of the body.
pub fn told_by(check: &str, browser: &Path, page: &Path, width: u32, is_dark: bool) -> Value {
    let text = fs::read_to_string(page).unwrap();
    let text =
        text.replacen("<head>", &format!("<head>{LISTEN}"), 1).replacen("</body>", &format!("{check}</body>"), 1);
    let checked = page.with_extension("checked.html");
    fs::write(&checked, text).unwrap();
    let profile = TempDir::new().unwrap();
    let mut command = Command::new(browser);
    command.args(["--headless", "--no-sandbox", "--disable-gpu", "--hide-scrollbars", "--dump-dom"]);
    command.arg(format!("--user-data-dir={}", profile.path().display()));
    command.arg(format!("--window-size={width},900"));
    command.arg(format!("--blink-settings=preferredColorScheme={}", u8::from(!is_dark)));
    let output = command.arg(format!("file://{}", checked.display())).output().unwrap();
    let page = String::from_utf8_lossy(&output.stdout);
    let told = page.split("data-told=\"").nth(1).unwrap_or_else(|| panic!("{output:?}"));
    serde_json::from_str(&told.split('"').next().unwrap().replace("&quot;", "\"").replace("&amp;", "&")).unwrap()
}

/// Nothing is wrong, too wide, too small to read, or blank.
pub fn is_legible(told: &Value, width: u32, is_dark: bool) {
    assert_eq!(told["wrong"], Value::Array(Vec::new()), "{told}");
    assert_eq!((told["width"].as_u64(), told["dark"].as_bool()), (Some(width.into()), Some(is_dark)), "{told}");
    assert!(told["page"].as_u64().unwrap() <= u64::from(width) && told["wide"] == Value::Array(Vec::new()), "{told}");
    assert!(told["blank"] == 0 && told["small"] == 0, "{told}");
}

/// A page with plots of a flight: legible, and its keys work.
pub fn is_sound(told: &Value, width: u32, is_dark: bool) {
    is_legible(told, width, is_dark);
    assert!(told["plots"].as_u64().unwrap() > 10, "{told}");
    assert!(told["zooms"] == true && told["returns"] == true, "{told}");
    assert!(told["reads"].as_str().unwrap().contains(|letter: char| letter.is_ascii_digit()), "{told}");
}
