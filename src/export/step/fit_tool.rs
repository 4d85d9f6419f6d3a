//! Splines of a forming tool's face, from those of the surface beside the mirror.

use super::FitError;
use super::b_spline::BSplineSurface;
use super::fit::{FittedFaces, FittedMirror, fit_bicubic, fit_revolved};
use super::knots::written_digits;
use super::parametric_surface::ParametricSurface;
use super::wall_foot::WallFoot;
use crate::forming::FormingTool;
use crate::geom::DVec3;
use crate::mirror::Mirror;

/// Fits splines to the face of `tool` for `mirror`, to 2 nm or better.
///
/// # Errors
/// [`FitError`] when no reasonable number of knots suffices, or a round tool's face is not round.
pub fn fit_tool(mirror: &Mirror, tool: &FormingTool) -> Result<FittedMirror, FitError> {
    let surface = ParametricSurface::new(mirror)?.beside(tool.spec.offset_mm())?;
    let (faces, error_mm) = match surface.ring {
        None => {
            let (net, error_mm) = fit_bicubic(&surface, mirror.folded)?;
            let net = in_tool(&net, tool);
            (FittedFaces::Panel { net, straight: false, folded: mirror.folded }, error_mm)
        }
        Some(ring) if surface.is_round() => {
            let FittedMirror { faces, error_mm, .. } = fit_revolved(&surface, ring)?;
            (revolved_in_tool(faces, tool), error_mm)
        }
        Some(_) => return Err(FitError::RoundTool),
    };
    let foot = WallFoot::Drafted(tool.slant());
    Ok(FittedMirror { faces, error_mm: error_mm * tool.spec.growth(), foot })
}

fn written(p: DVec3) -> DVec3 {
    DVec3::from_array(p.to_array().map(written_digits))
}

/// The net in the tool's frame: that of a mould, which is turned, runs the other way along v, so that its normal looks up.
fn in_tool(net: &BSplineSurface, tool: &FormingTool) -> BSplineSurface {
    let [u, v] = &net.axes;
    let placed = |p: &DVec3| written(tool.from_part(*p));
    if !tool.is_hollow() {
        let points = net.points.iter().map(placed).collect();
        return BSplineSurface { axes: net.axes.clone(), points };
    }
    let row = |i: usize| net.control_row(i).iter().rev().map(placed);
    let points = (0..u.count()).flat_map(row).collect();
    BSplineSurface { axes: [u.clone(), v.reversed()], points }
}

fn revolved_in_tool(faces: FittedFaces, tool: &FormingTool) -> FittedFaces {
    match faces {
        FittedFaces::Revolved { radius, points } => {
            let points = points.into_iter().map(|p| written(tool.from_part(p))).collect();
            FittedFaces::Revolved { radius, points }
        }
        other => other,
    }
}
