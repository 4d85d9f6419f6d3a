//! The survey of a mirror for a ball cutter: fit, scallops, directions, stock, and what they do to the pixels.

use crate::design::Design;
use crate::geom::{Contour, DVec2, DVec3};
use crate::machining::{
    BallRaster, Extreme, Fillet, Gouge, MachiningError, ScallopFigures, SurfaceAnalysis,
    bounding_corners, plan_outlines,
};
use crate::num::rounding::floor_four_digits;
use crate::num::{degrees, radians};
use crate::profile::{FinishingPath, Profile};
use crate::results::{
    BestFacts, BudgetFacts, CuttingFault, GougeFacts, MachiningReport, ReachFacts, Reason, SCHEMA,
    StockFacts,
};

/// How a mirror is cut: writes `gouge.png`, `machining.json`, `machining.html` and, where the ball fits, `as-cut.stl` into NAME.
/// (A ball that does not fit and a budget that is not kept are negative verdicts.)
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MachiningOptions {
    /// Radius of the ball, mm.
    pub ball_mm: f64,
    /// Distance of the raster's lines in the plan, mm; none for the largest that keeps both budgets.
    pub stepover_mm: Option<f64>,
    /// Their direction from X towards Y, degrees; none for the one that is best for the pixels, or for the
    /// scallops' height where there is no projection.
    pub angle_deg: Option<f64>,
    /// Pixel error that 95 % of the unpolished face may not exceed; none for the largest that a build is
    /// held to.
    pub budget_px: Option<f64>,
    /// Height that no scallop may exceed, um.
    pub scallop_um: Option<f64>,
    /// What the stock stands over the part on its sides and on top, mm.
    pub allowance_mm: f64,
    /// Whether the as-cut part is made.
    pub as_cut: bool,
}

impl Default for MachiningOptions {
    /// A ball of 3 mm, the best direction and stepover, and the as-cut part.
    fn default() -> Self {
        Self {
            ball_mm: 3.0,
            stepover_mm: None,
            angle_deg: None,
            budget_px: None,
            scallop_um: None,
            allowance_mm: 0.0,
            as_cut: true,
        }
    }
}

/// The stepover over the ball's radius at which directions are found where none is asked for.
const FIRST_STEPOVER: f64 = 0.05;

/// The survey's results, and what the as-cut part is made by.
pub(crate) struct CutterSurvey<'a> {
    /// Curvature and slope of the mirror.
    pub analysis: SurfaceAnalysis<'a>,
    /// The lines of the cutter.
    pub raster: BallRaster,
    /// Where the ball does not fit.
    pub gouge: Gouge,
    /// Why the ball does not reach all of the face but a valley, if so.
    pub hollow: Option<CuttingFault>,
    /// Everything but the as-cut part.
    pub found: MachiningReport,
}

impl<'a> CutterSurvey<'a> {
    /// The survey of the mirror of `design`.
    ///
    /// # Errors
    /// [`MachiningError`] when the raster cannot be worked out.
    pub(crate) fn new(
        profile: &Profile,
        design: &'a Design,
        options: &MachiningOptions,
    ) -> Result<Self, MachiningError> {
        Self::of_path(profile, design, options, FinishingPath::Lines)
    }

