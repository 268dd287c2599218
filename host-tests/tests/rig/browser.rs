//! Pages in a browser, and what they tell of themselves. Chromium draws them; without one a test prints SKIPPED, and
//! with `MWD_REQUIRE_BROWSER=1` it fails.

use std::{
    env, fs,
    net::TcpListener,
    path::{Path, PathBuf},
    process::Command,
};

use serde_json::Value;
use tempfile::TempDir;

/// Runs in the page before everything else.
const LISTEN: &str =
    "<script>window.wrong = []; window.onerror = text => { window.wrong.push(String(text)); };</script>";

/// Runs when the page is there. The page counts as loading until its picture that never comes is let go: so long the
/// browser draws frames, and does not write the page out.
const CHECK: &str = "<script>(async () => {
  const told = { wrong: window.wrong, dark: matchMedia('(prefers-color-scheme: dark)').matches, width: innerWidth };
  // Until what is drawn next has been painted.
  const frame = () => new Promise(done => requestAnimationFrame(() => {
    const after = new MessageChannel();
    after.port1.onmessage = () => done();
    after.port2.postMessage(0);
  }));
  const all = (what, of = document) => [...of.querySelectorAll(what)];
  // Height of the letters of drawings, pixels, and how many texts stick out of their drawing.
  const letters = () => all('main svg text').filter(node => node.getBoundingClientRect().height > 0).map(node => {
    const { a, b } = node.getScreenCTM();
    return parseFloat(getComputedStyle(node).fontSize) * Math.hypot(a, b);
  });
  const outside = () => all('main svg text').filter(node => {
    const text = node.getBoundingClientRect(), drawing = node.ownerSVGElement.getBoundingClientRect();
    return text.height > 0 && (text.left < drawing.left - 1 || text.right > drawing.right + 1 || text.top < drawing.top - 1 || text.bottom > drawing.bottom + 1);
  }).map(node => node.textContent);
  const root = document.documentElement;
  try {
    if (window.report) report.buildAll();
    await frame();
    told.page = root.scrollWidth;
    const inside = node => node.closest('.scroll, pre, .uplot');
    told.wide = all('main *').filter(node => !inside(node) && node.getBoundingClientRect().right > innerWidth + 1)
      .map(node => node.tagName + ' ' + node.className);
    told.blank = all('.uplot canvas').filter(canvas => {
      const pixels = canvas.getContext('2d').getImageData(0, 0, canvas.width, canvas.height).data;
      const seen = new Set();
      for (let k = 0; k < pixels.length; k += 4) if (pixels[k + 3] > 200) seen.add(pixels[k] << 16 | pixels[k + 1] << 8 | pixels[k + 2]);
      return seen.size < 3;
    }).length;
    told.plots = all('.uplot').length;
    told.small = all('main *').filter(node => !node.closest('svg') && node.childNodes.length && parseFloat(getComputedStyle(node).fontSize) < 12).length;
    told.letters = letters();
    told.outside = outside();
    if (root.classList.contains('scripted')) {
      // As it is seen without scripts, and on paper.
      root.classList.remove('scripted');
      told.letters.push(...letters());
      told.outside.push(...outside());
      told.page = Math.max(told.page, root.scrollWidth);
      root.classList.add('scripted');
    }
    told.letters = Math.min(99, ...told.letters);
    told.unnamed = all('th').filter(node => !node.textContent.trim()).length;
    if (window.report) {
    const first = report.plots[0];
    first.figure.scrollIntoView();
    await frame(); await frame();
    const press = key => first.place.dispatchEvent(new KeyboardEvent('keydown', { key, bubbles: true }));
    const span = () => document.querySelector('.bar .span').textContent;
    const before = span();
    press('+');
    told.zooms = span() !== before;
    press('Home');
    told.returns = span() === before;
    const times = first.u.data[0];
    const [from, to] = [times[0], times[times.length - 1]];
    report.show(from, to);
    await frame();
    press('ArrowRight');
    told.reads = first.figure.querySelector('.legend output').textContent;
    // Zoomed in, a plot shows all of its values.
    told.lost = [];
    const middle = (from + to) / 2;
    const part = { min: middle - 0.2 * (to - from), max: middle + 0.2 * (to - from) };
    for (const plot of report.plots) {
      plot.figure.scrollIntoView();
      await frame();
      report.show(part.min, part.max);
      await frame(); await frame();
      const { min, max } = plot.u.scales.y;
      plot.u.series.forEach((series, k) => {
        if (k > 0 && series.width > 0 && plot.u.data[k].some((y, i) => y !== null && y !== undefined && plot.u.data[0][i] >= part.min && plot.u.data[0][i] <= part.max && (y < min || y > max))) told.lost.push(series.label);
      });
    }
    // The span moves: milliseconds to the painted frame, and points a pixel that are drawn for it.
    told.frames_ms = [];
    told.crowd = 0;
    for (let number = 0; number < report.plots.length; number += 3) {
      report.plots[number].figure.scrollIntoView();
      await frame(); await frame();
      for (let k = 0; k < 5; k++) {
        const began = performance.now();
        report.show(from + k, from + k + 0.9 * (to - from));
        await frame();
        told.frames_ms.push(performance.now() - began);
      }
      for (const plot of report.plots) if (plot.isSeen) told.crowd = Math.max(told.crowd, plot.u.data[0].length / plot.u.over.clientWidth);
    }
    report.show(from, to);
    }
  } catch (error) { told.wrong.push(String(error)); }
  document.body.dataset.told = JSON.stringify(told);
  document.getElementById('hold').src = '';
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

