use robhaz_estimator::GroundPoint;
use robhaz_run::{Observers, RunDescription};
use robhaz_scene::Scene;
use robhaz_sim::Plant;
use std::path::Path;

fn scene(name: &str, overrides: &[String]) -> Scene {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes");
    Scene::load(&path.join(format!("{name}.toml")), overrides).unwrap()
}

#[test]
fn experiment() {
    let extra: Vec<String> = std::env::var("SET")
        .unwrap_or_default()
        .split_whitespace()
        .map(str::to_owned)
        .collect();
    let name = std::env::var("SCENE").unwrap_or("smooth".into());
    let seeds: u64 = std::env::var("SEEDS").map_or(5, |s| s.parse().unwrap());
    let mut overrides: Vec<String> = [
        "engine.kind=direct",
        "sensors.grade=typical",
        "estimator=[{name='best'}]",
    ]
    .map(str::to_owned)
    .to_vec();
    overrides.extend(extra);
    let scene = scene(&name, &overrides);
    let mut plant = Plant::new(&scene.plant_setup()).unwrap();
    let count = (scene.record_count() - 1) * scene.samples_per_record() + 1;
    let truth: Vec<_> = (0..count).map(|_| plant.next_truth().unwrap()).collect();
    let description = RunDescription::of(&scene).unwrap();
    let terrain = description
        .world
        .as_ref()
        .unwrap()
        .terrain
        .build(&description.robot.robot);
    let height = |x: f64| {
        let s = terrain.survey(x, x + 1e-9, 1.0);
        (s[0].height, s[0].slope.unwrap_or(0.0))
    };
    let start = truth[0].wheels[1].position.x;
    let (h0, _) = height(start);
    let detail = std::env::var("DETAIL").is_ok();
    let (mut all, mut all_slope, mut n_all) = (0.0, 0.0, 0.0);
    for seed in 0..seeds {
        let scene = Scene {
            seed,
            ..scene.clone()
        };
        let mut observers = Observers::new(&scene).unwrap();
        let mut m = [[0.0_f64; 3]; 2];
        let mut c = [[0.0_f64; 3]; 3];
        for t in &truth {
            let (_, e) = observers.observe(t);
            if let Ok(e) = &e[0] {
                if t.time > 1.5 && t.time < 16.0 {
                    for i in 0..2 {
                        let d = e.posture.links[i] - t.links[i].angle;
                        m[i][0] += 1.0;
                        m[i][1] += d;
                        m[i][2] += d * d;
                    }
                    for i in 0..3 {
                        let d = e.contact_angle[i] - t.wheels[i].contact_angle;
                        c[i][0] += 1.0;
                        c[i][1] += d;
                        c[i][2] += d * d;
                    }
                }
            }
        }
        let f = |m: &[f64; 3]| {
            let a = m[1] / m[0];
            (a.to_degrees(), (m[2] / m[0] - a * a).sqrt().to_degrees())
        };
        println!(
            "LINK {seed} {:.3?} {:.3?} angle {:.3?} {:.3?} {:.3?} gyro {:?}",
            f(&m[0]),
            f(&m[1]),
            f(&c[0]),
            f(&c[1]),
            f(&c[2]),
            scene.sensors().drawn()
        );
        let ground = observers.ground();
        let points: Vec<GroundPoint> = ground
            .completed(0)
            .iter()
            .copied()
            .chain(ground.in_memory(0))
            .collect();
        let (mut sq, mut nees, mut inside, mut sqs, mut sn, mut ins, mut n) =
            (0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0);
        let mut worst: f64 = 0.0;
        for p in points.iter().filter(|p| p.x > 0.0 && p.x <= 3.0) {
            let (h, s) = height(start + p.x);
            let e = p.height - (h - h0);
            let es = p.slope - s.atan();
            sq += e * e;
            nees += (e / p.sigma_height).powi(2);
            inside += f64::from(e.abs() < 2.0 * p.sigma_height);
            sqs += es * es;
            sn += (es / p.sigma_slope).powi(2);
            ins += f64::from(es.abs() < 2.0 * p.sigma_slope);
            worst = worst.max(e.abs());
            n += 1.0;
            if detail && seed == 0 {
                println!(
                    "{:.2} h {:.4} e {:+.2} mm s {:.2} slope e {:+.2} s {:.2} deg sx {:.2} mm {}",
                    p.x,
                    h - h0,
                    1e3 * e,
                    1e3 * p.sigma_height,
                    es.to_degrees(),
                    p.sigma_slope.to_degrees(),
                    1e3 * p.sigma_x,
                    p.section
                );
            }
        }
        if std::env::var("DUMP").is_ok() {
            for p in points.iter().filter(|p| p.x > 0.0 && p.x <= 3.0) {
                let (h, sl) = height(start + p.x);
                println!(
                    "DUMP {seed} {} {} {} {} {} {} {} {}",
                    p.x,
                    p.height - (h - h0),
                    sl,
                    p.sigma_height,
                    p.slope - sl.atan(),
                    p.sigma_slope,
                    scene.sensors().drawn().inclination_bias[0],
                    scene.sensors().drawn().inclination_bias[1]
                );
            }
        }
        all += sq / n;
        all_slope += sqs / n;
        n_all += 1.0;
        println!(
            "seed {seed}: points {} height rms {:.2} mm worst {:.2} NEES {:.2} inside {:.1} %  slope rms {:.3} deg NEES {:.2} inside {:.1} %  n {n} drawn {:?}",
            points.len(),
            1e3 * (sq / n as f64).sqrt(),
            1e3 * worst,
            nees / n,
            100.0 * inside / n,
            (sqs / n as f64).sqrt().to_degrees(),
            sn / n,
            100.0 * ins / n,
            scene
                .sensors()
                .drawn()
                .inclination_bias
                .map(|b: f64| b.to_degrees())
        );
    }
    let n: f64 = n_all;
    println!(
        "ALL height {:.2} mm, slope {:.3} deg",
        1e3 * (all / n).sqrt(),
        (all_slope / n).sqrt().to_degrees()
    );
}
