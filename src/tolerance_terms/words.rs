//! Words of a profile's `[tolerance]`, each with the meaning that the trials give it.

super::words_enum! {
    /// Way of making the part, which has usual limits.
    pub enum ProcessPreset {
        /// Milling on a good five-axis machine.
        PrecisionCnc = "precision-cnc",
        /// Single-point diamond turning.
        Spdt = "spdt",
        /// Diamond ball milling on an ultra-precision machine.
        UltraPrecisionCnc = "ultra-precision-cnc",
        /// Milling in a job shop.
        StandardCnc = "standard-cnc",
        /// Milling with precision, then polishing by hand.
        Polished = "polished",
        /// Stereolithography.
        SlaPrint = "sla-print",
    }
}

super::words_enum! {
    /// Figure of the displacements that is held against the budget.
    pub enum Criterion {
        /// Root of the mean square over the picture.
        Rms = "rms",
        /// 95th percentile over the picture.
        P95 = "p95",
    }
}

super::words_enum! {
    /// Picture that displacements are measured from.
    pub enum Reference {
        /// The picture that the system shows as designed.
        Design = "design",
        /// The picture that the projection asks for.
        Projection = "projection",
    }
}

super::words_enum! {
    /// Measure of a form error's size.
    pub enum FormMeasure {
        /// From its highest to its lowest place.
        Pv = "pv",
        /// Its root mean square over the term's rectangle or disc.
        Rms = "rms",
    }
}

super::words_enum! {
    /// Adjustment of a made system by least squares of the displacement. Focusing a camera changes its
    /// magnification, and nothing else that a displacement of content shows.
    pub enum Compensator {
        /// The picture along X and Y.
        Shift = "shift",
        /// The picture about its middle.
        Rotation = "rotation",
        /// The picture's size.
        Magnification = "magnification",
        /// The mirror about X and Y.
        Tilt = "tilt",
        /// The mirror along the axis.
        Despace = "despace",
    }
}

super::words_enum! {
    /// File that the shop makes the part from.
    pub enum MadeFrom {
        /// A mesh, whose facets the part then has.
        Mesh = "mesh",
        /// The STEP, whose faces are curved.
        Step = "step",
    }
}
