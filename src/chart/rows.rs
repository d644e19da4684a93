//! Rows of the work-precision chart as tidy CSV: one run a row, failures included.

use crate::scene::Scheme;

/// The step that a run asks for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Asked {
    /// A step \[s\].
    Step(f64),
    /// The largest stable step of an explicit scheme, divided by a whole number.
    Limit(u32),
}

impl Asked {
    fn text(self) -> String {
        match self {
            Asked::Step(dt) => format!("{dt}"),
            Asked::Limit(part) => format!("limit/{part}"),
        }
    }

    fn parse(text: &str) -> Option<Self> {
        match text.strip_prefix("limit/") {
            Some(part) => part.parse().ok().map(Asked::Limit),
            None => text.parse().ok().map(Asked::Step),
        }
    }
}

/// What makes a run the same run: rows with an equal key are not run again.
#[derive(Clone, Debug, PartialEq)]
pub struct Key {
    /// Scene.
    pub scene: String,
    /// Fabric.
    pub fabric: String,
    /// Mesh as asked for, with the number of triangles or the edge length.
    pub mesh: String,
    /// Time scheme.
    pub scheme: Scheme,
    /// Step asked for.
    pub asked: Asked,
}

/// How a run ended.
#[derive(Clone, Debug, PartialEq)]
pub enum Outcome {
    /// It reached the end with this largest error \[-\].
    Done {
        /// Largest distance from the reference over the chart's length \[-\].
        error: f64,
    },
    /// It stopped.
    Died {
        /// When \[s\].
        time: f64,
        /// What it said.
        message: String,
    },
}

/// One run.
#[derive(Clone, Debug, PartialEq)]
pub struct Row {
    /// Which run.
    pub key: Key,
    /// Triangles of the mesh that was built.
    pub triangles: usize,
    /// Mean step or substep taken \[s\].
    pub dt: f64,
    /// Force tolerance over the weight \[-\].
    pub tolerance: f64,
    /// How it ended.
    pub outcome: Outcome,
    /// CPU time of the steps, one thread \[s\].
    pub cpu: f64,
    /// Simulated time reached \[s\].
    pub simulated: f64,
    /// Steps taken.
    pub steps: u64,
    /// Substeps taken.
    pub substeps: u64,
    /// Attempts repeated smaller.
    pub rejected: u64,
    /// Newton iterations.
    pub iterations: u64,
    /// Numerical factorisations.
    pub factorisations: u64,
}

impl Row {
    /// CPU seconds per simulated second; of a run that died at once, per its first step.
    pub fn cpu_rate(&self) -> f64 {
        self.cpu / self.simulated.max(self.dt)
    }

    /// The error of a run that ended well.
    pub fn error(&self) -> Option<f64> {
        match self.outcome {
            Outcome::Done { error } => Some(error),
            Outcome::Died { .. } => None,
        }
    }
}

/// Columns, in order.
const HEADER: &str = "scene,fabric,mesh,scheme,asked_dt_s,triangles,dt_s,tolerance,status,error,died_at_s,\
cpu_s,simulated_s,steps,substeps,rejected,iterations,factorisations,message";

/// A CSV file that cannot be resumed.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum RowsError {
    /// Other columns: made by another version.
    #[error("the columns are `{found}`, wanted `{HEADER}`; move the file away to start again")]
    Columns {
        /// First line of the file.
        found: String,
    },
    /// A value that cannot be read.
    #[error("line {line}: column {column} is `{value}`")]
    Value {
        /// Line of the file, from 1.
        line: usize,
        /// Name of the column.
        column: String,
        /// What stands there.
        value: String,
    },
}

/// Writes rows as CSV.
pub fn to_csv(rows: &[Row]) -> String {
    let mut text = format!("{HEADER}\n");
    for row in rows {
        text += &fields(row).map(|f| quote(&f)).join(",");
        text.push('\n');
    }
    text
}

