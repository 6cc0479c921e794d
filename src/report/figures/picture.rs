//! Pictures that came from the study, and the same wrapped as SVG: Figure 3 in two styles, and the pixels that are wrong.

use crate::report::ReportError;
use crate::report::figures::canvas::Rendered;
use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use std::fs;
use std::io::ErrorKind;
use std::path::Path;

/// The picture `name`.png of the rows folder in both formats; nothing where the study left none.
///
/// # Errors
/// A file that cannot be read or is not a PNG.
pub(crate) fn picture(rows_dir: &Path, name: &str) -> Result<Option<Rendered>, ReportError> {
    let path = rows_dir.join(format!("{name}.png"));
    let png = match fs::read(&path) {
        Ok(bytes) => bytes,
        Err(e) if e.kind() == ErrorKind::NotFound => return Ok(None),
        Err(e) => return Err(ReportError::io("read", &path, e)),
    };
    let picture = image::load_from_memory_with_format(&png, image::ImageFormat::Png);
    let picture = picture.map_err(|e| ReportError::Picture { path, reason: e.to_string() })?;
    let (width, height) = (picture.width(), picture.height());
    let data = STANDARD.encode(&png);
    let svg = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{width}\" height=\"{height}\" viewBox=\"0 0 {width} {height}\">\n\
         <image width=\"{width}\" height=\"{height}\" href=\"data:image/png;base64,{data}\"/>\n</svg>\n"
    );
    Ok(Some(Rendered { svg, png }))
}
