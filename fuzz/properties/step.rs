//! STEP files: closed bodies of curved faces.

use morion::internals::brep::{Body, ChartedBody};
use morion::internals::geom::{Chart, DVec2, DVec3, Ray};

/// Faces of a body that is cut into pieces.
const FEW: usize = 8;
/// Rays across a body, along each side.
const ACROSS: u32 = 5;

pub fn holds(bytes: &[u8]) {
    let body = match Body::read(bytes) {
        Ok(body) => body,
        Err(error) => {
            let said = error.to_string();
            assert!(!said.contains(char::is_control), "{said:?}");
            return;
        }
    };
    let facts = body.facts();
    assert!(facts.volume_mm3 > 0.0 && facts.volume_mm3.is_finite(), "{facts:?}");
    assert!(facts.faces > 0 && facts.components > 0, "{facts:?}");
    let [lo, hi] = body.bounds();
    // (Where nothing bounds a face it is in no picture.)
    if !(lo.is_finite() && hi.is_finite()) {
        return;
    }
    assert!(lo.cmple(hi).all(), "{lo} {hi}");
    // (Of many faces they take seconds in a program that counts its branches.)
    let pieces = if facts.faces <= FEW { body.pieces() } else { Vec::new() };
    for piece in pieces {
        assert!(piece.normals[0].cmple(piece.normals[1]).all(), "{piece:?}");
    }
    assert!(body.sampled().vertices.iter().all(|v| v.is_finite()));
    let size = (hi - lo).max_element();
    let start = 2.0 * size + hi.z;
    let place = |k: u32| {
        let share = DVec2::new(f64::from(k % ACROSS) + 0.43, f64::from(k / ACROSS) + 0.47);
        lo.truncate() + (hi - lo).truncate() * share / f64::from(ACROSS)
    };
    let places: Vec<DVec2> = (0..ACROSS * ACROSS).map(place).collect();
    for q in &places {
        let ray = Ray { origin: q.extend(start), direction: DVec3::NEG_Z };
        if let Some(hit) = body.nearest_hit(&ray, 0.0, f64::INFINITY) {
            assert!(hit.t > 0.0 && hit.t.is_finite(), "{hit:?}");
            assert!((hit.face as usize) < facts.faces, "{hit:?}");
        }
    }
    let chart = Chart::on_axis(0.0, hi.z);
    let Some(charted) = ChartedBody::new(&body, &chart, start, size / f64::from(ACROSS)) else {
        return;
    };
    let rows: Vec<&[DVec2]> = places.chunks(ACROSS as usize).collect();
    charted.meet(&rows, |_, ray, hit| {
        assert!(ray.at(hit.t).is_finite() && (hit.face as usize) < facts.faces, "{hit:?}");
    });
}
