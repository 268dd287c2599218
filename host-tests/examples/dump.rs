use mwd::{bench::drilling::tool, flight::configuration::of_trace, simulate::simulate, trace::Trace};
use std::io::Write;
fn put(name: &str, config: &meerkat_mwd::Config, trace: &Trace, p: Option<[f64; 9]>) {
    let dir = "/tmp/w/dump";
    std::fs::create_dir_all(dir).unwrap();
    std::fs::write(format!("{dir}/{name}.toml"), toml::to_string(config).unwrap()).unwrap();
    let mut f = std::io::BufWriter::new(std::fs::File::create(format!("{dir}/{name}.bin")).unwrap());
    let p = p.unwrap_or([f64::NAN; 9]);
    for x in p {
        f.write_all(&x.to_le_bytes()).unwrap();
    }
    for (i, s) in trace.samples.iter().enumerate() {
        f.write_all(&s.t_us.to_le_bytes()).unwrap();
        for x in s.gyro_rad_s.iter().chain(&s.accel_m_s2).chain(&s.mag_ut).chain([&s.temperature_c]) {
            f.write_all(&x.to_le_bytes()).unwrap();
        }
        f.write_all(&u32::from(s.flags.bits()).to_le_bytes()).unwrap();
        let q = trace.reference.get(i).copied().flatten().unwrap_or([f64::NAN; 4]);
        for x in q {
            f.write_all(&x.to_le_bytes()).unwrap();
        }
    }
}
fn main() {
    let inclinations = [0.0, 5.0, 15.0, 45.0, 70.0, 90.0];
    let rpms = [0.0, 30.0, 60.0, 120.0, 180.0];
    for seed in 0..300u64 {
        let cell = (seed % 30) as usize;
        let (inc, rpm) = (inclinations[cell % 6], rpms[cell / 6]);
        let (trace, truth) = simulate(&tool::scenario(inc, rpm, seed), seed);
        let p = truth.gyro.p_matrix().map(f64::from);
        put(&format!("d{seed}"), &tool::config(&trace), &trace, Some(std::array::from_fn(|i| p[(i / 3, i % 3)])));
    }
    for arg in std::env::args().skip(1) {
        let path = std::path::Path::new(&arg);
        let trace = Trace::read(path).unwrap();
        let p = trace.keys.true_gyro_p;
        let name = path.to_str().unwrap().replace('/', "_").replace(".csv", "").replace(".gz", "").replace(".zst", "");
        put(&name, &of_trace(&trace), &trace, p.map(|p| p.map(|x| x as f64)));
    }
}
