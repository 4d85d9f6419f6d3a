//! Azimuthal projections about any direction: perspective and fisheye views.
//!
//! A view is an axisymmetric law about a centre direction c in the place of the axis. The law gives a direction
//! about the axis; the rotation that carries the axis to c on the shortest way is a Moebius map of stereographic
//! coordinates, s -> (s + c) / (1 - conj(c) s) (docs/theory.md, T98): half a turn about the axis and one about the normal of a flat
//! mirror that shows c ([`stereographic::reflect`]). The view is therefore the one that a camera with that angle
//! of view has in a flat mirror, and a flat mirror is the exact one where the angle is the camera's own.

use super::picture_map::sine_and_cosine;
use super::{Mount, RadialLaw, RadialLawKind, RimConditions};
use crate::geom::DVec2;
use crate::num::{Scalar, atan, atan2, degrees, radians, tan};

/// How the distance from a view's centre grows with the angle from its centre direction.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum AzimuthalLaw {
    /// As the tangent: straight lines of the world are straight.
    Perspective,
    /// As the angle itself.
    Equidistant,
    /// As the sine of half the angle: equal solid angles have equal areas.
    Equisolid,
    /// As the tangent of half the angle: small shapes are kept.
    Stereographic,
}

impl AzimuthalLaw {
    /// The law that reaches the angle `half_angle` (radians) at the distance `half_mm`.
    #[must_use]
    pub fn to_reach(self, half_angle: f64, half_mm: f64) -> RadialLaw {
        let kind = match self {
            Self::Perspective => RadialLawKind::Plane,
            Self::Equidistant => RadialLawKind::Equiangular,
            Self::Equisolid => RadialLawKind::EquiAreal,
            Self::Stereographic => RadialLawKind::Parabolic,
        };
        RimConditions { radius: [0.0, half_mm], psi: [0.0, half_angle], vergence: 0.0 }.law(kind)
    }
}

/// A round law about a centre direction, over image points in mm.
#[derive(Debug, Clone, PartialEq)]
pub struct Azimuthal {
    /// The law of the distance from the picture's centre.
    pub law: RadialLaw,
    /// The rotation from directions about the axis to those about the centre, in the part's frame: the complex
    /// numbers a and b of the map s -> (a s + b) / (conj(a) - conj(b) s) of stereographic coordinates.
    rotation: [DVec2; 2],
    /// Cosine and sine of the picture's turn, and -1 where left and right are exchanged.
    turn: [f64; 3],
    /// Image point of the centre, mm.
    middle: DVec2,
}

impl Azimuthal {
    /// The view by `law` whose centre lies at an azimuth and an elevation in degrees about the axis of the camera,
    /// turned by `roll_deg` in its own picture (clockwise), mirrored as in a flat mirror or with left and right as
    /// they are, of a camera on a mount.
    #[must_use]
    pub fn new(
        law: RadialLaw,
        centre_deg: [f64; 2],
        roll_deg: f64,
        mirrored: bool,
        mount: &Mount,
    ) -> Self {
        let [azimuth, elevation] = centre_deg;
        let [s, c] = sine_and_cosine(azimuth);
        let centre = DVec2::new(s, c) * tan(radians(0.5 * (90.0 - elevation)));
        // The camera's axis in the part's frame.
        let axis = mount.towards() * -tan(radians(0.25 * mount.fold_deg));
        let [roll_s, roll_c] = sine_and_cosine(roll_deg);
        let side = if mirrored { 1.0 } else { -1.0 };
        // (1 s + axis) / (1 - conj(axis) s) after the same for the centre.
        let a = DVec2::X - complex_product(axis, conjugate(centre));
        Self {
            law,
            rotation: [a, centre + axis],
            turn: [roll_c, roll_s, side],
            middle: DVec2::ZERO,
        }
    }

    /// The same view with its centre at another image point, mm.
    #[must_use]
    pub fn about(self, middle: DVec2) -> Self {
        Self { middle, ..self }
    }

    /// Azimuth and elevation of the centre in the part's frame, degrees.
    #[must_use]
    pub fn centre_deg(&self) -> [f64; 2] {
        let [x, y] = self.direction_of(self.middle.to_array());
        let radius = (x * x + y * y).sqrt();
        [degrees(atan2(x, y)), 90.0 - 2.0 * degrees(atan(radius))]
    }

    /// The view with picture and world reflected in X = 0 (`axis` 0) or Y = 0 (1).
    #[must_use]
    pub fn reflected(&self, axis: usize) -> Self {
        let across = |mut place: DVec2| {
            place[axis] = -place[axis];
            place
        };
        let ([a, b], [c, s, side]) = (self.rotation, self.turn);
        Self {
            rotation: [conjugate(a), across(b)],
            turn: [c, -s, side],
            middle: across(self.middle),
            ..self.clone()
        }
    }

