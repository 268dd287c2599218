use meerkat_mwd::{Probe, compensation::effects::LIBRARY};
use mwd::{bench::drilling::tool, simulate::simulate};
use nalgebra::{Matrix3, Quaternion, UnitQuaternion};
fn rot(q: [f64; 4]) -> Matrix3<f64> {
    *UnitQuaternion::from_quaternion(Quaternion::new(q[0], q[1], q[2], q[3])).to_rotation_matrix().matrix()
}
fn main() {
    let args: Vec<String> = std::env::args().skip(1).collect();
    let verbose = std::env::var("V").is_ok();
    let inclinations = [0.0, 5.0, 15.0, 45.0, 70.0, 90.0];
    let rpms = [0.0, 30.0, 60.0, 120.0, 180.0];
    for arg in args {
        let seed: u64 = arg.parse().unwrap();
        let cell = (seed % 30) as usize;
        let (inc, rpm) = (inclinations[cell % 6], rpms[cell / 6]);
        let (trace, truth) = simulate(&tool::scenario(inc, rpm, seed), seed);
        let mut config = tool::config(&trace);

        let mut probe = Box::new(Probe::new());
        probe.set_library(&LIBRARY);
        probe.configure(&config).unwrap();
        let true_p = truth.gyro.p_matrix().map(f64::from);
        if verbose {
            println!("true P {:?} b {:?}", truth.gyro.p, truth.gyro.b_rad_s);
        }
        let first = trace.first_us();
        let (mut worst_p, mut sum, mut n) = (0.0f64, 0.0, 0);
        let mut next = 0.0;
        let mut motion = 0.0;
        let mut named = String::new();
        for (sample, reference) in trace.samples.iter().zip(&trace.reference) {
            let out = probe.push(sample);
            probe.poll(probe.poll_budget());
            let d = probe.take_diagnosis();
            let t = (sample.t_us - first) as f64 * 1e-6;
            let p = probe.gyro_model().p_matrix().map(f64::from);
            let e = (p - true_p).amax();
            worst_p = worst_p.max(e);
            let m = probe.estimator().motion_s();
            if m < motion && verbose {
                println!("{t:.2}: restart {motion} -> {m}");
            }
            motion = m;
            if let Some(a) = out.and_then(|o| o.attitude.map(|a| a.q)) {
                if let Some(r) = reference {
                    let (c, tr) = (rot(a.map(f64::from)), rot(*r));
                    let inc = |c: &Matrix3<f64>| c.m31.hypot(c.m32).atan2(c.m33);
                    let e = (inc(&c) - inc(&tr)).to_degrees();
                    if t > 35.0 {
                        sum += e * e;
                        n += 1;
                    }
                    if verbose && t >= next {
                        println!("{t:.1}: inc err {e:.3}");
                    }
                }
            }
            if t >= next {
                next = t + 1.0;
                if verbose {
                    println!(
                        "   {t:.1} P-err% {:?} b {:?}",
                        (p - true_p).transpose().iter().map(|x| (x * 1e4).round() / 100.0).collect::<Vec<_>>(),
                        probe.gyro_model().b_rad_s
                    );
                    for c in probe.estimator().claims() {
                        println!(
                            "      claim {} step {} ev {:.1} p {:?} s {:?} out {}",
                            c.effect, c.step, c.evidence, c.parameters, c.sigma, c.is_taken_out
                        );
                    }
                }
            }
            for c in probe.estimator().claims() {
                let s = format!("{}{}:{} ", c.effect, if c.is_taken_out { "*" } else { "" }, c.step);
                if !named.contains(&s) {
                    named += &s;
                }
            }
            let _ = d;
        }
        println!(
            "seed {seed} inc {inc} rpm {rpm}: worst P err {:.2}% inc rms {:.3} named {named}",
            worst_p * 100.0,
            (sum / n as f64).sqrt()
        );
    }
}
