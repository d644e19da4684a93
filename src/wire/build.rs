//! Turns `msgs/msg/*.msg` and the standard ROS 2 types that toile speaks into plain serde structs, each with its
//! full `ros2msg` schema text and its RIHS01 hash. Parser, resolver, hash and the standard definitions (Jazzy)
//! are those of `hiroz-codegen`; its Rust output is not used. This is the package's build script, not a module.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::{env, fs};

use hiroz_codegen::hashing::{build_type_description_msg, calculate_hash, is_primitive_type};
use hiroz_codegen::parser::msg::parse_msg_file;
use hiroz_codegen::parser::srv::parse_srv_file;
use hiroz_codegen::resolver::Resolver;
use hiroz_codegen::types::{ArrayType, Constant, Field, FieldType, ParsedMessage};

#[path = "../node/build_id.rs"]
mod build_id;

type Failure = Box<dyn std::error::Error>;
/// Package and name of a message type.
type Key = (String, String);

/// Our own package; all of its messages are generated.
const OWN_PACKAGE: &str = "toile_msgs";
/// Definitions that `hiroz-codegen` does not bring, a folder per package; see the README there.
const INTERFACES: &str = "src/wire/interfaces";
/// The standard types that toile publishes or reads; what they contain follows.
const STANDARD: [(&str, &str); 12] = [
    ("diagnostic_msgs", "DiagnosticArray"),
    ("geometry_msgs", "Vector3Stamped"),
    ("geometry_msgs", "WrenchStamped"),
    ("moveit_msgs", "CollisionObject"),
    ("nav_msgs", "Odometry"),
    ("rcl_interfaces", "Log"),
    ("rosgraph_msgs", "Clock"),
    ("sensor_msgs", "PointCloud2"),
    // Service hashes contain it.
    ("service_msgs", "ServiceEventInfo"),
    ("std_msgs", "String"),
    ("tf2_msgs", "TFMessage"),
    ("visualization_msgs", "MarkerArray"),
];
/// Services, all of this package.
const SERVICE_PACKAGE: &str = "simulation_interfaces";
/// Between the parts of a concatenated schema, as rosbag2 writes it.
const SEPARATOR: &str =
    "================================================================================";

/// A message type as it is written out.
struct Type {
    /// As parsed, under the name of the Rust struct.
    parsed: ParsedMessage,
    /// Full ROS 2 name.
    name: String,
    hash: String,
}

/// A service type as it is written out.
struct Service {
    name: String,
    hash: String,
}

fn main() -> Result<(), Failure> {
    println!("cargo:rerun-if-changed=src/wire/build.rs");
    println!("cargo:rerun-if-changed=src/wire/interfaces");
    println!("cargo:rerun-if-changed=msgs/msg");
    println!("{}", build_id::lines()?.join("\n"));
    let mut services = vec![];
    for path in files(&format!("{INTERFACES}/{SERVICE_PACKAGE}/srv"))? {
        services.push(parse_srv_file(&path, SERVICE_PACKAGE)?);
    }
    let mut open = roots()?;
    for service in &services {
        open.extend(nested(&service.request).chain(nested(&service.response)));
    }
    let sources: BTreeMap<Key, ParsedMessage> = closure(open)?
        .into_iter()
        .map(|message| (key(&message), message))
        .collect();
    let mut resolver = Resolver::new(false);
    let messages = resolver.resolve_messages(sources.values().cloned().collect())?;
    let mut types: Vec<Type> = messages
        .into_iter()
        .filter(|m| m.parsed.package != "service_msgs")
        .map(|m| Type {
            name: format!("{}/msg/{}", m.parsed.package, m.parsed.name),
            hash: m.type_hash.to_rihs_string(),
            parsed: m.parsed,
        })
        .collect();
    let mut called = vec![];
    for service in services {
        let name = format!("{SERVICE_PACKAGE}/srv/{}", service.name);
        types.push(half(&service.request, format!("{name}_Request"), &sources)?);
        types.push(half(
            &service.response,
            format!("{name}_Response"),
            &sources,
        )?);
        let hash = resolver
            .resolve_service(service)?
            .type_hash
            .to_rihs_string();
        called.push(Service { name, hash });
    }
    types.sort_by(|a, b| a.name.cmp(&b.name));
    let out = PathBuf::from(env::var("OUT_DIR")?).join("messages.rs");
    fs::write(out, emit(&types, &called, &sources)?)?;
    Ok(())
}

/// Request or response of a service. Its hash is that of its own name, which the parser does not know.
fn half(
    message: &ParsedMessage,
    name: String,
    sources: &BTreeMap<Key, ParsedMessage>,
) -> Result<Type, Failure> {
    let mut inner = BTreeMap::new();
    for ((package, name), source) in sources {
        let description = build_type_description_msg(source, &BTreeMap::new())?.type_description;
        inner.insert(format!("{package}/{name}"), description);
    }
    let mut described = build_type_description_msg(message, &inner)?;
    described.type_description.type_name.clone_from(&name);
    Ok(Type {
        parsed: message.clone(),
        name,
        hash: calculate_hash(&described).to_rihs_string(),
    })
}

