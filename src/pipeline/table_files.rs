//! Files of look-up tables.

use crate::lookup::{BilinearField, CameraInfo, NodeTable, PlaceMap, Pole, c_header, camera_info};
use crate::optics::{CameraModel, Distortion};
use crate::profile::Profile;

/// A file: its name, its format and its bytes.
pub(super) type TableFile = (String, &'static str, Vec<u8>);

/// What the files hold.
pub(super) struct TableFiles {
    /// Numbers at the nodes.
    pub rows: NodeTable,
    /// Pole of the directions.
    pub pole: Pole,
    /// Directions.
    pub directions: BilinearField,
    /// Places of the floor, and the map of its plan.
    pub floor: Option<(BilinearField, PlaceMap)>,
    /// The map of the panorama.
    pub panorama: PlaceMap,
}

impl TableFiles {
    /// The files, and the bytes of the tables in the header.
    pub(super) fn encoded(
        &self,
        profile: &Profile,
        comments: &[String],
    ) -> (Vec<TableFile>, usize) {
        let floor = self.floor.as_ref().map(|(field, _)| field);
        let (header, bytes) = c_header(comments, (&self.directions, self.pole.sign()), floor);
        let mut files: Vec<TableFile> = vec![
            ("table.npy".into(), "npy", self.rows.npy()),
            ("table.csv".into(), "csv", self.rows.csv().into_bytes()),
            ("table.h".into(), "h", header.into_bytes()),
        ];
        let plan = self.floor.as_ref().map(|(_, plan)| ("floor", plan));
        for (name, map) in [("panorama", &self.panorama)].into_iter().chain(plan) {
            let [x, y] = map.pgm();
            files.push((format!("{name}-map.npy"), "npy", map.npy()));
            files.push((format!("{name}-x.pgm"), "pgm", x));
            files.push((format!("{name}-y.pgm"), "pgm", y));
        }
        let lens = lens(profile).map(|info| camera_info(&info, comments).into_bytes());
        files.extend(lens.map(|bytes| ("camera_info.yaml".into(), "yaml", bytes)));
        (files, bytes)
    }
}

/// The lens, of cameras that have their rays through one point.
fn lens(profile: &Profile) -> Option<CameraInfo> {
    let name = profile.name.clone();
    let pixels = profile.camera.pixels().map(|x| x as usize);
    let (focal_px, principal_px, distortion) = match &profile.camera {
        CameraModel::Orthographic { .. } => return None,
        CameraModel::Pinhole { focal_px, .. } => {
            ([*focal_px; 2], pixels.map(|x| 0.5 * x as f64), Distortion::None)
        }
        CameraModel::Calibrated { focal_px, principal_px, distortion, .. } => {
            (*focal_px, *principal_px, *distortion)
        }
    };
    let (model, coefficients) = match distortion {
        Distortion::None => ("plumb_bob", vec![0.0; 5]),
        Distortion::KannalaBrandt { radial } => ("equidistant", radial.to_vec()),
        // (What ROS has no name for is left out, with the whole lens.)
        Distortion::BrownConrady { prism, .. } if prism != [0.0; 4] => return None,
        Distortion::BrownConrady {
            radial: [k1, k2, k3, k4, k5, k6], tangential: [p1, p2], ..
        } => match [k4, k5, k6] {
            [0.0, 0.0, 0.0] => ("plumb_bob", vec![k1, k2, p1, p2, k3]),
            _ => ("rational_polynomial", vec![k1, k2, p1, p2, k3, k4, k5, k6]),
        },
    };
    let principal_px = principal_px.map(|x| x - 0.5);
    Some(CameraInfo { name, pixels, focal_px, principal_px, model, coefficients })
}
