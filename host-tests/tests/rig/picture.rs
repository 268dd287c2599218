//! Pictures of pages, small and grey, so that they stay alike from one version of a browser to the next: how light is
//! what, and where, not which letters.

#![allow(clippy::unwrap_used)]

use std::{
    env,
    fs::{self, File},
    io::BufReader,
    path::Path,
    process::Command,
};

use tempfile::TempDir;

/// Width of a small picture, pixels: a plot is some 50 of them wide on a desk.
const WIDTH: usize = 64;

/// Height of the window in which a page is drawn, pixels: more than any page that is looked at.
const HEIGHT: u32 = 24_000;

/// Rows of small pixels that are compared at once, and how far they may have moved since the rows before: a line of
/// text more or less moves all that follows.
const ROWS: usize = 24;
const MOVED: usize = 6;

/// Limits of a page's difference from its picture: mean difference of the shades, and share of the squares that differ
/// by a quarter of the range.
const ALIKE: (f64, f64) = (5.0, 0.015);

/// Checks that a page looks as in its pictures in `tests/pages` at both widths, in the light and in the dark.
/// `MWD_BLESS=1` writes them anew.
///
/// # Panics
/// When it does not, or when two of the pictures could pass for one another.
pub fn looks_as_in_its_pictures(browser: &Path, page: &Path, name: &str) {
    let mut seen: Vec<Picture> = Vec::new();
    for (width, is_dark) in [(1280, false), (1280, true), (390, false), (390, true)] {
        let name = format!("{name}_{width}_{}.png", if is_dark { "dark" } else { "light" });
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/pages").join(&name);
        let picture = Picture::of_page(browser, page, width, is_dark);
        if env::var_os("MWD_BLESS").is_some_and(|value| value == "1") {
            picture.write(&path);
        }
        let apart = picture.apart(&Picture::read(&path));
        println!("{name}: {apart:.3?}");
        let is_alike = apart.mean < ALIKE.0 && apart.share < ALIKE.1;
        assert!(is_alike, "{name}: {apart:?}; look at the page, then MWD_BLESS=1 writes the picture anew");
        seen.push(picture);
    }
    // A picture that would pass for another tells nothing.
    for (k, picture) in seen.iter().enumerate() {
        assert!(seen.iter().skip(k + 1).all(|other| picture.apart(other).mean > 5.0 * ALIKE.0));
    }
}

/// A picture in shades of grey.
#[derive(Clone, Debug, PartialEq)]
pub struct Picture {
    /// Width, pixels.
    pub width: usize,
    /// Shades, row by row; 255 is white.
    pub shades: Vec<u8>,
}

/// Difference of two pictures.
#[derive(Clone, Copy, Debug)]
pub struct Apart {
    /// Mean difference of the shades.
    pub mean: f64,
    /// Share of pixels that differ by more than a quarter of the way from black to white.
    pub share: f64,
}

impl Picture {
    /// Picture of a whole page as a browser shows it, with every plot drawn.
    pub fn of_page(browser: &Path, page: &Path, width: u32, is_dark: bool) -> Self {
        let folder = TempDir::new().unwrap();
        let all = fs::read_to_string(page).unwrap();
        let drawn = all.replacen("</body>", "<script>if (window.report) report.buildAll()</script></body>", 1);
        let (at, shot) = (folder.path().join("page.html"), folder.path().join("shot.png"));
        fs::write(&at, drawn).unwrap();
        let mut command = Command::new(browser);
        command.args(["--headless", "--no-sandbox", "--disable-gpu", "--hide-scrollbars"]);
        command.arg(format!("--user-data-dir={}", folder.path().join("profile").display()));
        command.arg(format!("--window-size={width},{HEIGHT}"));
        command.arg(format!("--blink-settings=preferredColorScheme={}", u8::from(!is_dark)));
        command.arg(format!("--screenshot={}", shot.display())).arg(format!("file://{}", at.display()));
        let output = command.output().unwrap();
        assert!(shot.is_file(), "{output:?}");
        Self::read(&shot).smaller().without_what_is_below()
    }

