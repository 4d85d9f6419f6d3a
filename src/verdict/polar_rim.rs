//! Facets between the largest circle about the axis within a rim and the rim, which is no circle.

use super::polar_section::PolarSection;
use crate::geom::{DVec3, TriMesh};
use crate::num::{cos, sin};

/// Least distance of two places of an azimuth over that of the rows.
const CLOSE: f64 = 0.4;

/// A place of the rim.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct RimPlace {
    /// Its azimuth, radians.
    pub azimuth: f64,
    /// Whether it is a corner, at an azimuth of its own.
    pub is_corner: bool,
    /// Its distance from the axis, mm.
    pub radius_mm: f64,
}

/// The places of one azimuth beyond a circle.
pub(super) struct BeyondCircle {
    /// The azimuth, radians.
    azimuth: f64,
    /// Distance from the axis, mm, and Z with the move that cuts it, none where no move does.
    places: Vec<(f64, Option<(f64, usize)>)>,
}

/// The places beyond a circle up to a place of the rim, in the section there: cusps, and rows between them that are about so far apart.
pub(super) fn beyond(
    section: &impl PolarSection,
    circle: f64,
    &RimPlace { azimuth, radius_mm: rim, .. }: &RimPlace,
    apart_mm: f64,
) -> BeyondCircle {
    let close = CLOSE * apart_mm;
    let mut ends = vec![circle];
    for cusp in section.cusps_mm() {
        if cusp - ends[ends.len() - 1] > close && rim - cusp > close {
            ends.push(cusp);
        }
    }
    ends.push(rim);
    let mut places = Vec::new();
    for pair in ends.windows(2) {
        let parts = ((pair[1] - pair[0]) / apart_mm).round().max(1.0);
        let radius = |k: f64| pair[0] + (pair[1] - pair[0]) * (k / parts);
        places.extend((1..=parts as usize).map(|k| {
            let radius_mm = if k as f64 == parts { pair[1] } else { radius(k as f64) };
            (radius_mm, section.cut(radius_mm))
        }));
    }
    BeyondCircle { azimuth, places }
}

/// Adds the facets beyond a circle, whose vertices are the first of the mesh in the order of their azimuths.
///
/// # Errors
/// X and Y of a place that no move cuts, mm.
pub(super) fn add(
    mesh: &mut TriMesh,
    steps: &mut Vec<usize>,
    beyond: &[BeyondCircle],
) -> Result<(), [f64; 2]> {
    let count = beyond.len();
    let mut spokes: Vec<Vec<(f64, u32)>> = Vec::with_capacity(count);
    for (k, BeyondCircle { azimuth, places }) in beyond.iter().enumerate() {
        let out = [cos(*azimuth), sin(*azimuth)];
        let circle = mesh.vertices[k].truncate().length();
        let mut spoke = vec![(circle, k as u32)];
        for &(radius_mm, cut) in places {
            let [x, y] = out.map(|share| radius_mm * share);
            let (z, step) = cut.ok_or([x, y])?;
            spoke.push((radius_mm, mesh.vertices.len() as u32));
            mesh.vertices.push(DVec3::new(x, y, z));
            steps.push(step);
        }
        spokes.push(spoke);
    }
    for (k, spoke) in spokes.iter().enumerate() {
        mesh.triangles.extend(between(spoke, &spokes[(k + 1) % count]));
    }
    Ok(())
}

/// The facets between the places of two azimuths: of both next places the nearer one to the axis comes first.
fn between(here: &[(f64, u32)], there: &[(f64, u32)]) -> Vec<[u32; 3]> {
    let (mut i, mut j) = (0, 0);
    let mut facets = Vec::with_capacity(here.len() + there.len());
    while i + 1 < here.len() || j + 1 < there.len() {
        let goes_here = match (here.get(i + 1), there.get(j + 1)) {
            (Some((a, _)), Some((b, _))) => a <= b,
            (next, _) => next.is_some(),
        };
        if goes_here {
            facets.push([here[i].1, here[i + 1].1, there[j].1]);
            i += 1;
        } else {
            facets.push([here[i].1, there[j + 1].1, there[j].1]);
            j += 1;
        }
    }
    facets
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geom::{DVec2, turn};
    use crate::program::{SpindleTurn, ToolMove, TurnedSurface, TurningPath};
    use std::f64::consts::TAU;

    /// Between a circle and an ellipse-like rim the facets cover the belt once.
    #[test]
    fn facets_cover_the_belt_up_to_an_uneven_rim_once() {
        let mut path = TurningPath::default();
        let at = |k: usize| DVec3::new(12.0 - 0.2 * k as f64 / 8.0 - 0.8, 0.0, 4.0);
        for k in 0..8 * 40 {
            path.tool.moves.push(ToolMove { from: at(k), to: at(k + 1), feed: Some(1.0), line: 1 });
            path.turns.push(0.125);
            let [begin, end] = [k, k + 1].map(|k| k as f64 / 8.0);
            path.commanded.push(SpindleTurn { begin, end, minutes: 1.0 });
        }
        let surface = TurnedSurface::new(&path, 0.8);
        let (count, circle) = (360, 7.9);
        let rim = |k: usize| 9.0 + cos(2.0 * TAU * k as f64 / count as f64);
        let section = |k: usize| surface.section(k as f64 / count as f64);
        let places: Vec<_> = (0..count)
            .map(|k| {
                let azimuth = TAU * k as f64 / count as f64;
                let place = RimPlace { azimuth, is_corner: false, radius_mm: rim(k) };
                beyond(&section(k), circle, &place, 0.025)
            })
            .collect();
        let mut mesh = TriMesh { vertices: Vec::new(), triangles: Vec::new() };
        for k in 0..count {
            let angle = TAU * k as f64 / count as f64;
            let xy = circle * DVec2::new(cos(angle), sin(angle));
            mesh.vertices.push(xy.extend(4.0));
        }
        let mut steps = vec![0; count];
        add(&mut mesh, &mut steps, &places).unwrap();
        assert_eq!(steps.len(), mesh.vertices.len());
        let mut area = 0.0;
        for t in &mesh.triangles {
            let [a, b, c] = t.map(|v| mesh.vertices[v as usize].truncate());
            let double = turn(a, b, c);
            assert!(double > 0.0, "{a} {b} {c}");
            area += 0.5 * double;
        }
        // Of r = 9 + cos 2t: pi (81 + 1/2); chords of a degree are 5e-5 inside.
        let exact = std::f64::consts::PI * (81.5 - circle * circle);
        assert!((area / exact - 1.0).abs() < 5e-4, "{area} {exact}");
        let high = mesh.vertices.iter().map(|v| v.z).fold(0.0, f64::max);
        let cusp = 0.8 - f64::sqrt(0.64 - 0.01);
        assert!((high - 4.0 - cusp).abs() < 1e-4, "{high}");
    }
}
