//! Layouts: where the image, the panel and the domain of the fit lie in the part.

use super::FailureCause;
use super::strip::{self, StripPanel};
use crate::geom::{DVec2, Outline, Rect};
use crate::mirror::Mirror;
use crate::num::quadrature::gauss_legendre;
use crate::num::{RadialCubic, radians};
use crate::optics::{
    Azimuthal, Camera, Fold, FramedView, ImagingTask, Mount, Projection, RadialLaw, RimConditions,
    SampledMap, StripLaw, Target,
};
use crate::profile::{
    AzimuthalSpec, Layout, MapSpec, PanelSource, Profile, ProjectionSpec, RadialLawSpec,
    RadialSpec, Ridge, StripSpec,
};
use std::sync::Arc;

/// The geometry that a profile fixes before anything is solved, with the reference plane at Z = 0.
#[derive(Debug, Clone)]
pub(super) struct DesignProblem {
    /// The camera.
    pub camera: Camera,
    /// Imaging task of the designed panel.
    pub view: ImagingTask,
    /// The panel to be made, mm; for parallel rays a rectangle's corners are single-precision
    /// numbers, so that the rim of every file is exactly straight.
    pub outline: Outline,
    /// Domain of the fit, mm: the panel, or for `section` the panorama it is cut from.
    pub domain: Outline,
    /// The panel of a `section`, mm, over which the mean of the logarithmic height is zero; of other
    /// strips that is the domain.
    pub section: Option<Rect>,
    /// The part of the picture over which a mirror is fitted that the camera sees obliquely or through a lens with
    /// distortion, or whose picture ends with the frame; of others it is the domain.
    pub picture: Option<Rect>,
    /// Whether problem and panel are symmetric in x and in y.
    pub mirror_symmetric: [bool; 2],
}

/// Geometry of a round mirror that depends on its solution: found by iteration.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct SelfConsistentGeometry {
    /// Image radius of the inner rim, mm.
    pub inner_mm: f64,
    /// Z of the target's origin, mm.
    pub origin_mm: f64,
}

impl SelfConsistentGeometry {
    /// The first guess.
    #[must_use]
    pub(super) fn initial(profile: &Profile) -> Self {
        let inner_mm = match profile.layout {
            Layout::Annulus { inner_width_mm } => 0.5 * inner_width_mm,
            _ => 0.0,
        };
        Self { inner_mm, origin_mm: 0.0 }
    }

    /// The geometry of the mirror that was found: the inner rim has its radius in space, and the
    /// area-mean of the height sits at the target's origin (docs/theory.md, T14).
    #[must_use]
    pub(super) fn updated(
        &self,
        profile: &Profile,
        problem: &DesignProblem,
        mirror: &Mirror,
    ) -> Self {
        let Outline::Ring { inner, outer } = problem.domain else { return *self };
        let wanted = Self::initial(profile).inner_mm;
        let rim =
            mirror.position(DVec2::new(inner, 0.0), &mirror.surface.at(DVec2::new(inner, 0.0)));
        let inner_mm = if wanted == 0.0 { 0.0 } else { wanted * inner / rim.x };
        let far = |projection: &ProjectionSpec| *projection.target() == Target::Infinity;
        if profile.projection.as_ref().is_none_or(far) {
            return Self { inner_mm, ..*self };
        }
        let (nodes, weights) = gauss_legendre(64);
        let (middle, half) = (0.5 * (inner + outer), 0.5 * (outer - inner));
        let (mut sum, mut area) = (0.0, 0.0);
        for (u, w) in nodes.iter().zip(&weights) {
            let r = middle + half * u;
            sum += w * r * mirror.surface.at(DVec2::new(r, 0.0)).f;
            area += w * r;
        }
        Self { inner_mm, origin_mm: problem.camera.chart.point(DVec2::ZERO, sum / area).z }
    }

    /// Both, mm.
    #[must_use]
    pub(super) fn to_array(self) -> [f64; 2] {
        [self.inner_mm, self.origin_mm]
    }

