//! What the figures of the pages mean.

/// Headings of the pages' tables by how they end, and what each figure means.
const MEANINGS: [(&str, &str); 40] = [
    ("profile sha256", "Fingerprint of the profile's text: equal for equal profiles."),
    ("part", "Size over all, along X, Y and Z."),
    ("camera", "Where the lens's entrance pupil is in the part's frame, whose Z = 0 is the base."),
    ("world", "How azimuth and elevation are counted, and where the target is."),
    ("method", "How the mirror's shape was solved for."),
    (
        "condition of the fit",
        "By how much the fit may magnify rounding; under 1e6 it does not matter.",
    ),
    (
        "gradient residual",
        "How far the normals of the surface are from those asked for, as a slope.",
    ),
    (
        "curl of the field",
        "How far the normals asked for are from those of any surface; 0 is an exact mirror.",
    ),
    (
        "design: ray error, mrad",
        "Angle between what a pixel of the designed mirror sees and what it should.",
    ),
    ("design: pixel error, px", "The same as a distance in the picture."),
    (
        "why not less",
        "Whether a mirror without error exists: what the picture asks for must be the slopes of a surface.",
    ),
    (
        "least possible error",
        "What no single mirror without steps is below for this camera and picture, to first order in the error.",
    ),
    (
        "wanted picture",
        "Samples of the picture that is given as data, and what is lost between them.",
    ),
    ("straight lines", "How far images of straight lines are from the chords through their ends."),
    (
        "lines between panels",
        "How far from the edges that the profile names a pixel may show what its neighbours' panel is to show.",
    ),
    (
        "camera in the picture",
        "Whether rays come back to the camera, and whether parts of the world are seen twice.",
    ),
    (
        "best-fit sphere and plane",
        "How far the face is from the nearest sphere and plane: what a shop asks first.",
    ),
    ("triangles", "Flat facets of the mesh files."),
    ("chord", "Largest distance between facets and mirror, proven for every facet."),
    ("facet", "By how much flat facets move the picture at most, proven for every facet."),
    (
        "over the least possible",
        "Triangles over the least number that any mesh within the limits needs.",
    ),
    (
        "STEP splines",
        "Control points of the STEP file's surface, and how near it is to the design.",
    ),
    (
        "STEP tolerance",
        "What the part is measured from, and how far its mirror may be off, for programs that read the STEP file.",
    ),
    (
        "drawing",
        "The sheet that a shop signs, what the part is measured from, and how far its mirror may be off.",
    ),
    (
        "STEP read back",
        "The solid that the STEP file was read back as, and how near its mirror is to the design.",
    ),
    ("sag table", "Rows of X, Y, Z and normal, and how near they are to the design."),
    ("solid", "Whether the file is one closed body, and its volume beside the design's."),
    (": rays", "What became of one ray from every pixel of the file's own trace."),
    (": solid", "Whether the file, as it was read back, is one closed body."),
    (": ray error, mrad", "Angle between what a pixel sees in the file and what it should."),
    (": pixel error, px", "The same as a distance in the picture: design and facets together."),
    (
        ": facet error, px",
        "The picture of the file against that of the designed mirror: facets alone.",
    ),
    (", its normals, mrad", "The same by the normals that the file has."),
    (", its normals, px", "The same by the normals that the file has."),
    ("sharpest", "The opening of the lens at which spots are least."),
    (
        "through the lens",
        "How long spots are, and what contrast is left, at the opening of this lens.",
    ),
    ("allowed", "Limits to which the verdict holds the picture."),
    (
        "frame filled",
        "Share of the pixels that see what they should within the largest error allowed.",
    ),
    (
        "obstacle",
        "What it hides of the world: its pixels, and the directions that they would show.",
    ),
    (
        "gain over a disc",
        "Filled pixels against those that a round mirror inscribed in the frame fills.",
    ),
];

/// What the figure under a heading means; none where the heading says it.
pub(super) fn meaning(heading: &str) -> Option<&'static str> {
    let is_of = |(end, _): &&(&str, &str)| match end.starts_with([':', ',']) {
        true => heading.ends_with(end),
        false => heading == *end,
    };
    MEANINGS.iter().find(is_of).map(|(_, meaning)| *meaning)
}