    /// Reads a picture of 8 bits, in colours or in shades.
    pub fn read(path: &Path) -> Self {
        let mut reader = png::Decoder::new(BufReader::new(File::open(path).unwrap())).read_info().unwrap();
        let mut bytes = vec![0; reader.output_buffer_size().unwrap()];
        let info = reader.next_frame(&mut bytes).unwrap();
        let of = |pixel: &[u8]| match *pixel {
            // Parts of the three colours in what looks as light (ITU-R BT.709).
            [r, g, b, ..] => (0.2126 * f64::from(r) + 0.7152 * f64::from(g) + 0.0722 * f64::from(b)) as u8,
            [shade, ..] => shade,
            [] => 0,
        };
        let shades = bytes[..info.buffer_size()].chunks(info.color_type.samples()).map(of).collect();
        Self { width: info.width as usize, shades }
    }

    /// Writes the picture.
    pub fn write(&self, path: &Path) {
        let height = self.shades.len() / self.width;
        let mut encoder = png::Encoder::new(File::create(path).unwrap(), self.width as u32, height as u32);
        encoder.set_color(png::ColorType::Grayscale);
        encoder.write_header().unwrap().write_image_data(&self.shades).unwrap();
    }

    /// Means over squares.
    fn smaller(&self) -> Self {
        let side = self.width / WIDTH;
        let height = self.shades.len() / self.width / side;
        let square = |row: usize, column: usize| {
            let rows = (row * side..(row + 1) * side).map(|y| &self.shades[y * self.width..][column * side..][..side]);
            (rows.flatten().map(|shade| usize::from(*shade)).sum::<usize>() / (side * side)) as u8
        };
        let places = (0..height).flat_map(|row| (0..WIDTH).map(move |column| (row, column)));
        Self { width: WIDTH, shades: places.map(|(row, column)| square(row, column)).collect() }
    }

    /// Without the empty rows at the end.
    fn without_what_is_below(mut self) -> Self {
        let ground = self.shades.last().copied();
        let end = self.shades.iter().rposition(|shade| Some(*shade) != ground).unwrap_or(0);
        assert!(end + self.width < self.shades.len(), "the page is longer than the window");
        self.shades.truncate((end / self.width + 1) * self.width);
        self
    }

    /// Difference of this picture from another, each stretch of rows beside the rows of the other that it is most like.
    /// Rows that one has at its end and the other has not differ as far as can be.
    pub fn apart(&self, other: &Self) -> Apart {
        let (mut moved, mut total, mut far, mut count) = (0_isize, 0.0, 0, 0);
        for (number, rows) in self.shades.chunks(ROWS * self.width).enumerate() {
            let start = (number * ROWS) as isize;
            let differences = |by: isize| {
                let from = usize::try_from(start + by).ok()? * self.width;
                let beside = other.shades.get(from..from + rows.len())?;
                Some(rows.iter().zip(beside).map(|(a, b)| f64::from(a.abs_diff(*b))).collect::<Vec<_>>())
            };
            let sum = |by: &isize| differences(*by).map_or(f64::MAX, |all| all.iter().sum());
            let around = MOVED as isize;
            let best = (moved - around..=moved + around)
                .min_by(|a, b| sum(a).total_cmp(&sum(b)).then(a.abs_diff(moved).cmp(&b.abs_diff(moved))));
            let of_best = best.and_then(|by| Some((by, differences(by)?)));
            let all = of_best.map_or_else(
                || vec![255.0; rows.len()],
                |(by, all)| {
                    moved = by;
                    all
                },
            );
            total += all.iter().sum::<f64>();
            far += all.iter().filter(|difference| **difference > 64.0).count();
            count += all.len();
        }
        let rows = |picture: &Self| picture.shades.len() / self.width;
        let lacking = rows(self).abs_diff(rows(other)).saturating_sub(ROWS) * self.width;
        let count = (count + lacking).max(1) as f64;
        Apart { mean: (total + 255.0 * lacking as f64) / count, share: (far + lacking) as f64 / count }
    }
}
