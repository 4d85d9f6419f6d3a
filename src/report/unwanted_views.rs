//! What a mirror shows that nobody asks for, in words.

use super::answer::{AnswerRows, ToRows};
use crate::render::{OwnCamera, UnwantedViews};
use crate::results::three_digits;

/// Angle up to which a ray is on its own way back, degrees: above what the search for it leaves.
const ON_ITS_WAY_DEG: f64 = 1e-6;

impl ToRows for UnwantedViews {
    fn add_to(&self, rows: &mut AnswerRows) {
        let twice = match self.seen_twice {
            0.0 => "nothing of the world is seen twice".into(),
            share => format!(
                "{} % of the picture is reversed, and what it shows is seen again beside it",
                three_digits(100.0 * share)
            ),
        };
        let sentence = format!("{}; {twice}", self.own_camera.sentence());
        rows.named("itself", "camera in the picture", sentence);
    }
}

impl OwnCamera {
    fn sentence(&self) -> String {
        let Self { pixel: [column, row], off_deg, passes_mm } = self;
        let place = format!("column {column:.1}, row {row:.1}");
        if *off_deg <= ON_ITS_WAY_DEG {
            return format!("the camera sees itself at {place}");
        }
        let passes = passes_mm.map_or(String::new(), |mm| {
            format!(" and passes the pupil at {} mm", three_digits(mm))
        });
        format!(
            "the camera's middle is not in the picture: the ray nearest to its own way back ({place}) is {} deg off it{passes}",
            three_digits(*off_deg)
        )
    }
}
