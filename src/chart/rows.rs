//! Rows of the work-precision chart as tidy CSV: one run a row, failures included.

use crate::scene::Method;
use crate::sim::Work;

/// The step that a run asks for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Asked {
    /// A step \[s\].
    Step(f64),
    /// The largest stable step of an explicit scheme, divided by a whole number.
    Limit(u32),
    /// So many times that step, where the scheme is unstable.
    Past(u32),
}

impl Asked {
    fn text(self) -> String {
        match self {
            Asked::Step(dt) => format!("{dt}"),
            Asked::Limit(part) => format!("limit/{part}"),
            Asked::Past(times) => format!("limit*{times}"),
        }
    }

    fn parse(text: &str) -> Option<Self> {
        let after = |prefix| text.strip_prefix(prefix)?.parse().ok();
        let share = after("limit/").map(Asked::Limit);
        let multiple = || after("limit*").map(Asked::Past);
        let step = || text.parse().ok().map(Asked::Step);
        share.or_else(multiple).or_else(step)
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
    /// Scheme and solver.
    pub method: Method,
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
    /// It was sound but cost more than was allowed, and was left at this time \[s\].
    Unfinished {
        /// When \[s\].
        time: f64,
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
    /// Steps that ended above the tolerance.
    pub starved: u64,
    /// Work counted.
    pub work: Work,
    /// The error by its causes.
    pub parts: Parts,
}

/// An error taken apart, each over the chart's length \[-\]; nothing where it was not measured.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Parts {
    /// What the equations of a step are not solved by: against the same run with a thousandth of the tolerance.
    pub algebra: Option<f64>,
    /// What the step costs: against small explicit steps on the same mesh.
    pub time: Option<f64>,
    /// What the mesh costs: small explicit steps on this mesh against the reference.
    pub space: Option<f64>,
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
            Outcome::Died { .. } | Outcome::Unfinished { .. } => None,
        }
    }
}

/// Columns, in order.
const HEADER: &str = "scene,fabric,mesh,method,asked_dt_s,triangles,dt_s,tolerance,status,error,error_algebra,\
error_time,error_space,died_at_s,cpu_s,simulated_s,steps,starved,substeps,rejected,iterations,evaluations,\
factorisations,indefinite,constant,solves,halvings,message";

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

fn fields(row: &Row) -> [String; 28] {
    let (key, work) = (&row.key, &row.work);
    let maybe = |part: Option<f64>| part.map_or(String::new(), |part| format!("{part:e}"));
    let (status, error, died, message) = match &row.outcome {
        Outcome::Done { error } => ("done", format!("{error:e}"), String::new(), String::new()),
        Outcome::Died { time, message } => {
            ("died", String::new(), format!("{time}"), message.clone())
        }
        Outcome::Unfinished { time } => {
            let time = format!("{time}");
            ("unfinished", String::new(), time, String::new())
        }
    };
    [
        key.scene.clone(),
        key.fabric.clone(),
        key.mesh.clone(),
        key.method.name(),
        key.asked.text(),
        row.triangles.to_string(),
        format!("{:e}", row.dt),
        format!("{:e}", row.tolerance),
        status.to_string(),
        error,
        maybe(row.parts.algebra),
        maybe(row.parts.time),
        maybe(row.parts.space),
        died,
        format!("{}", row.cpu),
        format!("{}", row.simulated),
        row.steps.to_string(),
        row.starved.to_string(),
        work.substeps.to_string(),
        work.rejected.to_string(),
        work.iterations.to_string(),
        work.evaluations.to_string(),
        work.factorisations.to_string(),
        work.indefinite.to_string(),
        work.constant.to_string(),
        work.solves.to_string(),
        work.halvings.to_string(),
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
        "unfinished" => Outcome::Unfinished {
            time: time("died_at_s")?,
        },
        _ => return Err(fields.refuse("status")),
    };
    let maybe = |column| match fields.text(column) {
        "" => Ok(None),
        _ => fields.number::<f64>(column).map(Some),
    };
    let count = |column| fields.number::<u64>(column);
    Ok(Row {
        key: Key {
            scene: fields.text("scene").to_string(),
            fabric: fields.text("fabric").to_string(),
            mesh: fields.text("mesh").to_string(),
            method: Method::named(fields.text("method")).ok_or_else(|| fields.refuse("method"))?,
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
        starved: count("starved")?,
        work: Work {
            substeps: count("substeps")?,
            rejected: count("rejected")?,
            iterations: count("iterations")?,
            evaluations: count("evaluations")?,
            factorisations: count("factorisations")?,
            indefinite: count("indefinite")?,
            constant: count("constant")?,
            solves: count("solves")?,
            halvings: count("halvings")?,
            ..Work::default()
        },
        parts: Parts {
            algebra: maybe("error_algebra")?,
            time: maybe("error_time")?,
            space: maybe("error_space")?,
        },
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
