//! Mirrors with a single viewpoint: from there every hidden direction follows by plane trigonometry.

use super::{HYPERBOLIC, PARABOLIC, hidden_by, traced};
use crate::support::builds::parsed;
use morion::internals::design::Design;
use morion::internals::geom::{DVec2, DVec3};
use morion::internals::num::{asin, atan2, cos, radians, sin, tan, wrap_turn};
use morion::internals::trace::RayEnd;

/// By how much facets may turn a ray, radians: a facet error of a pixel near the rim is some half a degree.
const TURN: f64 = 0.012;

/// Distance of the hyperboloid's viewpoint above its rim, mm: the rim is seen 110 degrees from the axis.
fn above_rim() -> f64 {
    -10.0 / tan(radians(110.0))
}

/// Place of the viewpoint in the part's frame, mm.
fn viewpoint(design: &Design) -> DVec3 {
    let rim = design.mounting.pupil_mm.unwrap()[2] - 60.0;
    DVec3::Z * (rim + above_rim())
}

/// Holds the hidden pixels against `wanted`, which gives the numbers of the obstacles that hide a direction; pixels
/// are left out where a direction TURN beside theirs has another answer. Returns how many were hidden and held.
fn held(design: &Design, ends: &[RayEnd], wanted: impl Fn(DVec3) -> Option<u32>) -> usize {
    let view = design.view.as_ref().unwrap();
    let [columns, _] = design.camera.pixels;
    let (mut hidden, mut held, mut open) = (0, 0, 0);
    for (k, end) in ends.iter().enumerate() {
        let (column, row) = (k as u32 % columns, k as u32 / columns);
        let at = design.camera.image_point(f64::from(column) + 0.5, f64::from(row) + 0.5);
        // Near the rim a ray may pass by the facets.
        if at.length() > 10.0 - 2.0 * design.camera.pixel_mm {
            continue;
        }
        // The world is far away: any point of the mirror will do.
        let direction = view.direction_of(at, DVec3::ZERO);
        let across = direction.any_orthonormal_vector();
        let beside = (0..16).map(|k| {
            let turn = radians(22.5) * f64::from(k);
            let aside = across * cos(turn) + direction.cross(across) * sin(turn);
            (direction + TURN * aside).normalize()
        });
        let expected = wanted(direction);
        if beside.into_iter().any(|direction| wanted(direction) != expected) {
            open += 1;
            continue;
        }
        assert_eq!(hidden_by(end), expected, "column {column}, row {row}: {direction}");
        held += 1;
        hidden += usize::from(expected.is_some());
    }
    assert!(open * 5 < held, "{open} pixels are left open beside {held}");
    hidden
}

#[test]
fn a_leg_hides_twice_the_angle_of_its_radius() {
    let (radius, distance) = (1.5, 16.0);
    let turns = [20.0, 140.0, -100.0].map(radians);
    let legs = turns.map(|turn| {
        let [x, y] = [distance * sin(turn), distance * cos(turn)];
        format!(
            "[[obstacle]]\nname = \"leg\"\n[obstacle.cylinder]\nfrom_mm = [{x}, {y}, -30]\n\
             to_mm = [{x}, {y}, 9]\nradius_mm = {radius}\n"
        )
    });
    let (design, ends) = traced(&parsed(&format!("{HYPERBOLIC}{}", legs.concat())));
    let (viewpoint, middle) = (viewpoint(&design), design.mounting.mean_mm);
    let wanted = |direction: DVec3| {
        let (across, azimuth) = (direction.truncate().length(), atan2(direction.x, direction.y));
        (0..3).find(|&leg| {
            let off = wrap_turn(azimuth - turns[leg as usize]);
            if off.abs() >= asin(radius / distance) {
                return false;
            }
            // The ray meets the leg's wall at this distance from the axis, and leaves it at the other.
            let half = (radius * radius - {
                let aside = distance * sin(off);
                aside * aside
            })
            .sqrt();
            let z = [-half, half].map(|half| {
                viewpoint.z + (distance * cos(off) + half) * direction.z / across - middle
            });
            z[0].min(z[1]) < 9.0 && z[0].max(z[1]) > -30.0
        })
    };
    let hidden = held(&design, &ends, wanted);
    assert!(hidden > 1000, "{hidden}");
    // Nothing but the azimuth decides where the leg is tall enough.
    assert!(ends.iter().filter_map(hidden_by).any(|leg| leg == 2));
}

