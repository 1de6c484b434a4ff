//! Tables for people, JSON for scripts.

use crate::measure::{Column, Lane};
use std::fmt::Write;

/// One race: a scene at a size, and a kind of ray.
pub struct Row {
    pub scene: String,
    pub size: [u32; 2],
    pub kind: &'static str,
    pub rays: usize,
    pub cells: Vec<Cell>,
}

/// How one lane did.
pub struct Cell {
    pub name: String,
    pub column: Column,
    /// Millions of rays per second.
    pub rate: f64,
    pub hits: usize,
}

impl Row {
    pub fn new(scene: &str, size: [u32; 2], kind: &'static str, rays: usize, lanes: &[Lane]) -> Row {
        let cell = |lane: &Lane| Cell {
            name: lane.name.clone(),
            column: lane.column,
            rate: rays as f64 / lane.seconds * 1e-6,
            hits: lane.hits,
        };
        Row { scene: scene.to_owned(), size, kind, rays, cells: lanes.iter().map(cell).collect() }
    }

    /// The fastest lane of those columns.
    fn best(&self, wanted: impl Fn(Column) -> bool) -> Option<&Cell> {
        self.cells.iter().filter(|c| wanted(c.column)).max_by(|a, b| a.rate.total_cmp(&b.rate))
    }

    /// Our best over the peer's best without and with its robust flag.
    pub fn ratios(&self) -> (Option<f64>, Option<f64>) {
        let Some(ours) = self.best(Column::is_ours) else { return (None, None) };
        let over = |peer: Option<&Cell>| peer.map(|p| ours.rate / p.rate);
        (over(self.best(Column::is_peer)), over(self.best(Column::is_robust)))
    }

    pub fn print(&self, all: bool) {
        let rate = |column| self.best(|c| c == column).map_or_else(|| "-".to_owned(), |c| format!("{:.2}", c.rate));
        let name = |cell: Option<&Cell>| cell.map_or_else(String::new, |c| format!("({})", c.name));
        let ratio = |r: Option<f64>| r.map_or_else(|| "-".to_owned(), |r| format!("{r:.2}"));
        let (plain, robust) = self.ratios();
        println!(
            "{:3} {:>9} {:8}| {:>7} {:>7} {:16}| {:>7} {:>7} {:18}| {:>7} {:>7} | {:>5} {:>6}",
            self.scene,
            format!("{}x{}", self.size[0], self.size[1]),
            self.kind,
            rate(Column::OursSingle),
            self.best(Column::is_ours).map_or_else(String::new, |c| format!("{:.2}", c.rate)),
            name(self.best(Column::is_ours)),
            rate(Column::PeerSingle),
            rate(Column::PeerPacket),
            name(self.best(|c| c == Column::PeerPacket)),
            rate(Column::RobustSingle),
            rate(Column::RobustPacket),
            ratio(plain),
            ratio(robust)
        );
        let hits = |wanted: fn(Column) -> bool| {
            let counts: Vec<usize> = self.cells.iter().filter(|c| wanted(c.column)).map(|c| c.hits).collect();
            let (least, most) = (counts.iter().min(), counts.iter().max());
            match (least, most) {
                (Some(a), Some(b)) if a == b => format!("{a}"),
                (Some(a), Some(b)) => format!("{a}..{b}"),
                _ => "-".to_owned(),
            }
        };
        println!(
            "    of {} rays hit: ours {}, Embree {}, robust {}",
            self.rays,
            hits(Column::is_ours),
            hits(Column::is_peer),
            hits(Column::is_robust)
        );
        self.complain();
        if all {
            for cell in &self.cells {
                println!("        {:24} {:8.2} Mrays/s  {} hits", cell.name, cell.rate, cell.hits);
            }
        }
    }

    /// Says aloud when lanes disagree about what there is to hit: then figures compare different work.
    fn complain(&self) {
        let Some(ours) = self.cells.first().map(|c| c.hits) else { return };
        for cell in &self.cells {
            let off = cell.hits.abs_diff(ours);
            let allowed = if cell.column.is_ours() { 0 } else { self.rays / 1000 };
            if off > allowed {
                println!("!!! DIFFERENT HITS: {} finds {} where ours finds {ours}", cell.name, cell.hits);
            }
        }
    }
}

/// The heading that [`Row::print`] fits under.
pub fn print_heading(threads: usize) {
    println!(
        "Mrays/s, {threads} thread(s), best of the rounds; ratio: ours best over Embree's best, and over its best with the robust flag"
    );
    println!(
        "{:3} {:>9} {:8}| {:>7} {:>7} {:16}| {:>7} {:>7} {:18}| {:>7} {:>7} | {:>5} {:>6}",
        "", "", "", "ours 1", "best", "", "Embree1", "packet", "", "robust1", "packet", "ratio", "robust"
    );
}

/// The smallest ratios, as the last lines of a run.
pub fn print_worst(rows: &[Row]) {
    let worst = |pick: fn(&Row) -> Option<f64>| {
        rows.iter().filter_map(|row| pick(row).map(|r| (r, row))).min_by(|a, b| a.0.total_cmp(&b.0))
    };
    if let Some((r, row)) = worst(|row| row.ratios().1) {
        println!("worst ratio to the robust column {r:.2} ({}, {})", row.scene, row.kind);
    }
    match worst(|row| row.ratios().0) {
        Some((r, row)) => println!("worst ratio {r:.2} ({}, {})", row.scene, row.kind),
        None => println!("worst ratio - (no peer)"),
    }
}

/// All cells of all rows. Names hold no characters that JSON would want escaped.
pub fn json(rows: &[Row]) -> String {
    let mut text = String::from("[\n");
    for (i, row) in rows.iter().enumerate() {
        let cells: Vec<String> = row
            .cells
            .iter()
            .map(|c| {
                let (name, column) = (&c.name, c.column);
                format!(r#"{{"name": "{name}", "column": "{column:?}", "mrays": {:.4}, "hits": {}}}"#, c.rate, c.hits)
            })
            .collect();
        let _ = write!(
            text,
            r#"  {{"scene": "{}", "width": {}, "height": {}, "kind": "{}", "rays": {}, "cells": [{}]}}"#,
            row.scene,
            row.size[0],
            row.size[1],
            row.kind,
            row.rays,
            cells.join(", ")
        );
        text.push_str(if i + 1 < rows.len() { ",\n" } else { "\n" });
    }
    text.push_str("]\n");
    text
}
