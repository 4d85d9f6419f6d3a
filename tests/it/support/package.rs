//! 3MF packages made by hand.

use std::io::Write;
use std::path::Path;

/// What a package says its parts are.
pub const TYPES: &str = "<Types xmlns=\"http://schemas.openxmlformats.org/package/2006/content-types\">\n\
    <Default Extension=\"rels\" ContentType=\"application/vnd.openxmlformats-package.relationships+xml\"/>\n\
    <Default Extension=\"model\" ContentType=\"application/vnd.ms-package.3dmanufacturing-3dmodel+xml\"/>\n\
    </Types>";

const RELATIONS: &str = "<Relationships><Relationship Target=\"/3D/3dmodel.model\" Id=\"a\" \
    Type=\"http://schemas.microsoft.com/3dmanufacturing/2013/01/3dmodel\"/></Relationships>";

/// Writes a 3MF with these content types, if any, and a model of these pieces of text.
pub fn package(path: &Path, types: Option<&str>, model: &[&str]) {
    let mut zip = zip::ZipWriter::new(std::fs::File::create(path).unwrap());
    let options = zip::write::SimpleFileOptions::default();
    if let Some(types) = types {
        zip.start_file("[Content_Types].xml", options).unwrap();
        zip.write_all(types.as_bytes()).unwrap();
    }
    zip.start_file("_rels/.rels", options).unwrap();
    zip.write_all(RELATIONS.as_bytes()).unwrap();
    zip.start_file("3D/3dmodel.model", options).unwrap();
    model.iter().for_each(|text| zip.write_all(text.as_bytes()).unwrap());
    zip.finish().unwrap();
}