    /// The larger change, mm.
    #[must_use]
    pub(super) fn distance(&self, other: &Self) -> f64 {
        (self.inner_mm - other.inner_mm).abs().max((self.origin_mm - other.origin_mm).abs())
    }
}

impl DesignProblem {
    /// Lays out `profile`, if it has one projection for all of the mirror.
    ///
    /// # Errors
    /// [`FailureCause`] when a law that is to be found cannot be.
    pub(super) fn new(
        profile: &Profile,
        geometry: &SelfConsistentGeometry,
    ) -> Result<Option<Self>, FailureCause> {
        let camera = Camera::new(&profile.camera, &profile.mount, profile.part.width_mm);
        match &profile.projection {
            // Panels are problems of their own.
            None | Some(ProjectionSpec::Panels(_)) => Ok(None),
            Some(ProjectionSpec::Strip(wanted)) => Self::strip(profile, wanted, camera).map(Some),
            Some(ProjectionSpec::Radial(wanted)) => {
                Self::round(profile, wanted, camera, geometry).map(Some)
            }
            Some(ProjectionSpec::Azimuthal(wanted)) => {
                Ok(Some(Self::azimuthal(profile, wanted, camera)))
            }
            Some(ProjectionSpec::Map(wanted)) => Ok(Some(Self::map(profile, wanted, camera))),
        }
    }

    /// Whether the inner rim of a ring comes to lie outside the outer one.
    pub(super) fn occluded_rim(&self) -> Option<FailureCause> {
        match self.domain {
            Outline::Ring { inner, outer } => occluded([inner, outer]),
            Outline::Rect(_) => None,
        }
    }

    /// The problem of a strip or a conquistador.
    fn strip(profile: &Profile, wanted: &StripSpec, camera: Camera) -> Result<Self, FailureCause> {
        let width = profile.part.width_mm;
        let frame_height = camera.pixel_mm * f64::from(camera.pixels[1]);
        let [first, last] = wanted.azimuth_deg;
        let (span, middle_deg) = (radians(last - first), 0.5 * (first + last));

        let StripTiling { across, panels, fill_frame, fold, below, widening } =
            StripTiling::new(profile.layout, span);
        let (scale_mm, target) = (width / across, &wanted.target);
        let azimuth = radians(middle_deg);
        let panel = StripPanel { camera: &camera, target, scale_mm, azimuth, across, below };
        let filling = fill_frame.then_some(frame_height / panels);
        let (law, z) = strip::strip_law(wanted, &panel, filling.map(|height| height / scale_mm))?;
        let z_middle = 0.5 * (z[0] + z[1]);
        let height = filling.unwrap_or((z[1] - z[0]) * scale_mm);
        if fill_frame {
            check_frame_filled(&law, target, z, scale_mm / camera.pixel_mm)?;
        }

        let below = below * height;
        let exact = Rect {
            min: DVec2::new(-0.5 * width, -below),
            max: DVec2::new(0.5 * width, height - below),
        };
        let domain = Rect {
            min: exact.centre() - 0.5 * widening * exact.size(),
            max: exact.centre() + 0.5 * widening * exact.size(),
        };
        let projection = Projection::Strip(crate::optics::Strip {
            law,
            scale_mm,
            azimuth,
            z: z_middle - (0.5 * height - below) / scale_mm,
        });
        // What a distorted picture shows has bent sides; the mirror is the rectangle around it.
        let is_bent = !camera.picture.is_identity();
        let [outline, domain] = if is_bent { [camera.seen_of(exact); 2] } else { [exact, domain] };
        Ok(Self {
            camera,
            view: ImagingTask {
                projection,
                target: target.clone(),
                origin_mm: 0.0,
                fold,
                picture: camera.picture,
            },
            outline: rectangle(&camera, outline),
            domain: Outline::Rect(domain),
            section: (widening != DVec2::ONE).then_some(exact),
            picture: is_bent.then_some(exact),
            // The field is (odd, even) in azimuth about the directions 0 and 180 degrees.
            mirror_symmetric: [
                middle_deg % 180.0 == 0.0 && !is_bent && target.is_symmetric(0),
                false,
            ],
        })
    }

