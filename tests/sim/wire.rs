//! The book's chapter on the wire, `wire.json` for programs, and the test vectors in both: written
//! from the message types, and compared with the files.
//!
//! After a change of a message: `UPDATE_SNAPSHOT=1 cargo test -p armbridge-tests --test sim wire`.

use std::fmt::Write as _;
use std::fs;

use armbridge_link::frame::{Decoder, Encoder, Message};
use armbridge_link::message::{
    Command, Drive, Fault, Missing, Mode, Moment, Refusal, StopSource, ToBoard, ToHost,
};
use armbridge_link::motion::Motion;
use armbridge_link::schema::{HASH, HELLO};
use postcard_schema::Schema;
use postcard_schema::schema::{
    DataModelType as Type, DataModelVariant as Variant, NamedType, NamedValue, NamedVariant,
};
use serde::Serialize;
use serde::de::DeserializeOwned;
use serde_json::{Map, Value, json};

const CHAPTER: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../host/doc/src/wire.md");
const JSON: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../host/doc/clients/wire.json");
/// The part of the chapter that is written here is behind this line.
const MARK: &str = "<!-- Written by `tests/sim/wire.rs`. -->\n";

/// Types by name, in the order in which they are met.
#[derive(Default)]
struct Types(Vec<(&'static str, Value)>);

impl Types {
    /// The type's name, or its shape if it has none.
    fn refer(&mut self, named: &'static NamedType) -> Value {
        let shape = match named.ty {
            Type::Bool => return "bool".into(),
            Type::I8 => return "i8".into(),
            Type::U8 => return "u8".into(),
            Type::I16 => return "i16".into(),
            Type::I32 => return "i32".into(),
            Type::U16 => return "u16".into(),
            Type::U32 => return "u32".into(),
            Type::U64 => return "u64".into(),
            Type::F32 => return "f32".into(),
            Type::Unit => return Value::Null,
            Type::Option(inner) => return json!({"option": self.refer(inner)}),
            Type::Tuple(items) => return json!({"tuple": self.all(items)}),
            Type::NewtypeStruct(inner) => return self.refer(inner),
            Type::Enum(variants) if named.name.contains('<') => {
                return json!({"enum": self.variants(variants)});
            }
            shape => shape,
        };
        if !self.0.iter().any(|(name, _)| *name == named.name) {
            // Its place is before those of its parts.
            let place = self.0.len();
            self.0.push((named.name, Value::Null));
            self.0[place].1 = match shape {
                Type::Struct(fields) => json!({"struct": self.fields(fields)}),
                Type::Enum(variants) => json!({"enum": self.variants(variants)}),
                other => panic!("{}: {other:?} is on no wire", named.name),
            };
        }
        named.name.into()
    }

    fn all(&mut self, items: &[&'static NamedType]) -> Vec<Value> {
        items.iter().map(|item| self.refer(item)).collect()
    }

    fn fields(&mut self, fields: &[&'static NamedValue]) -> Vec<Value> {
        let fields = fields.iter();
        fields
            .map(|it| json!([it.name, self.refer(it.ty)]))
            .collect()
    }

    fn variants(&mut self, variants: &[&'static NamedVariant]) -> Vec<Value> {
        let mut content = |variant: &Variant| match variant {
            Variant::UnitVariant => Value::Null,
            Variant::NewtypeVariant(inner) | Variant::TupleVariant([inner]) => self.refer(inner),
            Variant::TupleVariant(items) => json!({"tuple": self.all(items)}),
            Variant::StructVariant(fields) => json!({"struct": self.fields(fields)}),
        };
        let variants = variants.iter();
        variants
            .map(|it| json!([it.name, content(it.ty)]))
            .collect()
    }
}

/// Frames of one direction, the first numbered 0.
fn vectors<M: Message + Serialize + DeserializeOwned + PartialEq + std::fmt::Debug + Copy>(
    messages: &[M],
) -> Vec<Value> {
    let (mut encoder, mut decoder) = (Encoder::default(), Decoder::default());
    let vector = |message: &M| {
        let (sequence, bytes) = encoder.encode(message);
        let received = bytes.iter().find_map(|byte| decoder.push::<M>(*byte));
        assert_eq!(received.unwrap().unwrap().message, *message);
        let hex = bytes
            .iter()
            .fold(String::new(), |text, byte| text + &format!("{byte:02x}"));
        json!({
            "direction": char::from(M::DIRECTION).to_string(),
            "sequence": sequence,
            "message": message,
            "frame": hex,
        })
    };
    messages.iter().map(vector).collect()
}

fn all_vectors() -> Vec<Value> {
    let moment = Moment {
        tick: 1_234,
        is_decided: true,
        at_us: 1_234_567,
        mode: Mode::Running(Drive::Regulate),
    };
    let to_board = [
        ToBoard::Hello(HELLO),
        ToBoard::Heartbeat,
        ToBoard::Command(Command::Arm {
            session: 305_419_896,
        }),
        ToBoard::Command(Command::Regulate([0.25, -0.5])),
        ToBoard::Command(Command::Torque([0.0, 0.125])),
        ToBoard::Command(Command::Follow(Motion::MinimumJerk {
            to_rad: [0.0, 0.5],
            duration_s: Some(1.5),
        })),
        ToBoard::Command(Command::Idle),
        ToBoard::Stop,
        ToBoard::Goodbye,
    ];
    let to_host = [
        ToHost::Hello(HELLO),
        ToHost::Ack {
            sequence: 300,
            result: Ok(()),
            moment: Some(moment),
        },
        ToHost::Ack {
            sequence: 301,
            result: Err(Refusal::Disarmed),
            moment: None,
        },
        ToHost::Absent {
            joint: 1,
            missing: Missing::Silence,
        },
        ToHost::Temperature {
            joint: 0,
            value: 300,
        },
        ToHost::Began(Moment {
            mode: Mode::Fault(Fault::EmergencyStop(StopSource::Host)),
            ..moment
        }),
    ];
    [vectors(&to_board), vectors(&to_host)].concat()
}

/// A type in one cell.
fn cell(shape: &Value) -> String {
    let list = |items: &Value, one: fn(&Value) -> String| {
        let items = items.as_array().unwrap();
        items.iter().map(one).collect::<Vec<_>>()
    };
    match shape {
        Value::Null => "–".into(),
        Value::String(name) if name.starts_with(|it: char| it.is_ascii_uppercase()) => {
            format!("[{name}](#{})", name.to_lowercase())
        }
        Value::String(name) => name.clone(),
        shape => {
            let (kind, inner) = shape.as_object().unwrap().iter().next().unwrap();
            let pair = |pair: &Value| format!("`{}` {}", pair[0].as_str().unwrap(), cell(&pair[1]));
            match kind.as_str() {
                "option" => format!("optional {}", cell(inner)),
                "tuple" => {
                    let items = list(inner, cell);
                    match &items[..] {
                        [first, rest @ ..] if rest.iter().all(|it| it == first) => {
                            format!("{} × {first}", items.len())
                        }
                        items => items.join(", "),
                    }
                }
                "struct" => list(inner, pair).join(", "),
                "enum" => {
                    let numbered = inner.as_array().unwrap().iter().enumerate();
                    let variants = numbered.map(|(byte, it)| format!("{byte} {}", pair(it)));
                    variants.collect::<Vec<_>>().join(" or ")
                }
                kind => panic!("{kind}"),
            }
        }
    }
}

fn chapter(types: &Types, vectors: &[Value]) -> String {
    let mut text = String::new();
    let hash = HASH.map(|byte| byte.to_string()).join(", ");
    writeln!(text, "Schema hash of this version: {hash}.\n\n## Types").unwrap();
    for (name, shape) in &types.0 {
        writeln!(text, "\n### {name}\n").unwrap();
        let (kind, rows) = shape.as_object().unwrap().iter().next().unwrap();
        let rows = rows.as_array().unwrap().iter().enumerate();
        let is_enum = kind == "enum";
        let head = if is_enum {
            "| byte | variant | content |\n|---|---|---|"
        } else {
            "| field | content |\n|---|---|"
        };
        writeln!(text, "{head}").unwrap();
        for (byte, row) in rows {
            let (name, content) = (row[0].as_str().unwrap(), cell(&row[1]));
            let byte = if is_enum {
                format!("{byte} | ")
            } else {
                String::new()
            };
            writeln!(text, "| {byte}`{name}` | {content} |").unwrap();
        }
    }
    text += "\n## Test vectors\n\nWhole frames of each direction, numbered from 0.\n\n| message | frame |\n|---|---|\n";
    for vector in vectors {
        let (direction, message) = (vector["direction"].as_str().unwrap(), &vector["message"]);
        let frame = vector["frame"].as_str().unwrap();
        writeln!(text, "| {direction} `{message}` | `{frame}` |").unwrap();
    }
    text
}

/// Compares a file with what it should be, or writes it.
fn check(path: &str, expected: &str) {
    if std::env::var_os("UPDATE_SNAPSHOT").is_some() {
        fs::write(path, expected).unwrap();
    }
    let is = fs::read_to_string(path).unwrap();
    assert!(
        is == expected,
        "{path} is not of the messages: run again with UPDATE_SNAPSHOT=1"
    );
}

#[test]
fn the_chapter_has_every_message_and_the_vectors() {
    let mut types = Types::default();
    types.refer(ToBoard::SCHEMA);
    types.refer(ToHost::SCHEMA);
    let vectors = all_vectors();
    let by_name: Map<String, Value> = types
        .0
        .iter()
        .map(|(name, shape)| ((*name).to_owned(), shape.clone()))
        .collect();
    let all = json!({"schema": HASH, "types": by_name, "vectors": vectors});
    check(JSON, &(serde_json::to_string(&all).unwrap() + "\n"));
    let prose = fs::read_to_string(CHAPTER).unwrap();
    let (prose, _) = prose.split_once(MARK).unwrap();
    check(
        CHAPTER,
        &format!("{prose}{MARK}\n{}", chapter(&types, &vectors)),
    );
}
