//! What became of a photo.

use super::answer::{Answer, AnswerRows, Head, ToRows};
use crate::results::{
    FramesFacts, GroundFacts, PanoramaFacts, PhotoFacts, UnwrapMapFacts, UnwrapReport, ViewFacts,
    figures, three_digits,
};

impl Answer for UnwrapReport {
    fn head(&self) -> Head<'_> {
        Head::of(&self.profile).with_warnings(&self.warnings)
    }

    fn rows(&self) -> AnswerRows {
        let mut rows = AnswerRows::of(&[&self.photo]);
        if let Some(pose) = &self.pose {
            rows.terminal("pose", format!("as mounted by {pose}"));
        }
        rows.append(AnswerRows::of(&[&self.panorama, &self.view, &self.ground]));
        if let Some(UnwrapMapFacts { seen, distortion_px }) = self.map {
            let name = match (self.view, self.ground) {
                (Some(_), _) => "view",
                (_, Some(_)) => "plan",
                _ => "panorama",
            };
            let mut text = format!("{:.2} % of the {name} is seen", 100.0 * seen);
            if distortion_px.is_some() {
                text += &format!("; distortion removed {} px", figures(distortion_px));
            }
            rows.terminal("map", text);
        }
        match &self.frames {
            None => self.files.add_to(&mut rows),
            Some(frames) => rows.append(AnswerRows::of(&[frames])),
        }
        rows
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

impl ToRows for FramesFacts {
    fn add_to(&self, rows: &mut AnswerRows) {
        let what = match self.format {
            "pictures" => "pictures of the folder".to_owned(),
            format => format!("frames of the stream, {format}"),
        };
        rows.terminal("frames", format!("{} {what}", self.count));
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

impl ToRows for ViewFacts {
    fn add_to(&self, rows: &mut AnswerRows) {
        let Self { pixels: [width, height], azimuth_deg, elevation_deg, field_deg } = self;
        rows.terminal(
            "view",
            format!(
                "{width} x {height} pixels in perspective, {field_deg} deg across; azimuth {azimuth_deg} deg, elevation {elevation_deg} deg"
            ),
        );
    }
}

impl ToRows for GroundFacts {
    fn add_to(&self, rows: &mut AnswerRows) {
        let Self { pixels: [width, height], height_mm, range_mm, mm_per_px, row_mm, .. } = self;
        let way = if *row_mm < 0.0 { "up" } else { "down" };
        let [range_mm, mm_per_px] = [*range_mm, *mm_per_px].map(three_digits);
        rows.terminal(
            "ground",
            format!(
                "{width} x {height} pixels of {mm_per_px} mm, X to the right and Y {way}; Z = {height_mm} mm in the part's frame, to {range_mm} mm from the axis"
            ),
        );
    }
}