    /// Whether reflecting the picture in X = 0 (`axis` 0) or Y = 0 (1) reflects the world.
    #[must_use]
    pub fn is_symmetric(&self, axis: usize) -> bool {
        self.reflected(axis) == *self
    }

    /// Direction that image point `q` must see, as a stereographic coordinate.
    #[inline]
    pub fn direction_of<S: Scalar>(&self, q: [S; 2]) -> [S; 2] {
        let [c, s, side] = self.turn;
        let q = [q[0] - self.middle.x, q[1] - self.middle.y];
        let turned = [(q[0] * c - q[1] * s) * side, q[0] * s + q[1] * c];
        let [a, b] = self.rotation;
        moebius([a, b], self.law.direction_of(turned))
    }

    /// The image point that must see `sigma`.
    #[inline]
    pub fn image_of<S: Scalar>(&self, sigma: [S; 2]) -> [S; 2] {
        let [c, s, side] = self.turn;
        let [a, b] = self.rotation;
        let [x, y] = self.law.image_of(moebius([conjugate(a), -b], sigma));
        let x = x * side;
        [x * c + y * s + self.middle.x, y * c - x * s + self.middle.y]
    }

    /// Radians of the world to a millimetre of the image, at the centre.
    #[must_use]
    pub fn radians_per_mm(&self) -> f64 {
        // So small a radius that every law is linear there.
        const SMALL_MM: f64 = 1e-6;
        self.law.polar(SMALL_MM) / SMALL_MM
    }
}

fn conjugate(a: DVec2) -> DVec2 {
    DVec2::new(a.x, -a.y)
}

fn complex_product(a: DVec2, b: DVec2) -> DVec2 {
    DVec2::new(a.x * b.x - a.y * b.y, a.x * b.y + a.y * b.x)
}

