//! What a table leaves behind: rows for `--json`, and a verdict that is printed under the table and again at the end.

use std::fmt::Write;

/// A value of a row.
pub enum Value<'a> {
    Text(&'a str),
    Number(f64),
}

impl<'a> From<&'a str> for Value<'a> {
    fn from(text: &'a str) -> Self {
        Value::Text(text)
    }
}

impl From<f64> for Value<'_> {
    fn from(number: f64) -> Self {
        Value::Number(number)
    }
}

impl From<u32> for Value<'_> {
    fn from(number: u32) -> Self {
        Value::Number(f64::from(number))
    }
}

#[derive(Default)]
pub struct Report {
    rows: Vec<String>,
    verdicts: Vec<String>,
}

impl Report {
    /// A row of a table. Texts hold no characters that JSON would want escaped.
    pub fn row(&mut self, table: &str, cells: &[(&str, Value)]) {
        let mut row = format!(r#"  {{"table": "{table}""#);
        for (name, value) in cells {
            let _ = match value {
                Value::Text(text) => write!(row, r#", "{name}": "{text}""#),
                Value::Number(number) if number.is_finite() => write!(row, r#", "{name}": {number:.6}"#),
                Value::Number(_) => write!(row, r#", "{name}": null"#),
            };
        }
        row.push('}');
        self.rows.push(row);
    }

    /// A goal, and whether it is reached.
    pub fn verdict(&mut self, table: &str, reached: bool, text: &str) {
        self.say(table, if reached { "reached" } else { "MISSED" }, text);
    }

    /// A table whose paper states no figure that could be missed.
    pub fn remark(&mut self, table: &str, text: &str) {
        self.say(table, "no goal", text);
    }

    fn say(&mut self, table: &str, word: &str, text: &str) {
        let line = format!("verdict {table:8} {word:7} {text}");
        println!("{line}");
        self.verdicts.push(line);
    }

    /// All verdicts, as the last lines of a run.
    pub fn end(&self) {
        if self.verdicts.len() > 1 {
            println!("\n== verdicts ==");
            self.verdicts.iter().for_each(|line| println!("{line}"));
        }
    }

    pub fn json(&self) -> String {
        format!("[\n{}\n]\n", self.rows.join(",\n"))
    }
}

/// The head of a table.
pub fn head(table: &str, what: &str) {
    println!("\n== {table}: {what} ==");
}
