//! What a build would make, foreseen without making it.

use super::answer::{Answer, AnswerRows, Head, ToRows};
use crate::results::{
    BuildForecast, FileForecast, ForecastLimit, MeshForecast, file_size, of_at_most,
};

impl Answer for BuildForecast {
    fn head(&self) -> Head<'_> {
        Head::of(&self.profile).with_warnings(&self.warnings)
    }

    fn rows(&self) -> AnswerRows {
        let mut rows = AnswerRows::of(&[&self.mesh, &self.files]);
        self.reasons.iter().for_each(|reason| rows.remark(format!("- {reason}")));
        rows.terminal("dry run", "nothing was written");
        rows
    }
}

impl ToRows for MeshForecast {
    fn add_to(&self, rows: &mut AnswerRows) {
        let tolerances = [(self.chord_um, "chord", "um"), (self.facet_px, "facet", "px")];
        let tolerances: Vec<String> = tolerances
            .into_iter()
            .filter_map(|(value, what, unit)| match value {
                ForecastLimit { limit: Some(limit), .. } => {
                    Some(format!("{what} within {limit} {unit}"))
                }
                ForecastLimit { foreseen: Some(x), .. } => {
                    Some(format!("{what} about {x:.3} {unit}"))
                }
                _ => None,
            })
            .collect();
        let [optical, all] = [self.optical_triangles, self.triangles].map(rough);
        let (most, tolerances) = (of_at_most(self.max_triangles), tolerances.join(", "));
        rows.terminal(
            "mesh",
            format!("about {optical} optical triangles ({all} in all{most}); {tolerances}"),
        );
    }
}

impl ToRows for FileForecast {
    fn add_to(&self, rows: &mut AnswerRows) {
        rows.terminal("file", format!("{}  about {}", self.name, file_size(self.bytes)));
    }
}

/// A number in three digits.
fn rough(count: usize) -> usize {
    let mut unit = 1;
    while count / unit >= 1000 {
        unit *= 10;
    }
    (count + unit / 2) / unit * unit
}

#[cfg(test)]
mod tests {
    #[test]
    fn rough_numbers_have_three_digits() {
        let found = [0, 7, 999, 1000, 1234, 99_950, 587_936].map(super::rough);
        assert_eq!(found, [0, 7, 999, 1000, 1230, 100_000, 588_000]);
    }
}