/// Findings of the script `CHECK` on a page in a browser.
pub fn told(browser: &Path, page: &Path, width: u32, is_dark: bool) -> Value {
    told_by(CHECK, browser, page, width, is_dark)
}

/// Findings of a script on a page in a browser, from `data-told` of the body.
pub fn told_by(check: &str, browser: &Path, page: &Path, width: u32, is_dark: bool) -> Value {
    let text = fs::read_to_string(page).unwrap();
    // Nobody answers there: the page loads until its script has done.
    let silent = TcpListener::bind(("127.0.0.1", 0)).unwrap();
    let hold = format!("http://{}/", silent.local_addr().unwrap());
    let text =
        text.replacen("<head>", &format!("<head>{LISTEN}"), 1).replacen("img-src data:", &format!("img-src {hold}"), 1);
    let held = format!("<img id=\"hold\" src=\"{hold}\" alt=\"\" hidden/>{check}</body>");
    let text = text.replacen("</body>", &held, 1);
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

/// Mean and largest time to a painted frame while the span moves, milliseconds.
pub fn frame_ms(told: &Value) -> [f64; 2] {
    let frames: Vec<f64> = told["frames_ms"].as_array().unwrap().iter().filter_map(Value::as_f64).collect();
    [frames.iter().sum::<f64>() / frames.len() as f64, frames.iter().copied().fold(0.0, f64::max)]
}

/// Nothing is wrong, too wide, too small to read, or blank.
pub fn is_legible(told: &Value, width: u32, is_dark: bool) {
    assert_eq!(told["wrong"], Value::Array(Vec::new()), "{told}");
    assert_eq!((told["width"].as_u64(), told["dark"].as_bool()), (Some(width.into()), Some(is_dark)), "{told}");
    assert!(told["page"].as_u64().unwrap() <= u64::from(width) && told["wide"] == Value::Array(Vec::new()), "{told}");
    assert!(told["blank"] == 0 && told["small"] == 0 && told["unnamed"] == 0, "{told}");
    assert!(
        told["letters"].as_f64().unwrap() >= LEAST_LETTERS && told["outside"] == Value::Array(Vec::new()),
        "{told}"
    );
}

/// Least height of letters in drawings, pixels.
const LEAST_LETTERS: f64 = 11.5;

/// Most points a pixel that a line is drawn with: the least and the largest of each column, and breaks.
const CROWD: f64 = 3.0;

/// A page with plots of a flight: legible, its keys work, and what it draws for a frame is what a screen can show.
pub fn is_sound(told: &Value, width: u32, is_dark: bool) {
    is_legible(told, width, is_dark);
    assert!(told["plots"].as_u64().unwrap() > 6, "{told}");
    assert!(told["lost"] == Value::Array(Vec::new()) && told["crowd"].as_f64().unwrap() < CROWD, "{told}");
    assert!(told["zooms"] == true && told["returns"] == true, "{told}");
    assert!(told["reads"].as_str().unwrap().contains(|letter: char| letter.is_ascii_digit()), "{told}");
}