    /// The problem of a disc or an annulus.
    fn round(
        profile: &Profile,
        wanted: &RadialSpec,
        camera: Camera,
        geometry: &SelfConsistentGeometry,
    ) -> Result<Self, FailureCause> {
        let radius = [geometry.inner_mm, 0.5 * profile.part.width_mm];
        let law = match &wanted.law {
            RadialLawSpec::Named(kind) => {
                let inner = wanted.inner_polar_deg.unwrap_or(0.0);
                let psi = [inner, wanted.outer_polar_deg].map(radians);
                RimConditions { radius, psi, vergence: camera.chart.vergence }.law(*kind)
            }
            RadialLawSpec::Table(rows) => tabulated(rows, radius)?,
        };
        let projection = Projection::Radial { law, radius };
        let outline = Outline::Ring { inner: radius[0], outer: radius[1] };
        Ok(Self {
            camera,
            view: ImagingTask {
                projection,
                target: wanted.target.clone(),
                origin_mm: geometry.origin_mm,
                fold: None,
                picture: camera.picture,
            },
            outline,
            domain: outline,
            section: None,
            picture: None,
            mirror_symmetric: [true; 2],
        })
    }

    /// The problem of a perspective or fisheye view on a rectangle: the angle of view is that of the frame's width.
    fn azimuthal(profile: &Profile, wanted: &AzimuthalSpec, camera: Camera) -> Self {
        let area = rectangle_of(profile, &camera);
        let law = wanted.law.to_reach(radians(0.5 * wanted.hfov_deg), camera.half_frame().x);
        let Mount { towards_deg, fold_deg, .. } = profile.mount;
        let centre_deg = wanted.centre_deg.unwrap_or([towards_deg, 90.0 - fold_deg]);
        let view =
            Azimuthal::new(law, centre_deg, wanted.roll_deg, wanted.mirrored, &profile.mount);
        Self::framed(camera, area, FramedView::Azimuthal(view), wanted.target.clone())
    }

    /// The problem of a picture given as data, on a rectangle.
    fn map(profile: &Profile, wanted: &MapSpec, camera: Camera) -> Self {
        let area = rectangle_of(profile, &camera);
        let map = SampledMap::new(&wanted.samples, camera.frame(), camera.image_of(area));
        Self::framed(camera, area, FramedView::Map(Arc::new(map)), wanted.target.clone())
    }

    /// The problem of a picture that ends with the frame, on the rectangle `area`.
    pub(super) fn framed(camera: Camera, area: Rect, view: FramedView, target: Target) -> Self {
        let mirror_symmetric = [0, 1].map(|axis| {
            area.reflected(axis) == area
                && view.is_symmetric(axis)
                && is_symmetric(&camera, &target, axis)
        });
        Self {
            camera,
            mirror_symmetric,
            view: ImagingTask {
                projection: Projection::Framed(view),
                target,
                origin_mm: 0.0,
                fold: None,
                picture: camera.picture,
            },
            outline: rectangle(&camera, area),
            domain: Outline::Rect(area),
            section: None,
            picture: Some(camera.frame()),
        }
    }
}

/// Whether a camera and its target are their own reflections in X = 0 (`axis` 0) or Y = 0 (1).
pub(super) fn is_symmetric(camera: &Camera, target: &Target, axis: usize) -> bool {
    target.is_symmetric(axis) && camera.picture.is_symmetric(axis) && camera.chart.lean[axis] == 0.0
}

/// Failure of an inner rim that comes to lie outside the outer one, both image radii in mm.
fn occluded([inner_mm, outer_mm]: [f64; 2]) -> Option<FailureCause> {
    (!(inner_mm < outer_mm)).then_some(FailureCause::OccludedRim { inner_mm, outer_mm })
}

