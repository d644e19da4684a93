//! An independent reader: follows the schema text of a message through its bytes, as a viewer does. Not tests,
//! but what tests of messages look through.

use std::collections::BTreeMap;

use toile::wire::{Message, cdr};

/// Fields of a definition: type and name.
pub type Fields = Vec<(String, String)>;

/// The definitions in a concatenated schema, by `package/Name`, the root's first.
pub fn parse(name: &str, schema: &str) -> (String, BTreeMap<String, Fields>) {
    let root = name.replace("/msg/", "/");
    let separator = "=".repeat(80);
    let mut definitions = BTreeMap::new();
    for (index, part) in schema.split(&format!("{separator}\n")).enumerate() {
        let (name, body) = match index {
            0 => (root.clone(), part),
            _ => {
                let (head, body) = part.split_once('\n').expect("MSG line");
                (head.strip_prefix("MSG: ").expect("MSG:").to_string(), body)
            }
        };
        assert!(definitions.insert(name, fields(body)).is_none(), "twice");
    }
    (root, definitions)
}

fn fields(body: &str) -> Fields {
    let lines = body.lines().filter_map(|l| l.split('#').next());
    let words = lines.map(|l| l.split_whitespace().collect::<Vec<_>>());
    words
        .filter(|w| w.len() >= 2 && !w[1].contains('=') && w.get(2) != Some(&"="))
        .map(|w| (w[0].to_string(), w[1].to_string()))
        .collect()
}

/// Walks CDR bytes by a schema alone and prints what it meets.
struct Walker<'a> {
    definitions: BTreeMap<String, Fields>,
    body: &'a [u8],
    at: usize,
    seen: Vec<String>,
}

impl Walker<'_> {
    fn take(&mut self, size: usize) -> u64 {
        self.at = self.at.next_multiple_of(size);
        let mut value = [0; 8];
        value[..size].copy_from_slice(&self.body[self.at..self.at + size]);
        self.at += size;
        u64::from_le_bytes(value)
    }

    fn value(&mut self, kind: &str, package: &str, path: &str) {
        if let Some((element, count)) = kind.strip_suffix(']').and_then(|k| k.split_once('[')) {
            let count = match count.parse() {
                Ok(fixed) => fixed,
                Err(_) => self.take(4),
            };
            (0..count).for_each(|i| self.value(element, package, &format!("{path}[{i}]")));
            return;
        }
        let shown = match kind {
            "bool" | "uint8" | "int8" | "byte" => self.take(1).to_string(),
            "int16" | "uint16" => self.take(2).to_string(),
            "int32" | "uint32" => self.take(4).to_string(),
            "int64" | "uint64" => self.take(8).to_string(),
            "float32" => f32::from_bits(self.take(4) as u32).to_string(),
            "float64" => f64::from_bits(self.take(8)).to_string(),
            "string" => {
                let length = self.take(4) as usize;
                let text = &self.body[self.at..self.at + length - 1];
                assert_eq!(self.body[self.at + length - 1], 0);
                self.at += length;
                String::from_utf8(text.to_vec()).expect("UTF-8")
            }
            nested => return self.nested(nested, package, path),
        };
        self.seen.push(format!("{path} = {shown}"));
    }

    fn nested(&mut self, kind: &str, package: &str, path: &str) {
        let kind = match (kind, kind.contains('/')) {
            ("Header", _) => "std_msgs/Header".to_string(),
            (_, true) => kind.to_string(),
            (_, false) => format!("{package}/{kind}"),
        };
        let package = kind.split('/').next().expect("a package").to_string();
        for (kind, name) in self.definitions[&kind].clone() {
            self.value(&kind, &package, &format!("{path}.{name}"));
        }
    }
}

/// What an independent reader sees in an encoded message; it must use up every byte.
pub fn walk<M: Message>(message: &M) -> Vec<String> {
    let bytes = cdr::encode(message).expect("encodes");
    let (root, definitions) = parse(M::TYPE.name, M::TYPE.schema);
    let mut walker = Walker {
        definitions,
        body: &bytes[4..],
        at: 0,
        seen: vec![],
    };
    let package = root.split('/').next().expect("a package").to_string();
    walker.nested(&root, &package, "");
    assert_eq!(
        walker.at,
        walker.body.len(),
        "{}: bytes left over",
        M::TYPE.name
    );
    walker.seen
}
