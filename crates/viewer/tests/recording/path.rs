//! A judged path is read back from its recording.

use crate::reading::{chunks, rows, scalars};
use rerun::archetypes::{Ellipses2D, Points2D};
use rerun::components::{Position2D, Text};
use robhaz_model::Vec2;
use robhaz_terrain::{Profile, Terrain};
use robhaz_viewer::{JudgedPath, PathPlace, save_path};

/// Equivalence of the recording and the path, place by place: distance, friction, margin, centres of the wheels. A path
/// that fails has a mark with its reason.
#[test]
fn a_path_is_recorded_as_judged() {
    let folder = tempfile::tempdir().expect("a folder");
    let file = folder.path().join("path.rrd");
    let terrain = Terrain::new(Profile::step());
    let place = |k: u32| {
        let x = 0.1 + 0.01 * f64::from(k);
        let friction = |mu: f64| (k != 7).then_some(mu + 0.001 * f64::from(k));
        PathPlace {
            wheels: [0.4, 0.0, -0.4].map(|ahead| Vec2::new(x + ahead, 0.1 + 0.01 * x)),
            needed_mu: friction(0.1),
            available_mu: friction(0.8),
            margin: friction(0.7),
        }
    };
    let places: Vec<PathPlace> = (0..50).map(place).collect();
    for failure in [None, Some((0.2, "it tips over"))] {
        let path = JudgedPath {
            name: "path of step",
            terrain: &terrain,
            wheel_radius: 0.1,
            places: &places,
            failure,
            text: "judged",
        };
        save_path(&path, &file).expect("a recording");
        let chunks = chunks(&file);
        let friction = scalars(&chunks, "/series/path/friction");
        let margin = scalars(&chunks, "/series/path/margin");
        let component = Ellipses2D::descriptor_centers().component;
        let centres = rows::<Position2D>(&chunks, "/world/wheels", component);
        let start = places[0].wheels[1].x;
        let count = places.len();
        assert_eq!([friction.len(), margin.len(), centres.len()], [count; 3]);
        for (k, place) in places.iter().enumerate() {
            // Times are in whole nanoseconds.
            assert!((friction[k].0 - (place.wheels[1].x - start)).abs() < 2e-9);
            let bits = |value: Option<f64>| value.unwrap_or(f64::NAN).to_bits();
            assert_eq!(friction[k].1[0].to_bits(), bits(place.available_mu));
            assert_eq!(friction[k].1[1].to_bits(), bits(place.needed_mu));
            assert_eq!(margin[k].1[1].to_bits(), bits(place.margin));
            for (i, centre) in centres[k].1.iter().enumerate() {
                // Single precision, at most 10 m.
                assert!((f64::from(centre.x()) - place.wheels[i].x).abs() < 1e-6);
                assert!((f64::from(centre.y()) - place.wheels[i].y).abs() < 1e-6);
            }
        }
        assert_eq!(chunks.contains_key("/world/failure"), failure.is_some());
        if let Some((_, reason)) = failure {
            let component = Points2D::descriptor_labels().component;
            let label = &chunks["/world/failure"][0];
            let label = label.iter_component::<Text>(component).next();
            let label = label.expect("a label").as_slice()[0].to_string();
            assert_eq!(label, format!("no-go: {reason}"));
        }
    }
}