#[test]
fn a_camera_body_hides_what_is_near_the_axis() {
    let text = HYPERBOLIC.replace("distance_mm = 60", "distance_mm = 60, body_mm = [30, 22, 40]");
    let (design, ends) = traced(&parsed(&text));
    let high = 60.0 - above_rim();
    let wanted = |direction: DVec3| {
        let [x, y] = [direction.x, direction.y].map(|along| (along / direction.z * high).abs());
        (direction.z > 0.0 && x < 15.0 && y < 11.0).then_some(0)
    };
    let hidden = held(&design, &ends, wanted);
    assert!(hidden > 300, "{hidden}");
    // No camera ray meets the body that it starts from, so the rim shows the world.
    assert!(ends.iter().filter(|end| hidden_by(end).is_none()).count() > 30_000);
}

/// A plate is in the way of camera rays where their cone is wide, and of reflected ones near the axis.
#[test]
fn a_plate_over_the_mirror_hides_it_and_what_it_shows() {
    let plate = "[[obstacle]]\nbox = { centre_mm = [0, 6, 12], size_mm = [8, 6, 0.001] }\n";
    let (design, ends) = traced(&parsed(&format!("{HYPERBOLIC}{plate}")));
    let middle = design.mounting.mean_mm;
    let below_pupil = design.mounting.pupil_mm.unwrap()[2] - middle - 12.0;
    let over_viewpoint = 12.0 + middle - viewpoint(&design).z;
    let view = design.view.as_ref().unwrap();
    let [columns, _] = design.camera.pixels;
    let (mut before, mut after) = (0, 0);
    for (k, end) in ends.iter().enumerate() {
        let (column, row) = (k as u32 % columns, k as u32 / columns);
        let at = design.camera.image_point(f64::from(column) + 0.5, f64::from(row) + 0.5);
        let direction = view.direction_of(at, DVec3::ZERO);
        let down = at / 60.0 * below_pupil;
        let up = direction.truncate() / direction.z * over_viewpoint;
        // How far inside the plate's edge both pass its height, mm.
        let inside = [down, up].map(|p| (4.0 - p.x.abs()).min(3.0 - (p.y - 6.0).abs()));
        if inside.iter().any(|inside| inside.abs() < 0.2) || at.length() > 9.8 {
            continue;
        }
        let [is_before, is_after] = [inside[0] > 0.0, inside[1] > 0.0 && direction.z > 0.0];
        assert_eq!(hidden_by(end).is_some(), is_before || is_after, "column {column}, row {row}");
        before += usize::from(is_before);
        after += usize::from(is_after);
    }
    assert!(before > 1000 && after > 50, "{before} {after}");
}

#[test]
fn a_tube_hides_a_belt_of_elevations() {
    let tube = "[[obstacle]]\ntube = { from_mm = [0, 0, -4], to_mm = [0, 0, 8], inner_radius_mm = 20, \
                outer_radius_mm = 22 }\n";
    let (design, ends) = traced(&parsed(&format!("{PARABOLIC}{tube}")));
    // The focus: the rim is seen 110 degrees from the axis.
    let rim = DVec2::new(10.0, 0.0);
    let rim = design.mirror.position(rim, &design.mirror.at(rim));
    let focus = rim.z + above_rim() - design.mounting.mean_mm;
    let wanted = |direction: DVec3| {
        let slope = direction.z / direction.truncate().length();
        let [a, b] = [20.0, 22.0].map(|radius| focus + radius * slope);
        (a.min(b) < 8.0 && a.max(b) > -4.0).then_some(0)
    };
    let hidden = held(&design, &ends, wanted);
    assert!(hidden > 5000, "{hidden}");
}

/// Beyond the surface that the picture shows, nothing hides it.
#[test]
fn what_is_behind_the_target_hides_nothing() {
    let leg =
        "[[obstacle]]\ncylinder = { from_mm = [40, 0, -90], to_mm = [40, 0, 90], radius_mm = 3 }\n";
    let hidden = |radius: f64| {
        let law = format!(
            "projection.equiangular = {{ inner_polar_deg = 30, outer_polar_deg = 100, target_radius_mm = {radius} }}"
        );
        let text = HYPERBOLIC
            .replace("projection.hyperbolic.outer_polar_deg = 110", &law)
            .replace("layout.disc = {}", "layout.annulus.inner_width_mm = 4");
        let (_, ends) = traced(&parsed(&format!("{text}{leg}")));
        ends.iter().filter_map(hidden_by).count()
    };
    assert_eq!(hidden(36.9), 0);
    assert!(hidden(43.1) > 300);
}
