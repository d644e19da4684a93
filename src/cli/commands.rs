//! Commands at set steps, written by hand.
//!
//! ```toml
//! [[command]]
//! step = 40                    # it holds from the step after this one on
//! to = "/toile/cmd/obstacle"   # topic or service (`toile list commands`)
//! message = { operation = 2, name = "table" }
//! ```

use std::path::Path;

use serde::Deserialize;
use serde_json::Value;

use super::{CliError, source};
use crate::node::Order;
use crate::wire::inbound;

/// The file.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Commands {
    #[serde(default)]
    command: Vec<Command>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Command {
    /// Steps taken before it.
    step: u64,
    /// Topic or service.
    to: String,
    /// Its fields by name; what is left out is zero or empty.
    #[serde(default)]
    message: Value,
}

/// Reads a file of commands, each with the step after which it is due; all of them have been understood.
pub(super) fn read(path: &Path) -> Result<Vec<(u64, Order)>, CliError> {
    let name = path.display();
    let text = source::file(path)?;
    let commands: Commands = toml::from_str(&text).map_err(|error| {
        let line = error.span().map(|span| {
            let before = &text[..span.start.min(text.len())];
            format!("line {}: ", before.matches('\n').count() + 1)
        });
        let reason = error.message().replace('\n', " ");
        CliError::Input(format!("{name}: {}{reason}", line.unwrap_or_default()))
    })?;
    let orders = commands.command.into_iter().enumerate().map(|(index, c)| {
        let step = c.step;
        let order = order(c).map_err(|reason| {
            CliError::Input(format!("{name}: command {}: {reason}", index + 1))
        })?;
        Ok((step, order))
    });
    orders.collect()
}

fn order(command: Command) -> Result<Order, String> {
    let inlet = inbound::find(&command.to).ok_or_else(|| {
        let known: Vec<_> = inbound::ALL.iter().map(|inlet| inlet.name).collect();
        let (to, known) = (&command.to, known.join(", "));
        format!("to = {to:?}: must be one of {known}")
    })?;
    let fields = match command.message {
        Value::Null => Value::Object(serde_json::Map::new()),
        given => given,
    };
    let bytes = inlet
        .compose(&fields)
        .map_err(|reason| format!("message.{reason}"))?;
    inbound::decode(inlet, &bytes).map_err(|malformed| format!("message.{malformed}"))?;
    Ok(Order {
        inlet,
        bytes,
        reply: None,
    })
}