fn key(message: &ParsedMessage) -> Key {
    (message.package.clone(), message.name.clone())
}

/// The files of a folder in the order of their names.
fn files(folder: &str) -> Result<Vec<PathBuf>, Failure> {
    let entries: Result<Vec<_>, _> = fs::read_dir(folder)?.collect();
    let mut paths: Vec<_> = entries?.iter().map(|entry| entry.path()).collect();
    paths.sort();
    Ok(paths)
}

/// All of our messages and the standard ones by name.
fn roots() -> Result<BTreeSet<Key>, Failure> {
    let mut roots: BTreeSet<Key> = STANDARD
        .iter()
        .map(|(package, name)| (package.to_string(), name.to_string()))
        .collect();
    for path in files("msgs/msg")? {
        let stem = path.file_stem().and_then(|s| s.to_str());
        let name = stem.ok_or("a .msg file name that is not UTF-8")?;
        roots.insert((OWN_PACKAGE.to_string(), name.to_string()));
    }
    Ok(roots)
}

/// Parses the roots and everything that they contain.
fn closure(mut open: BTreeSet<Key>) -> Result<Vec<ParsedMessage>, Failure> {
    let mut done: BTreeMap<Key, ParsedMessage> = BTreeMap::new();
    while let Some(next) = open.pop_first() {
        let message = parse_msg_file(&path_of(&next), &next.0)?;
        open.extend(nested(&message).filter(|k| !done.contains_key(k) && *k != next));
        done.insert(next, message);
    }
    Ok(done.into_values().collect())
}

fn path_of((package, name): &Key) -> PathBuf {
    let file = format!("{name}.msg");
    let ours = Path::new(INTERFACES).join(package).join("msg").join(&file);
    match package.as_str() {
        OWN_PACKAGE => Path::new("msgs/msg").join(file),
        _ if ours.exists() => ours,
        _ => hiroz_codegen::bundled_assets_dir(false)
            .join(package)
            .join("msg")
            .join(file),
    }
}

/// The message types among the fields, in their order.
fn nested(message: &ParsedMessage) -> impl Iterator<Item = Key> + '_ {
    let types = message.fields.iter().map(|f| &f.field_type);
    types
        .filter(|t| !is_primitive_type(&t.base_type))
        .map(|t| (package_of(t, message), t.base_type.clone()))
}

fn package_of(field: &FieldType, within: &ParsedMessage) -> String {
    field.package.as_ref().unwrap_or(&within.package).clone()
}

/// One module per package, then the lists of all types.
fn emit(
    types: &[Type],
    services: &[Service],
    sources: &BTreeMap<Key, ParsedMessage>,
) -> Result<String, Failure> {
    let mut packages: BTreeMap<&str, Vec<&Type>> = BTreeMap::new();
    for kind in types {
        let members = packages.entry(&kind.parsed.package).or_default();
        members.push(kind);
    }
    let mut code = String::from("// Generated by src/wire/build.rs from the .msg definitions.\n");
    for (package, members) in &packages {
        writeln!(code, "/// Types of the ROS 2 package `{package}`.")?;
        writeln!(code, "pub mod {package} {{")?;
        for member in members {
            emit_struct(&mut code, member)?;
            emit_constants(&mut code, &member.parsed)?;
            emit_type(&mut code, member, &schema(&member.parsed, sources))?;
        }
        if *package == SERVICE_PACKAGE {
            services
                .iter()
                .try_for_each(|s| emit_service(&mut code, s))?;
        }
        writeln!(code, "}}")?;
    }
    emit_list(&mut code, types)?;
    Ok(code)
}

fn emit_struct(code: &mut String, Type { parsed, name, .. }: &Type) -> Result<(), Failure> {
    writeln!(code, "/// `{name}`; fields as in its definition.")?;
    writeln!(
        code,
        "#[derive(Clone, Debug, Default, PartialEq, serde::Serialize, serde::Deserialize)]"
    )?;
    writeln!(code, "pub struct {} {{", parsed.name)?;
    for field in &parsed.fields {
        writeln!(code, "/// `{}`", definition_line(parsed, field))?;
        if is_bytes(&field.field_type) {
            writeln!(code, "#[serde(with = \"crate::wire::cdr::bytes\")]")?;
        }
        let escape = if field.name == "type" { "r#" } else { "" };
        let kind = rust_type(&field.field_type, parsed)?;
        writeln!(code, "pub {escape}{}: {kind},", field.name)?;
    }
    if parsed.fields.is_empty() {
        writeln!(code, "/// What ROS 2 sends in place of nothing.")?;
        writeln!(code, "pub structure_needs_at_least_one_member: u8,")?;
    }
    writeln!(code, "}}")?;
    Ok(())
}

fn emit_constants(code: &mut String, message: &ParsedMessage) -> Result<(), Failure> {
    let numbers = message
        .constants
        .iter()
        .filter(|c| c.const_type != "string");
    writeln!(code, "impl {} {{", message.name)?;
    for Constant {
        name,
        const_type,
        value,
    } in numbers
    {
        let kind = primitive(const_type).ok_or_else(|| format!("a constant of {const_type}"))?;
        writeln!(
            code,
            "/// As in the definition.\npub const {name}: {kind} = {value};"
        )?;
    }
    writeln!(code, "}}")?;
    Ok(())
}

