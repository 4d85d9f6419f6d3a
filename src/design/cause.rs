//! Failure causes of a design: the quantity that has no value, and the place on the mirror.

use super::least_curl_law::LeastCurlError;
use super::solve::SolveError;
use crate::geom::{Chart, DVec2, DVec3};
use crate::num::{asin, atan2, degrees};
use crate::optics::{ImagingTask, Target, stereographic};
use thiserror::Error;

/// Failure at one place of a mirror: a quantity has no value there.
#[derive(Debug, Clone, Copy, PartialEq, Error)]
pub enum LocalFailure {
    /// The law ends before this row or radius.
    #[error("the projection's law has no direction: it ends before")]
    LawUndefined,
    /// The direction that the picture should show does not meet the target plane.
    #[error(
        "the picture should show elevation {elevation_deg:.4} degrees, which never meets the target \
         plane"
    )]
    WantedMissesPlane {
        /// The elevation, degrees.
        elevation_deg: f64,
    },
    /// The direction that the mirror shows does not meet the target plane.
    #[error(
        "the mirror shows elevation {elevation_deg:.4} degrees, which never meets the target plane"
    )]
    SeenMissesPlane {
        /// The elevation, degrees.
        elevation_deg: f64,
    },
    /// The target plane lies before the mirror.
    #[error("the mirror reaches {by_mm:.4} mm past the target plane")]
    PastPlane {
        /// By how much, mm.
        by_mm: f64,
    },
    /// The target cylinder is too narrow for the mirror.
    #[error("the mirror reaches {by_mm:.4} mm out of the target cylinder")]
    OutsideCylinder {
        /// By how much, mm.
        by_mm: f64,
    },
    /// The direction that the picture should show does not meet the target surface.
    #[error(
        "the picture should show azimuth {:.4}, elevation {:.4} degrees from the viewpoint, which never meets the \
         target surface", angles_deg[0], angles_deg[1]
    )]
    WantedMissesTarget {
        /// Azimuth and elevation, degrees.
        angles_deg: [f64; 2],
    },
    /// The direction that the mirror shows does not meet the target surface.
    #[error(
        "the mirror shows azimuth {:.4}, elevation {:.4} degrees, which never meets the target surface",
        angles_deg[0], angles_deg[1]
    )]
    SeenMissesTarget {
        /// Azimuth and elevation, degrees.
        angles_deg: [f64; 2],
    },
    /// The target surface lies before the mirror.
    #[error("the mirror reaches through the target surface")]
    ThroughTarget,
    /// The direction that the mirror shows has no place in the picture.
    #[error(
        "the mirror shows elevation {elevation_deg:.4} degrees, which the projection's law puts nowhere"
    )]
    NotInImage {
        /// The elevation, degrees.
        elevation_deg: f64,
    },
    /// The direction that the mirror shows has no azimuth.
    #[error("the mirror looks straight along its axis, where azimuth has no value")]
    NoAzimuth,
    /// Its slope is not a number.
    #[error("the mirror stands upright")]
    Vertical,
}

impl LocalFailure {
    /// Failure at the chart coordinates `q`, where the mirror has the point `at` and the slope `slope`
    /// (Z_X, Z_Y); none where nothing is.
    pub fn at(
        chart: &Chart,
        view: &ImagingTask,
        q: DVec2,
        at: DVec3,
        slope: [f64; 2],
    ) -> Option<Self> {
        let finite = |v: [f64; 2]| v.iter().all(|x| x.is_finite());
        if !(at.is_finite() && finite(slope)) {
            return Some(Self::Vertical);
        }
        let image = view.picture.image_point(q);
        let wanted = view.projection.direction_of(image.to_array());
        if !finite(wanted) {
            return Some(Self::LawUndefined);
        }
        let from = at - DVec3::Z * view.origin_mm;
        let camera = stereographic::towards_camera(chart.view(at.to_array()));
        let seen = stereographic::reflect(camera, slope);
        let elevation = |z: f64| degrees(asin(z.clamp(-1.0, 1.0)));
        let up = |sigma| stereographic::direction(sigma).z;
        let angles_deg = |sigma| {
            let d = stereographic::direction(sigma);
            [degrees(atan2(d.x, d.y)), elevation(d.z)]
        };
        match &view.target {
            Target::Infinity => {}
            Target::Posed(target) => {
                if target.reach_mm(stereographic::direction(wanted)).is_nan() {
                    return Some(Self::WantedMissesTarget { angles_deg: angles_deg(wanted) });
                }
                if !target.is_before(from) {
                    return Some(Self::ThroughTarget);
                }
                if finite(seen) && !finite(target.direction_from_origin(from.to_array(), seen)) {
                    return Some(Self::SeenMissesTarget { angles_deg: angles_deg(seen) });
                }
            }
            &Target::Cylinder { radius_mm } => {
                let by_mm = from.truncate().length() - radius_mm;
                if !(by_mm < 0.0) {
                    return Some(Self::OutsideCylinder { by_mm });
                }
            }
            &Target::Plane { height_mm } => {
                let side = height_mm.signum();
                if !(side * up(wanted) > 0.0) {
                    return Some(Self::WantedMissesPlane { elevation_deg: elevation(up(wanted)) });
                }
                let by_mm = side * from.z - height_mm.abs();
                if !(by_mm < 0.0) {
                    return Some(Self::PastPlane { by_mm });
                }
                if finite(seen) && !(side * up(seen) > 0.0) {
                    return Some(Self::SeenMissesPlane { elevation_deg: elevation(up(seen)) });
                }
            }
        }
        let content = view.image_of_seen(chart, at.to_array(), slope, image);
        let shown = DVec3::from_array(stereographic::unit(
            view.target.direction_from_origin(from.to_array(), seen),
        ));
        (!finite(content)).then_some(Self::NotInImage { elevation_deg: elevation(shown.z) })
    }

