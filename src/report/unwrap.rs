//! What became of a photo.

use super::answer::{Answer, AnswerRows, Head, ToRows};
use crate::results::{PanoramaFacts, PhotoFacts, UnwrapMapFacts, UnwrapReport, figures};

impl Answer for UnwrapReport {
    fn head(&self) -> Head<'_> {
        Head::of(&self.profile)
    }

    fn rows(&self) -> AnswerRows {
        AnswerRows::of(&[&self.photo, &self.panorama, &self.map, &self.files])
    }
}

impl ToRows for PhotoFacts {
    fn add_to(&self, rows: &mut AnswerRows) {
        let scale = match self.pixels_per_sensor_pixel {
            1.0 => "as the sensor".to_owned(),
            scale => format!("{scale:.4} to one of the sensor"),
        };
        let (name, [width, height]) = (&self.name, self.pixels);
        rows.terminal("photo", format!("{name}: {width} x {height} pixels, {scale}"));
    }
}

impl ToRows for PanoramaFacts {
    fn add_to(&self, rows: &mut AnswerRows) {
        let Self { way, projection, pixels: [width, height], azimuth_deg, elevation_deg } = self;
        let [[left, right], [low, high]] = [azimuth_deg, elevation_deg];
        rows.terminal(
            "panorama",
            format!(
                "{width} x {height} pixels, {projection}, by {way}; azimuth {left:.2} to {right:.2} deg, \
                 elevation {low:.2} to {high:.2} deg"
            ),
        );
    }
}

impl ToRows for UnwrapMapFacts {
    fn add_to(&self, rows: &mut AnswerRows) {
        let (seen, distortion) = (100.0 * self.seen, figures(self.distortion_px));
        rows.terminal(
            "map",
            format!("{seen:.2} % of the panorama is seen; distortion removed {distortion} px"),
        );
    }
}
