//! Curves and bars as PNG files: panels side by side, each with axes, ticks and a legend.
//!
//! Drawn by `plotters` in plain Rust; its text needs a font, which the crate `dejavu` brings, so that nothing of the system is asked for.

use plotters::coord::Shift;
use plotters::coord::ranged1d::{AsRangedCoord, Ranged, ValueFormatter};
use plotters::prelude::*;
use plotters::style::{FontStyle, register_font};
use std::error::Error;
use std::path::Path;
use std::sync::Once;

/// One curve, or the bars of one colour.
pub struct Series {
    pub name: String,
    pub points: Vec<(f64, f64)>,
}

impl Series {
    pub fn new(name: impl Into<String>, points: impl IntoIterator<Item = (f64, f64)>) -> Series {
        Series { name: name.into(), points: points.into_iter().collect() }
    }
}

pub struct Panel {
    pub title: String,
    pub x: &'static str,
    pub y: &'static str,
    /// Whether y is drawn by its logarithm.
    pub log: bool,
    /// Bars stand at 0, 1, 2 … under these names; empty: curves.
    pub names: Vec<&'static str>,
    pub series: Vec<Series>,
}

const PANEL: (u32, u32) = (460, 300);
/// Told apart by colour-blind eyes as well (Okabe and Ito).
const COLORS: [RGBColor; 6] = [
    RGBColor(213, 94, 0),
    RGBColor(0, 114, 178),
    RGBColor(0, 158, 115),
    RGBColor(204, 121, 167),
    RGBColor(230, 159, 0),
    RGBColor(86, 180, 233),
];

fn text(size: u32) -> TextStyle<'static> {
    ("sans-serif", size).into_font().into()
}

/// Draws panels in rows of `wide`.
///
/// # Errors
/// What the plotting or the image crate reports.
pub fn draw(path: &Path, wide: usize, panels: &[Panel]) -> Result<(), Box<dyn Error>> {
    static FONT: Once = Once::new();
    FONT.call_once(|| {
        // The same name twice would be the only error.
        let _ = register_font("sans-serif", FontStyle::Normal, dejavu::sans::regular());
    });
    let wide = wide.min(panels.len());
    let rows = panels.len().div_ceil(wide);
    let size = (PANEL.0 * wide as u32, PANEL.1 * rows as u32);
    let mut pixels = vec![0; (size.0 * size.1 * 3) as usize];
    {
        let root = BitMapBackend::with_buffer(&mut pixels, size).into_drawing_area();
        root.fill(&WHITE)?;
        for (area, panel) in root.split_evenly((rows, wide)).iter().zip(panels) {
            let all = || panel.series.iter().flat_map(|s| &s.points).filter(|p| p.1.is_finite());
            let x = if panel.names.is_empty() {
                all().fold(f64::MAX, |least, p| least.min(p.0))..all().fold(f64::MIN, |most, p| most.max(p.0))
            } else {
                -0.5..panel.names.len() as f64 - 0.5
            };
            let most = all().fold(0.0, |most: f64, p| most.max(p.1));
            let least = all().map(|p| p.1).filter(|y| *y > 0.0).fold(f64::MAX, f64::min);
            // Less than a decade would be an axis without a tick.
            if panel.log && most > 10.0 * least {
                fill(area, panel, x, (least * 0.8..most * 4.0).log_scale(), least * 0.8)?;
            } else {
                fill(area, panel, x, 0.0..most * 1.4, 0.0)?;
            }
        }
        root.present()?;
    }
    let picture = image::RgbImage::from_raw(size.0, size.1, pixels).ok_or("a picture of this size")?;
    Ok(picture.save(path)?)
}

fn fill<Y>(
    area: &DrawingArea<BitMapBackend, Shift>,
    panel: &Panel,
    x: std::ops::Range<f64>,
    y: Y,
    floor: f64,
) -> Result<(), Box<dyn Error>>
where
    Y: AsRangedCoord<Value = f64>,
    Y::CoordDescType: Ranged<ValueType = f64> + ValueFormatter<f64>,
{
    let mut chart = ChartBuilder::on(area)
        .caption(&panel.title, text(16))
        .margin(8)
        .margin_right(22)
        .x_label_area_size(36)
        .y_label_area_size(58)
        .build_cartesian_2d(x, y)?;
    let name = |x: &f64| {
        let at = x.round();
        let whole = (x - at).abs() < 0.01 && at >= 0.0;
        if whole { panel.names.get(at as usize).copied().unwrap_or("").to_owned() } else { String::new() }
    };
    let number = |value: &f64| format!("{}", (value * 1e4).round() / 1e4);
    let mut mesh = chart.configure_mesh();
    mesh.x_desc(panel.x)
        .y_desc(panel.y)
        .axis_desc_style(text(13))
        .label_style(text(12))
        .light_line_style(WHITE)
        .y_labels(6);
    let of_decade = |value: &f64| {
        // All nine ticks of a decade would stand on each other.
        let first = (value / 10f64.powf(value.log10().floor())).round();
        if [1.0, 2.0, 5.0, 10.0].contains(&first) { number(value) } else { String::new() }
    };
    mesh.y_label_formatter(if floor > 0.0 { &of_decade } else { &number });
    if panel.names.is_empty() {
        mesh.x_label_formatter(&number).draw()?;
    } else {
        mesh.x_labels(panel.names.len() + 2).x_label_formatter(&name).disable_x_mesh().draw()?;
    }
    for (i, series) in panel.series.iter().enumerate() {
        let color = COLORS[i % COLORS.len()];
        let drawn = if panel.names.is_empty() {
            let points = series.points.iter().copied().filter(|p| p.1.is_finite());
            chart.draw_series(LineSeries::new(points, color.stroke_width(2)))?
        } else {
            let width = 0.8 / panel.series.len() as f64;
            let bar = |&(x, y): &(f64, f64)| {
                let left = x - 0.4 + width * i as f64;
                Rectangle::new([(left, floor), (left + width * 0.95, y)], color.filled())
            };
            chart.draw_series(series.points.iter().map(bar))?
        };
        drawn.label(&series.name).legend(move |(x, y)| Rectangle::new([(x, y - 4), (x + 14, y + 4)], color.filled()));
    }
    if panel.series.len() > 1 {
        chart
            .configure_series_labels()
            .position(SeriesLabelPosition::UpperLeft)
            .background_style(WHITE.mix(0.8))
            .label_font(text(12))
            .draw()?;
    }
    Ok(())
}
