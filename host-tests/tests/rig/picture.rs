//! Pictures of pages, small and grey, so that they stay alike from one version of a browser to the next: how light is
//! what, and where, not which letters.

use std::{
    fs::{self, File},
    io::BufReader,
    path::Path,
    process::Command,
};

use tempfile::TempDir;

/// Width of a small picture, pixels: a plot is some 50 of them wide on a desk.
const WIDTH: usize = 64;

/// A picture in shades of grey.
#[derive(Clone, Debug, PartialEq)]
pub struct Picture {
    /// Width, pixels.
    pub width: usize,
    /// Shades, row by row; 255 is white.
    pub shades: Vec<u8>,
}

/// How far two pictures are apart.
#[derive(Clone, Copy, Debug)]
pub struct Apart {
    /// Mean difference of the shades.
    pub mean: f64,
    /// Share of pixels that differ by more than a quarter of the way from black to white.
    pub share: f64,
}

impl Picture {
    /// What a browser shows of a page's first `height` pixels, with every plot drawn.
    pub fn of_page(browser: &Path, page: &Path, [width, height]: [u32; 2], is_dark: bool) -> Self {
        let folder = TempDir::new().unwrap();
        let all = fs::read_to_string(page).unwrap();
        let drawn = all.replacen("</body>", "<script>if (window.report) report.buildAll()</script></body>", 1);
        let (at, shot) = (folder.path().join("page.html"), folder.path().join("shot.png"));
        fs::write(&at, drawn).unwrap();
        let mut command = Command::new(browser);
        command.args([
            "--headless",
            "--no-sandbox",
            "--disable-gpu",
            "--hide-scrollbars",
            "--virtual-time-budget=3000",
        ]);
        command.arg(format!("--user-data-dir={}", folder.path().join("profile").display()));
        command.arg(format!("--window-size={width},{height}"));
        command.arg(format!("--blink-settings=preferredColorScheme={}", u8::from(!is_dark)));
        command.arg(format!("--screenshot={}", shot.display())).arg(format!("file://{}", at.display()));
        let output = command.output().unwrap();
        assert!(shot.is_file(), "{output:?}");
        Self::read(&shot).smaller()
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

    /// How far this picture is from another of the same size; one of another size is as far as can be.
    pub fn apart(&self, other: &Self) -> Apart {
        if (self.width, self.shades.len()) != (other.width, other.shades.len()) {
            return Apart { mean: 255.0, share: 1.0 };
        }
        let differences = || self.shades.iter().zip(&other.shades).map(|(a, b)| f64::from(a.abs_diff(*b)));
        let count = self.shades.len() as f64;
        Apart {
            mean: differences().sum::<f64>() / count,
            share: differences().filter(|difference| *difference > 64.0).count() as f64 / count,
        }
    }
}