/// (a s + b) / (conj(a) - conj(b) s): a rotation of directions.
#[inline]
fn moebius<S: Scalar>([a, b]: [DVec2; 2], s: [S; 2]) -> [S; 2] {
    let above = [s[0] * a.x - s[1] * a.y + b.x, s[0] * a.y + s[1] * a.x + b.y];
    let below = [-(s[0] * b.x + s[1] * b.y) + a.x, s[0] * b.y - s[1] * b.x - a.y];
    let size = below[0].square() + below[1].square();
    [
        (above[0] * below[0] + above[1] * below[1]) / size,
        (above[1] * below[0] - above[0] * below[1]) / size,
    ]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geom::DVec3;
    use crate::num::{cos, sin};
    use crate::optics::{Camera, CameraModel, reflect, stereographic};
    use AzimuthalLaw::{Equidistant, Equisolid, Perspective, Stereographic};

    fn law(law: AzimuthalLaw, half_deg: f64) -> RadialLaw {
        law.to_reach(radians(half_deg), 30.0)
    }

    fn views() -> impl Iterator<Item = (AzimuthalLaw, Azimuthal)> {
        [Perspective, Equidistant, Equisolid, Stereographic].into_iter().flat_map(|kind| {
            [[0.0, 90.0], [90.0, 30.0], [-37.0, 12.0], [180.0, -50.0]].into_iter().flat_map(
                move |centre| {
                    [(0.0, true), (25.0, true), (-70.0, false)].map(|(roll, mirrored)| {
                        (
                            kind,
                            Azimuthal::new(
                                law(kind, 40.0),
                                centre,
                                roll,
                                mirrored,
                                &Mount::default(),
                            ),
                        )
                    })
                },
            )
        })
    }

    #[test]
    fn image_points_are_found_again() {
        for (kind, view) in views() {
            for (x, y) in [(0.0, 0.0), (30.0, -4.0), (-11.0, 19.5), (3.0, 20.0)] {
                let back = DVec2::from_array(view.image_of(view.direction_of([x, y])));
                let off = (back - DVec2::new(x, y)).length();
                assert!(off < 1e-12, "{kind:?} {view:?} {off:e}");
            }
        }
    }

    #[test]
    fn angles_from_the_centre_follow_the_law() {
        for (kind, view) in views() {
            let [azimuth, elevation] = view.centre_deg().map(radians);
            let centre = DVec3::new(
                cos(elevation) * sin(azimuth),
                cos(elevation) * cos(azimuth),
                sin(elevation),
            );
            let middle = stereographic::direction(view.direction_of([0.0; 2]));
            assert!((middle - centre).length() < 1e-14, "{view:?}");
            for q in [DVec2::new(30.0, 0.0), DVec2::new(-6.0, 17.0)] {
                let seen = stereographic::direction(view.direction_of(q.to_array()));
                let angle = crate::geom::angle(seen, centre);
                assert!((angle - view.law.polar(q.length())).abs() < 1e-13, "{kind:?} {angle}");
            }
        }
    }

    /// A flat mirror of the right slope shows a perspective view of the camera's own angle.
    #[test]
    fn a_flat_mirror_shows_the_perspective_view_of_its_camera() {
        let vergence = 1.0 / 140.0;
        let half_deg = degrees(atan(30.0 * vergence));
        for centre in [[0.0, 90.0], [90.0, 30.0], [-37.0, 12.0], [180.0, -50.0]] {
            let view =
                Azimuthal::new(law(Perspective, half_deg), centre, 0.0, true, &Mount::default());
            let c = stereographic::direction(view.direction_of([0.0; 2]));
            let normal = (c + DVec3::Z).normalize();
            for q in [DVec2::ZERO, DVec2::new(30.0, 11.0), DVec2::new(-8.0, 20.0)] {
                let ray = (q * vergence).extend(-1.0).normalize();
                let seen = stereographic::direction(view.direction_of(q.to_array()));
                assert!((reflect(ray, normal) - seen).length() < 1e-14, "{centre:?} {q}");
            }
        }
    }

    /// The same from a camera beside the part: whatever the mount, a flat part shows the middle of the view that
    /// the fold names, and all of it where the angle of view is the camera's own.
    #[test]
    fn a_flat_part_shows_the_view_of_its_mount() {
        let model =
            CameraModel::Pinhole { pixels: [640, 480], focal_px: 900.0, distance_mm: 140.0 };
        for (fold_deg, towards_deg) in [(60.0, 90.0), (60.0, 0.0), (-35.0, 70.0), (110.0, 200.0)] {
            let mount = Mount { fold_deg, towards_deg, shift_mm: [0.0; 2] };
            let camera = Camera::new(&model, &mount, 60.0);
            let half_deg = degrees(atan(30.0 / 140.0));
            let centre = [towards_deg, 90.0 - fold_deg];
            let view = Azimuthal::new(law(Perspective, half_deg), centre, 0.0, true, &mount);
            for image in [DVec2::ZERO, DVec2::new(30.0, 11.0), DVec2::new(-8.0, 20.0)] {
                let ray = camera.ray(image, 0.0).direction;
                let seen = stereographic::direction(view.direction_of(image.to_array()));
                assert!((reflect(ray, DVec3::Z) - seen).length() < 1e-14, "{mount:?} {image}");
            }
        }
    }

    #[test]
    fn a_perspective_view_keeps_lines_straight_and_an_unmirrored_one_is_its_reflection() {
        let plane = law(Perspective, 40.0);
        let view = Azimuthal::new(plane.clone(), [90.0, 30.0], 0.0, true, &Mount::default());
        let other = Azimuthal::new(plane, [90.0, 30.0], 0.0, false, &Mount::default());
        // Directions to points of a line in space.
        let on_line = |t: f64| DVec3::new(3.0, -1.0, 1.0) + DVec3::new(-0.2, 0.9, 0.4) * t;
        let image = |view: &Azimuthal, t: f64| {
            let sigma = stereographic::sigma(on_line(t).to_array());
            DVec2::from_array(view.image_of(sigma))
        };
        let [a, b, c] = [-0.5, 0.3, 1.0].map(|t| image(&view, t));
        assert!((b - a).perp_dot(c - a).abs() < 1e-12 * (c - a).length_squared());
        let flipped = image(&other, 0.3);
        assert!((flipped - b * DVec2::new(-1.0, 1.0)).length() < 1e-13);
    }

    #[test]
    fn symmetry_is_exact_for_upright_views_above_and_below() {
        let plane = law(Perspective, 40.0);
        for (centre, roll, symmetric) in [
            ([0.0, 40.0], 0.0, [true, false]),
            ([180.0, 40.0], 0.0, [true, false]),
            ([-180.0, 40.0], 360.0, [true, false]),
            ([90.0, 40.0], 0.0, [false, true]),
            ([0.0, 40.0], 5.0, [false; 2]),
            ([30.0, 40.0], 0.0, [false; 2]),
            ([0.0, 90.0], 0.0, [true; 2]),
            ([30.0, 90.0], 180.0, [true; 2]),
            ([0.0, 90.0], 5.0, [false; 2]),
        ] {
            let view = Azimuthal::new(plane.clone(), centre, roll, true, &Mount::default());
            assert_eq!([0, 1].map(|axis| view.is_symmetric(axis)), symmetric, "{centre:?} {roll}");
            let [x, y] = view.direction_of([7.0, 3.0]);
            if symmetric[0] {
                assert_eq!(view.direction_of([-7.0, 3.0]), [-x, y]);
            }
            if symmetric[1] {
                assert_eq!(view.direction_of([7.0, -3.0]), [x, -y]);
            }
        }
    }
}
