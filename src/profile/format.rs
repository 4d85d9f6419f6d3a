//! Kinds of files to write.

use std::fmt;

/// A kind of file to write: the part as a mesh, or as designed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum FileFormat {
    /// Triangles of the part, which are read back and traced.
    Mesh(MeshFormat),
    /// The part as designed.
    Cad(CadFormat),
}

/// A format of triangles.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum MeshFormat {
    /// Binary STL, single precision.
    Stl,
    /// Wavefront OBJ, decimal text.
    Obj,
    /// 3MF, compressed, single precision.
    ThreeMf,
    /// Binary glTF 2.0, single precision.
    Glb,
}

/// A format of the designed part.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum CadFormat {
    /// STEP, curved faces.
    Step,
    /// Table of places and normals of the mirror, decimal text.
    Csv,
    /// Drawing of the part.
    Drawing(DrawingFormat),
}

/// A format of drawings.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum DrawingFormat {
    /// PDF.
    Pdf,
    /// DXF.
    Dxf,
}

/// The schema of a STEP file.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum StepProtocol {
    /// AP214: the shape and its colours.
    #[default]
    Ap214,
    /// AP242: datum features and the mirror's tolerance too.
    Ap242,
}

impl From<MeshFormat> for FileFormat {
    fn from(format: MeshFormat) -> Self {
        Self::Mesh(format)
    }
}

impl From<CadFormat> for FileFormat {
    fn from(format: CadFormat) -> Self {
        Self::Cad(format)
    }
}

impl MeshFormat {
    /// All of them.
    pub const ALL: [Self; 4] = [Self::Stl, Self::Obj, Self::ThreeMf, Self::Glb];

    /// Endings of files, as a sentence has them.
    pub fn endings() -> String {
        let [others @ .., last] = Self::ALL.map(|format| format!(".{}", format.name()));
        format!("{} or {last}", others.join(", "))
    }

    /// Name in a profile, and its file's.
    const fn names(self) -> (&'static str, &'static str) {
        match self {
            Self::Stl => ("stl", "mirror.stl"),
            Self::Obj => ("obj", "mirror.obj"),
            Self::ThreeMf => ("3mf", "mirror.3mf"),
            Self::Glb => ("glb", "mirror.glb"),
        }
    }

    /// The format's name in a profile, which is also the file's extension.
    pub fn name(self) -> &'static str {
        self.names().0
    }

    /// The name of its file.
    pub fn file_name(self) -> &'static str {
        self.names().1
    }
}

impl CadFormat {
    /// All of them.
    pub const ALL: [Self; 4] = [
        Self::Step,
        Self::Csv,
        Self::Drawing(DrawingFormat::Pdf),
        Self::Drawing(DrawingFormat::Dxf),
    ];

    /// Name in a profile, and its file's.
    const fn names(self) -> (&'static str, &'static str) {
        match self {
            Self::Step => ("step", "mirror.step"),
            Self::Csv => ("csv", "sag.csv"),
            Self::Drawing(DrawingFormat::Pdf) => ("pdf", "drawing.pdf"),
            Self::Drawing(DrawingFormat::Dxf) => ("dxf", "drawing.dxf"),
        }
    }

    /// The format's name in a profile, which is also the file's extension.
    pub fn name(self) -> &'static str {
        self.names().0
    }

    /// The name of its file.
    pub fn file_name(self) -> &'static str {
        self.names().1
    }
}

impl FileFormat {
    /// All formats that can be written.
    pub fn all() -> impl Iterator<Item = Self> {
        let mesh = MeshFormat::ALL.into_iter().map(Self::Mesh);
        mesh.chain(CadFormat::ALL.into_iter().map(Self::Cad))
    }

    /// The format's name in a profile, which is also the file's extension.
    pub fn name(self) -> &'static str {
        match self {
            Self::Mesh(format) => format.name(),
            Self::Cad(format) => format.name(),
        }
    }

    /// The name of its file.
    pub fn file_name(self) -> &'static str {
        match self {
            Self::Mesh(format) => format.file_name(),
            Self::Cad(format) => format.file_name(),
        }
    }
}

impl fmt::Display for FileFormat {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

impl fmt::Display for MeshFormat {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}