    /// Failure where the residual has no derivative.
    pub fn of_slopes(chart: &Chart, at: DVec3, slope: [f64; 2]) -> Option<Self> {
        let seen =
            stereographic::reflect(stereographic::towards_camera(chart.view(at.to_array())), slope);
        (seen == [0.0; 2]).then_some(Self::NoAzimuth)
    }
}

/// Stage of the design at which a fit stopped.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum FitStage {
    /// The vector field, from which all methods start.
    Field,
    /// Another method's least squares.
    Method,
    /// The smallest worst error.
    Minimax,
}

impl FitStage {
    fn name(self) -> &'static str {
        match self {
            Self::Field => "the vector field's fit",
            Self::Method => "the method's own fit",
            Self::Minimax => "the minimax fit",
        }
    }
}

/// Reason why there is no mirror.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum FailureCause {
    /// A quantity that has no value at a place.
    #[error("at X {:.4} mm, Y {:.4} mm {}{failure}", at.x, at.y, tried(*stage))]
    At {
        /// X and Y of the place, mm.
        at: DVec2,
        /// The failure there.
        failure: LocalFailure,
        /// The fit that fails for it; none for the mirror that is the answer.
        stage: Option<FitStage>,
    },
    /// The fit has no unique answer, or was not found.
    #[error("{} of degree {degree} has no answer: {source}", stage.name())]
    Fit {
        /// Degree asked for.
        degree: usize,
        /// The fit that failed.
        stage: FitStage,
        /// The solver's account.
        source: SolveError,
    },
    /// The law of least curl was not found.
    #[error("the law of least curl was not found: {0}")]
    LeastCurl(#[from] LeastCurlError),
    /// Places or angles of a table differ by no more than rounding.
    #[error("the entries of the table are too close to each other")]
    DegenerateTable,
    /// The place of the mirror in its target surface was not found.
    #[error(
        "the place of the mirror before its target did not settle in {rounds} rounds (the last \
         moved it by {})",
        super::by(*last_step_mm, " mm")
    )]
    NotSelfConsistent {
        /// Rounds of solving and placing.
        rounds: usize,
        /// Last change, mm.
        last_step_mm: f64,
    },
    /// The pinhole would see the inner rim outside the outer one.
    #[error(
        "the mirror rises so near to the pinhole that the inner rim, {inner_mm:.4} mm from the axis in \
         the image, would hide the outer one, {outer_mm:.4} mm from it"
    )]
    OccludedRim {
        /// Image radius of the inner rim, mm on the reference plane.
        inner_mm: f64,
        /// Image radius of the outer rim, mm.
        outer_mm: f64,
    },
    /// The mirror would have to turn its back to the camera.
    #[error("the mirror turns its back to the camera {from_axis_mm:.3} mm from the axis")]
    BackFacing {
        /// X and Y of the place, mm.
        from_axis_mm: f64,
    },
    /// Filling the frame asks for elevations that there are not.
    #[error(
        "filling the frame takes the law beyond +-90 degrees of elevation, to {beyond:.3} of its \
         image coordinate where {most:.3} is the pole"
    )]
    BeyondPole {
        /// Image coordinate at the rim, paper's units.
        beyond: f64,
        /// Image coordinate of the pole.
        most: f64,
    },
    /// Filling the frame takes the law to directions that never meet the target plane.
    #[error(
        "filling the frame takes the law {rows:.1} rows past the horizon, where no direction meets \
         the target plane"
    )]
    BeyondHorizon {
        /// Rows of the frame past the horizon.
        rows: f64,
    },
    /// The target has nothing where a pixel should see it.
    #[error(
        "pixel ({}, {}) should show azimuth {:.4}, elevation {:.4} degrees from the viewpoint, where [target.mesh] has no \
         facet; {share_percent:.2} % of the frame's pixels miss it (extend the mesh, or give directions as data that leave them out as NaN)", pixel[0], pixel[1], angles_deg[0], angles_deg[1]
    )]
    MissedTarget {
        /// Column and row, from 0.
        pixel: [usize; 2],
        /// Azimuth and elevation, degrees.
        angles_deg: [f64; 2],
        /// How many do, percent.
        share_percent: f64,
    },
    /// The target jumps in depth by more than a mirror without steps can follow.
    #[error(
        "[target.mesh] jumps in depth beside pixel ({}, {}), by {jump_px:.1} pixels as seen from the mirror: any mirror is off \
         by half of that on one side, more than pixel_error_max_px = {most_px} (show another part of it, or accept more)", pixel[0], pixel[1]
    )]
    DepthJump {
        /// Column and row, from 0.
        pixel: [usize; 2],
        /// Jump of what is wanted, pixels.
        jump_px: f64,
        /// Largest error that is accepted, pixels.
        most_px: f64,
    },
    /// The numbers leave the range of double precision.
    #[error("the mirror's {what} is not finite")]
    NotFinite {
        /// The quantity.
        what: &'static str,
    },
}