/// The law through polar angles in degrees at shares of the way between the rims' image radii in mm.
fn tabulated(rows: &[[f64; 2]], radius: [f64; 2]) -> Result<RadialLaw, FailureCause> {
    let [inner, outer] = radius;
    let radii: Vec<f64> = rows.iter().map(|[share, _]| inner + share * (outer - inner)).collect();
    let polar: Vec<f64> = rows.iter().map(|[_, degrees]| radians(*degrees)).collect();
    match RadialCubic::new(&radii, &polar) {
        Some(curve) => Ok(RadialLaw::Tabulated(Arc::new(curve))),
        None => Err(occluded(radius).unwrap_or(FailureCause::DegenerateTable)),
    }
}

/// Tiling of the frame by the panels of a strip or conquistador.
struct StripTiling {
    /// Azimuth across the part's width, radians.
    across: f64,
    /// Number of panels that share the frame's height.
    panels: f64,
    fill_frame: bool,
    fold: Option<Fold>,
    /// Share of the panel's height below the line Y = 0: that is the ridge, or the middle of the rows.
    below: f64,
    /// Size of the domain of the fit in sizes of the panel.
    widening: DVec2,
}

impl StripTiling {
    /// The tiling of a layout that shows `span` radians of azimuth.
    fn new(layout: Layout, span: f64) -> Self {
        let Layout::Conquistador { panel, ridge, fill_frame } = layout else {
            let fill_frame = matches!(layout, Layout::Strip { fill_frame: true });
            let (fold, widening) = (None, DVec2::ONE);
            return Self { across: span, panels: 1.0, fill_frame, fold, below: 0.5, widening };
        };
        let across = 0.5 * span;
        let (fold, below) = match ridge {
            Ridge::Crest => (Some(Fold::Above), 0.0),
            Ridge::Valley => (Some(Fold::Below), 1.0),
        };
        let widening = match panel {
            PanelSource::Section => DVec2::new(span / across, 1.0),
            PanelSource::Refit => DVec2::ONE,
        };
        Self { across, panels: 2.0, fill_frame, fold, below, widening }
    }
}

/// Whether a law that fills the frame, over image coordinates `z` and with `rows` of the frame to
/// each unit of them, shows something everywhere.
///
/// # Errors
/// [`FailureCause::BeyondPole`] or [`FailureCause::BeyondHorizon`] when it does not.
fn check_frame_filled(
    law: &StripLaw,
    target: &Target,
    z: [f64; 2],
    rows: f64,
) -> Result<(), FailureCause> {
    let beyond = z[1].max(-z[0]);
    if let Some(most) = law.pole_coordinate()
        && beyond >= most
    {
        return Err(FailureCause::BeyondPole { beyond, most });
    }
    // Isometric latitude 0.
    let horizon = law.image_coordinate(1.0);
    let past = match target {
        Target::Plane { height_mm } if *height_mm > 0.0 => horizon - z[0],
        Target::Plane { .. } => z[1] - horizon,
        _ => return Ok(()),
    };
    if past >= 0.0 { Err(FailureCause::BeyondHorizon { rows: past * rows }) } else { Ok(()) }
}

/// The rectangle, about the part's axis, of a mirror of that layout: of the profile's own height, or as high for its
/// width as the frame is at the mirror.
pub(super) fn rectangle_of(profile: &Profile, camera: &Camera) -> Rect {
    let height_mm = match profile.layout {
        Layout::Rectangle { height_mm } => height_mm,
        _ => None,
    };
    camera.rectangle(profile.part.width_mm, height_mm)
}

/// A rectangular outline, in single precision where the chart's coordinates are the file's.
fn rectangle(camera: &Camera, exact: Rect) -> Outline {
    Outline::Rect(if camera.chart.is_plan() {
        Rect { min: to_single_precision(exact.min), max: to_single_precision(exact.max) }
    } else {
        exact
    })
}

/// The nearest single-precision numbers.
pub(super) fn to_single_precision(p: DVec2) -> DVec2 {
    p.as_vec2().as_dvec2()
}