fn fields(row: &Row) -> [String; 19] {
    let key = &row.key;
    let (status, error, died, message) = match &row.outcome {
        Outcome::Done { error } => ("done", format!("{error:e}"), String::new(), String::new()),
        Outcome::Died { time, message } => {
            ("died", String::new(), format!("{time}"), message.clone())
        }
    };
    [
        key.scene.clone(),
        key.fabric.clone(),
        key.mesh.clone(),
        key.scheme.name().to_string(),
        key.asked.text(),
        row.triangles.to_string(),
        format!("{:e}", row.dt),
        format!("{:e}", row.tolerance),
        status.to_string(),
        error,
        died,
        format!("{}", row.cpu),
        format!("{}", row.simulated),
        row.steps.to_string(),
        row.substeps.to_string(),
        row.rejected.to_string(),
        row.iterations.to_string(),
        row.factorisations.to_string(),
        message,
    ]
}

/// Reads rows back; the text must have the columns of [`to_csv`].
pub fn from_csv(text: &str) -> Result<Vec<Row>, RowsError> {
    let mut lines = text.lines();
    let found = lines.next().unwrap_or_default();
    if found != HEADER {
        return Err(RowsError::Columns {
            found: found.to_string(),
        });
    }
    lines
        .zip(2..)
        .filter(|(l, _)| !l.is_empty())
        .map(|(l, n)| row(l, n))
        .collect()
}

fn row(line: &str, number: usize) -> Result<Row, RowsError> {
    let fields = Fields {
        values: split(line),
        line: number,
    };
    let time = |column| fields.number::<f64>(column);
    let outcome = match fields.text("status") {
        "done" => Outcome::Done {
            error: time("error")?,
        },
        "died" => Outcome::Died {
            time: time("died_at_s")?,
            message: fields.text("message").to_string(),
        },
        _ => return Err(fields.refuse("status")),
    };
    let scheme = Scheme::IN_TIME
        .into_iter()
        .find(|s| s.name() == fields.text("scheme"));
    Ok(Row {
        key: Key {
            scene: fields.text("scene").to_string(),
            fabric: fields.text("fabric").to_string(),
            mesh: fields.text("mesh").to_string(),
            scheme: scheme.ok_or_else(|| fields.refuse("scheme"))?,
            asked: Asked::parse(fields.text("asked_dt_s"))
                .ok_or_else(|| fields.refuse("asked_dt_s"))?,
        },
        triangles: fields.number("triangles")?,
        dt: time("dt_s")?,
        tolerance: time("tolerance")?,
        outcome,
        cpu: time("cpu_s")?,
        simulated: time("simulated_s")?,
        steps: fields.number("steps")?,
        substeps: fields.number("substeps")?,
        rejected: fields.number("rejected")?,
        iterations: fields.number("iterations")?,
        factorisations: fields.number("factorisations")?,
    })
}

struct Fields {
    values: Vec<String>,
    line: usize,
}

impl Fields {
    fn text(&self, column: &str) -> &str {
        let at = HEADER.split(',').position(|c| c == column);
        at.and_then(|k| self.values.get(k))
            .map_or("", String::as_str)
    }

    fn number<T: std::str::FromStr>(&self, column: &str) -> Result<T, RowsError> {
        self.text(column).parse().map_err(|_| self.refuse(column))
    }

    fn refuse(&self, column: &str) -> RowsError {
        RowsError::Value {
            line: self.line,
            column: column.to_string(),
            value: self.text(column).to_string(),
        }
    }
}

fn quote(field: &str) -> String {
    let plain = field.replace(['\n', '\r'], " ");
    match plain.contains([',', '"']) {
        true => format!("\"{}\"", plain.replace('"', "\"\"")),
        false => plain,
    }
}

fn split(line: &str) -> Vec<String> {
    let mut fields = vec![String::new()];
    let mut quoted = false;
    let mut characters = line.chars().peekable();
    while let Some(c) = characters.next() {
        let field = fields.last_mut().expect("never empty");
        match c {
            '"' if quoted && characters.peek() == Some(&'"') => {
                characters.next();
                field.push('"');
            }
            '"' => quoted = !quoted,
            ',' if !quoted => fields.push(String::new()),
            c => field.push(c),
        }
    }
    fields
}