/// Words that name the fit of a failure.
fn tried(stage: Option<FitStage>) -> String {
    stage.map_or(String::new(), |stage| format!("{} does not get on: ", stage.name()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::num::{atan, radians};
    use crate::optics::{PictureMap, Projection, Strip, StripLaw};

    fn view(law: StripLaw, target: Target) -> ImagingTask {
        let strip = Strip { law, scale_mm: 1.0, azimuth: 0.0, z: 0.0 };
        ImagingTask {
            projection: Projection::Strip(strip),
            target,
            origin_mm: 0.0,
            fold: None,
            picture: PictureMap::default(),
        }
    }

    /// The failure of a mirror under parallel rays.
    fn failure(
        view: &ImagingTask,
        q: [f64; 2],
        at: [f64; 3],
        slope: [f64; 2],
    ) -> Option<LocalFailure> {
        let chart = Chart::on_axis(0.0, 0.0);
        LocalFailure::at(&chart, view, DVec2::from_array(q), DVec3::from_array(at), slope)
    }

    #[test]
    fn each_failure_is_told_from_the_others() {
        let far = view(StripLaw::EqualArea, Target::Infinity);
        let lean = [0.0, 0.5];
        assert_eq!(failure(&far, [0.0, 0.5], [0.0; 3], lean), None);
        assert_eq!(failure(&far, [0.0, 1.5], [0.0; 3], lean), Some(LocalFailure::LawUndefined));
        let upright = failure(&far, [0.0, 0.5], [0.0; 3], [f64::INFINITY, 0.0]);
        assert_eq!(upright, Some(LocalFailure::Vertical));
        let round = view(StripLaw::EqualArea, Target::Cylinder { radius_mm: 10.0 });
        let outside = failure(&round, [0.0, 0.5], [0.0, 11.0, 0.0], lean);
        assert_eq!(outside, Some(LocalFailure::OutsideCylinder { by_mm: 1.0 }));
        let below = view(StripLaw::EqualArea, Target::Plane { height_mm: -50.0 });
        let past = failure(&below, [0.0, -0.5], [0.0, 0.0, -53.0], lean);
        assert_eq!(past, Some(LocalFailure::PastPlane { by_mm: 3.0 }));
        let cylindrical = view(StripLaw::Cylindrical, Target::Infinity);
        let nowhere = failure(&cylindrical, [0.0, 0.5], [0.0; 3], [0.0; 2]);
        assert_eq!(nowhere, Some(LocalFailure::NotInImage { elevation_deg: 90.0 }));
    }

    #[test]
    fn elevations_that_miss_a_plane_are_told() {
        let below = view(StripLaw::EqualArea, Target::Plane { height_mm: -50.0 });
        // This law's coordinate is the sine of the elevation.
        let Some(LocalFailure::WantedMissesPlane { elevation_deg }) =
            failure(&below, [0.0, 0.5], [0.0; 3], [0.0, 2.0])
        else {
            panic!("a picture of what is above the horizon");
        };
        assert!((elevation_deg - 30.0).abs() < 1e-12, "{elevation_deg}");
        let Some(LocalFailure::SeenMissesPlane { elevation_deg }) =
            failure(&below, [0.0, -0.5], [0.0; 3], [0.0, 0.1])
        else {
            panic!("a mirror that looks up");
        };
        // A mirror turns a ray by twice its own angle.
        assert!((radians(elevation_deg) + 2.0 * atan(0.1) - radians(90.0)).abs() < 1e-12);
    }

    #[test]
    fn azimuth_has_no_value_along_the_axis() {
        let chart = Chart::on_axis(0.0, 0.0);
        assert_eq!(
            LocalFailure::of_slopes(&chart, DVec3::ZERO, [0.0; 2]),
            Some(LocalFailure::NoAzimuth)
        );
        assert_eq!(LocalFailure::of_slopes(&chart, DVec3::ZERO, [0.0, 0.5]), None);
    }
}
