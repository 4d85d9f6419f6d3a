//! Views on rectangles: cameras off the axis and targets in any pose.

use super::{Draft, Setting, rounded};

impl Draft {
    pub(super) fn view(&mut self, setting: &Setting) {
        if self.chance(0.6) {
            self.mount(setting.width);
        }
        let law = self.pick(&["perspective", "fisheye"]);
        let hfov = self.octaves([5.0, 140.0]);
        let [azimuth, elevation] = [self.inside([-180.0, 180.0]), self.inside([10.0, 90.0])];
        let centre = match self.chance(0.5) {
            true => format!(", centre_deg = [{azimuth}, {elevation}]"),
            false => String::new(),
        };
        let kind = self.pick(&["equidistant", "equisolid", "stereographic"]);
        let kind = if law == "fisheye" { format!(", law = \"{kind}\"") } else { String::new() };
        let roll = self.inside([-90.0, 90.0]);
        let roll = if self.chance(0.2) { format!(", roll_deg = {roll}") } else { String::new() };
        let (target, _) = self.target(setting.width);
        self.line(format_args!(
            "projection.{law} = {{ hfov_deg = {hfov}{centre}{kind}{roll}{target} }}"
        ));
        if target.is_empty() && self.chance(0.6) {
            self.posed(setting.width);
        }
        self.line("layout.rectangle = {}");
    }

    fn mount(&mut self, width: f64) {
        let fold = self.octaves([1.0, 120.0]) * self.sign();
        let towards = self.inside([-180.0, 180.0]);
        let [x, y] = [(); 2].map(|()| rounded(width * self.inside([-0.2, 0.2])));
        let shift =
            if self.chance(0.3) { format!(", shift_mm = [{x}, {y}]") } else { String::new() };
        self.line(format_args!("mount = {{ fold_deg = {fold}, towards_deg = {towards}{shift} }}"));
    }

    /// A surface that a mirror which looks up along Z is likely to see.
    fn posed(&mut self, width: f64) {
        let far = rounded(width * self.octaves([0.6, 30.0]));
        let [x, y] = [(); 2].map(|()| rounded(far * self.inside([-0.5, 0.5])));
        let [a, b] = [(); 2].map(|()| self.inside([-1.0, 1.0]));
        let radius = rounded(far * self.octaves([0.3, 4.0]));
        let surface = match self.pick(&["plane", "sphere", "cylinder"]) {
            "plane" => format!("plane = {{ point_mm = [{x}, {y}, {far}], normal = [{a}, {b}, 1]"),
            "sphere" => format!("sphere = {{ centre_mm = [{x}, {y}, {far}], radius_mm = {radius}"),
            _ => format!(
                "cylinder = {{ point_mm = [{x}, {y}, {far}], axis = [1, {a}, {b}], radius_mm = {radius}"
            ),
        };
        let from = [(); 3].map(|()| rounded(far * self.inside([-0.1, 0.1])));
        let from =
            if self.chance(0.4) { format!(", viewpoint_mm = {from:?}") } else { String::new() };
        self.line(format_args!("target.{surface}{from} }}"));
    }
}