    /// The same of lines, or of the turns of a spiral, which have no direction.
    ///
    /// # Errors
    /// As [`Self::new`].
    pub(crate) fn of_path(
        profile: &Profile,
        design: &'a Design,
        options: &MachiningOptions,
        path: FinishingPath,
    ) -> Result<Self, MachiningError> {
        let mirror = &design.mirror;
        if !profile.is_one_surface() {
            return Err(MachiningError::Panels);
        }
        if let Some(tool) = &profile.part.forming {
            return Err(MachiningError::Tool { form: tool.form.name() });
        }
        let analysis = analysis_of(design, path);
        let (best, mut raster) = directed(&analysis, options);
        let least_hollow_mm = analysis.least_hollow_mm();
        // But for rounding.
        let tight = least_hollow_mm.filter(|least| options.ball_mm > least.value * (1.0 + 1e-9));
        let hollow = tight.map(|least| DVec3::from_array(least.at_mm).truncate());
        let gouge =
            Gouge::new(mirror, bounding_corners(&plan_outlines(mirror)), options.ball_mm, hollow);
        let budget = budget(profile, design, options, &analysis, &raster);
        if options.stepover_mm.is_none() {
            let ends = [budget.stepover_for_px_mm, budget.stepover_for_scallop_mm];
            let most = ends.into_iter().flatten().reduce(f64::min);
            // (Written down it still keeps them.)
            raster.stepover_mm = most.map_or(raster.stepover_mm, floor_four_digits);
        }
        let scallops = analysis.figures(&raster)?;
        let fillet = Fillet::new(mirror, &design.camera, options.ball_mm);
        let [low, high] = analysis.heights_mm();
        let foot = design.border.as_ref().map_or(0.0, |border| border.top_mm);
        let mut faults = over_budget(scallops.as_ref(), &budget);
        faults.extend(fillet.as_ref().map(|fillet| CuttingFault::Fillet {
            width_mm: fillet.width_max_mm,
            pixels: fillet.pixels,
        }));
        let warnings = unmeasured(design, options, scallops.as_ref());
        let hollow = unreached(&gouge, options.ball_mm, scallops.is_none(), tight);
        faults.extend(hollow.clone());
        let reasons: Vec<Reason> = faults.into_iter().map(Reason::from).collect();
        let found = MachiningReport {
            schema: SCHEMA,
            profile: profile.into(),
            ball_mm: options.ball_mm,
            stepover_mm: raster.stepover_mm,
            angle_deg: degrees(raster.angle),
            steepest_deg: analysis.steepest_deg(),
            least_hollow_mm,
            gouge: gouge_facts(&gouge, fillet.is_none() && scallops.is_some()),
            fillet,
            scallops,
            design_pixel_error_px: design.facts.pixel_error_px,
            best,
            budget,
            reach: ReachFacts { face_mm: high - low, wall_mm: high - foot },
            stock: stock(design, high, options.allowance_mm),
            as_cut: None,
            files: Vec::new(),
            verdict: super::of(&reasons),
            reasons,
            warnings,
        };
        Ok(Self { analysis, raster, gouge, hollow, found })
    }

    /// The result in a few words.
    pub(crate) fn note(&self) -> String {
        self.found.scallops.as_ref().map_or("the ball fits nowhere".to_owned(), |found| {
            format!("scallops of {:.3} um at most", found.scallop_um.value)
        })
    }
}

/// The analysis of a mirror for lines or turns of a cutter.
pub(crate) fn analysis_of(design: &Design, path: FinishingPath) -> SurfaceAnalysis<'_> {
    let analysis = SurfaceAnalysis::new(&design.mirror, &design.camera, design.view.as_ref());
    match path {
        FinishingPath::Lines => analysis,
        FinishingPath::Spiral => analysis.around_axis(),
    }
}

/// The best directions, and the raster in the one asked for or the best to a hundredth of a degree.
pub(crate) fn directed(
    analysis: &SurfaceAnalysis,
    options: &MachiningOptions,
) -> (BestFacts, BallRaster) {
    let ball_mm = options.ball_mm;
    // Directions hardly depend on it.
    let stepover_mm = options.stepover_mm.unwrap_or(FIRST_STEPOVER * ball_mm);
    let raster = BallRaster { ball_mm, stepover_mm, angle: 0.0 };
    let (pixels, height) = (analysis.best_for_pixels(&raster), analysis.best_for_height(&raster));
    let best = (100.0 * pixels.unwrap_or(height).angle_deg).round() / 100.0;
    let angle = radians(options.angle_deg.unwrap_or(best));
    (BestFacts { pixels, height }, BallRaster { angle, ..raster })
}

/// The limits on the unpolished face, and the stepovers that keep them.
fn budget(
    profile: &Profile,
    design: &Design,
    options: &MachiningOptions,
    analysis: &SurfaceAnalysis,
    raster: &BallRaster,
) -> BudgetFacts {
    let view = design.view.as_ref();
    let usual_px = view.map(|_| profile.acceptance_limits().pixel_error_max_px.value);
    let (p95_px, scallop_um) = (options.budget_px.or(usual_px), options.scallop_um);
    BudgetFacts {
        p95_px,
        stepover_for_px_mm: p95_px.and_then(|px| analysis.stepover_for_pixels(raster, px)),
        scallop_um,
        stepover_for_scallop_mm: scallop_um
            .and_then(|um| analysis.stepover_for_height(raster, 1e-3 * um)),
    }
}

