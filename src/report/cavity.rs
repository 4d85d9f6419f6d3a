//! The cavity of a hollow part in answers.

use super::answer::{AnswerRows, ToRows};
use crate::results::{CavityFacts, DrainFacts};

impl ToRows for CavityFacts {
    fn add_to(&self, rows: &mut AnswerRows) {
        let Self { wall_mm, roof_mm, volume_mm3, material_share, drains } = self;
        let count = match drains.len() {
            1 => "1 drain".to_owned(),
            count => format!("{count} drains"),
        };
        rows.add(
            "hollow",
            format!(
                "walls and base {wall_mm} mm, {roof_mm:.2} under the mirror; {count} through the base; {:.0} % of the \
                 material",
                100.0 * material_share
            ),
        );
        let place = |drain: &DrainFacts| {
            let [x, y] = drain.at_mm;
            format!("{:.3} mm at X {x:.3}, Y {y:.3}", drain.diameter_mm)
        };
        let places: Vec<String> = drains.iter().map(place).collect();
        rows.details(|rows| rows.add("drains", places.join("; ")));
        rows.page("cavity volume", format!("{volume_mm3:.3} mm^3"));
    }
}