/// The field's line in the `.msg`, with its comment (which holds the unit).
fn definition_line(message: &ParsedMessage, field: &Field) -> String {
    let is_field = |line: &&str| line.split_whitespace().nth(1) == Some(&field.name);
    let mut lines = message.source.lines().map(str::trim);
    let line = lines.find(|l| !l.starts_with('#') && is_field(l));
    line.unwrap_or(&field.name).replace('`', "'")
}

/// Byte sequences travel as one block instead of byte by byte.
fn is_bytes(field: &FieldType) -> bool {
    matches!(field.base_type.as_str(), "uint8" | "byte") && field.array == ArrayType::Unbounded
}

fn primitive(name: &str) -> Option<&'static str> {
    Some(match name {
        "bool" => "bool",
        "byte" | "uint8" => "u8",
        "int8" => "i8",
        "uint16" => "u16",
        "int16" => "i16",
        "uint32" => "u32",
        "int32" => "i32",
        "uint64" => "u64",
        "int64" => "i64",
        "float32" => "f32",
        "float64" => "f64",
        _ => return None,
    })
}

fn rust_type(field: &FieldType, within: &ParsedMessage) -> Result<String, Failure> {
    let element = match field.base_type.as_str() {
        "string" if field.string_bound.is_none() => "::std::string::String".to_string(),
        name if is_primitive_type(name) => primitive(name)
            .ok_or_else(|| format!("{}: no mapping for {name}", within.name))?
            .to_string(),
        nested => format!("super::{}::{nested}", package_of(field, within)),
    };
    match field.array {
        ArrayType::Single => Ok(element),
        // A bound does not show in the bytes; whoever reads a bounded sequence checks its length.
        ArrayType::Unbounded | ArrayType::Bounded(_) => Ok(format!("Vec<{element}>")),
        ArrayType::Fixed(n) if n <= 32 => Ok(format!("[{element}; {n}]")),
        // serde knows arrays up to 32; the bytes of a nested one are the same.
        ArrayType::Fixed(36) => Ok(format!("[[{element}; 6]; 6]")),
        ref other => Err(format!("{}: no mapping for {other:?}", within.name).into()),
    }
}

/// The definition followed by those of all nested types, as `ros2msg` wants it.
fn schema(root: &ParsedMessage, sources: &BTreeMap<Key, ParsedMessage>) -> String {
    let mut text = root.source.trim_end().to_string();
    let mut seen = BTreeSet::from([key(root)]);
    let mut open: Vec<Key> = nested(root).collect();
    open.reverse();
    while let Some(next) = open.pop() {
        if !seen.insert(next.clone()) {
            continue;
        }
        let message = &sources[&next];
        let (package, name) = &next;
        text += &format!("\n\n{SEPARATOR}\nMSG: {package}/{name}\n");
        text += message.source.trim_end();
        let inner: Vec<Key> = nested(message).collect();
        open.extend(inner.into_iter().rev());
    }
    text + "\n"
}

fn emit_type(code: &mut String, kind: &Type, schema: &str) -> Result<(), Failure> {
    let Type { parsed, name, hash } = kind;
    writeln!(code, "impl crate::wire::Message for {} {{", parsed.name)?;
    writeln!(code, "const TYPE: &'static crate::wire::MessageType =")?;
    writeln!(
        code,
        "&crate::wire::MessageType {{ name: {name:?}, schema: {schema:?}, hash: {hash:?} }};\n}}"
    )?;
    Ok(())
}

fn emit_service(code: &mut String, Service { name, hash }: &Service) -> Result<(), Failure> {
    let short = name.rsplit('/').next().unwrap_or(name);
    let half = |which: &str| format!("<{short}{which} as crate::wire::Message>::TYPE");
    writeln!(code, "/// `{name}`.")?;
    writeln!(code, "pub enum {short} {{}}")?;
    writeln!(code, "impl crate::wire::Service for {short} {{")?;
    writeln!(code, "type Request = {short}Request;")?;
    writeln!(code, "type Response = {short}Response;")?;
    writeln!(code, "const TYPE: &'static crate::wire::ServiceType =")?;
    writeln!(
        code,
        "&crate::wire::ServiceType {{ name: {name:?}, request: {}, response: {}, hash: {hash:?} }};\n}}",
        half("Request"),
        half("Response")
    )?;
    Ok(())
}

fn emit_list(code: &mut String, types: &[Type]) -> Result<(), Failure> {
    writeln!(
        code,
        "/// Every message type, sorted by name; requests and responses of services are among them."
    )?;
    writeln!(code, "pub const ALL: &[&crate::wire::MessageType] = &[")?;
    for Type { parsed, .. } in types {
        writeln!(
            code,
            "<{}::{} as crate::wire::Message>::TYPE,",
            parsed.package, parsed.name
        )?;
    }
    writeln!(code, "];")?;
    Ok(())
}