fn gouge_facts(gouge: &Gouge, fits: bool) -> GougeFacts {
    GougeFacts {
        fits: gouge.largest.is_none() && fits,
        left_max_um: gouge.largest.map_or(0.0, |most| 1e3 * most.0),
        at_mm: gouge.largest.map(|most| most.1.to_array()),
        share: gouge.share(),
        step_mm: gouge.step,
    }
}

/// Limits that the unpolished face does not keep.
fn over_budget(scallops: Option<&ScallopFigures>, budget: &BudgetFacts) -> Vec<CuttingFault> {
    let over = |found: f64, limit: Option<f64>| limit.filter(|limit| !(found <= *limit));
    let error_px = scallops.and_then(|found| found.pixel_error_px).map(|error| error.p95);
    let error = error_px.and_then(|found_px| {
        let limit_px = over(found_px, budget.p95_px)?;
        let keeps_mm = budget.stepover_for_px_mm;
        Some(CuttingFault::PixelError { found_px, limit_px, keeps_mm })
    });
    let height_um = scallops.map(|found| found.scallop_um.value);
    let height = height_um.and_then(|found_um| {
        let limit_um = over(found_um, budget.scallop_um)?;
        let keeps_mm = budget.stepover_for_scallop_mm;
        Some(CuttingFault::Scallops { found_um, limit_um, keeps_mm })
    });
    error.into_iter().chain(height).collect()
}

/// Warnings of pixel errors that are not known.
fn unmeasured(
    design: &Design,
    options: &MachiningOptions,
    scallops: Option<&ScallopFigures>,
) -> Vec<String> {
    let without = (options.budget_px.is_some() && design.view.is_none())
        .then(|| "without a projection there is no pixel error to hold a budget to".to_owned());
    without.into_iter().chain(scallops.and_then(unseen)).collect()
}

/// The least and the largest X and Y of the box around the part, which it stands over by `allowance_mm`.
pub(crate) fn stock_corners(design: &Design, allowance_mm: f64) -> [DVec2; 2] {
    let around = DVec2::splat(allowance_mm);
    let [lo, hi] = match design.border.as_ref().map(|stock| stock.contour) {
        Some(Contour::Rect { half, .. }) => [-half, half],
        Some(Contour::Circle { radius_mm }) => [-1.0, 1.0].map(|s| DVec2::splat(s * radius_mm)),
        None => bounding_corners(&plan_outlines(&design.mirror)),
    };
    [lo - around, hi + around]
}

/// The box around the part, whose highest place is at `high`.
fn stock(design: &Design, high: f64, allowance_mm: f64) -> StockFacts {
    let [lo, hi] = stock_corners(design, allowance_mm);
    let DVec2 { x, y } = hi - lo;
    let z = high + allowance_mm;
    let (volume_mm3, part_mm3) = (x * y * z, design.volume());
    StockFacts {
        size_mm: [x, y, z],
        allowance_mm,
        volume_mm3,
        part_mm3,
        removed_mm3: volume_mm3 - part_mm3,
    }
}

/// Why the ball, mm, does not reach all of the face but a valley, if so; it fits `nowhere`, or the ground is
/// hollow with a smaller radius where it is `tight`.
fn unreached(
    gouge: &Gouge,
    ball_mm: f64,
    nowhere: bool,
    tight: Option<Extreme>,
) -> Option<CuttingFault> {
    let Some((left_mm, at)) = gouge.largest_outside_fillet else {
        return nowhere.then_some(CuttingFault::NoPlace { ball_mm });
    };
    let at_mm = tight.map_or(at.to_array(), |least| [least.at_mm[0], least.at_mm[1]]);
    let hollow_mm = tight.map(|least| least.value);
    let share = gouge.share();
    Some(CuttingFault::Unreached { ball_mm, nowhere, at_mm, hollow_mm, left_mm, share })
}

/// What the pixels' figures leave out.
fn unseen(figures: &ScallopFigures) -> Option<String> {
    let ScallopFigures { pixels, pixels_unbounded, .. } = *figures;
    if pixels == 0 {
        return Some(
            "no pixel sees the mirror where the ball fits: nothing is known of pixels".to_owned(),
        );
    }
    (pixels_unbounded > 0).then(|| {
        format!(
            "{pixels_unbounded} of the {pixels} pixels looked at are moved by no finite number of pixels, and left \
             out of the pixel error"
        )
    })
}
