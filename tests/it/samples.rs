//! Values for any message type, drawn at random from a seed: a serde deserializer that reads no bytes but makes
//! up what it is asked for. Not tests, but what tests of every type at once are fed with.

use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;
use serde::de::value::Error;
use serde::de::{DeserializeSeed, Deserializer, Error as _, SeqAccess, Visitor};
use serde::forward_to_deserialize_any;
use toile::wire::Message;

/// Longest sequence and text; no bounded sequence of ours has a smaller bound.
const LONGEST: usize = 3;
const LETTERS: [&str; 6] = ["a", "Z", "_", " ", "é", "漢"];

/// A value of a type: the same seed, the same value.
pub fn sample<M: Message>(seed: u64) -> M {
    let mut source = Source(Pcg64::seed_from_u64(seed));
    M::deserialize(&mut source).expect("every field is of a known kind")
}

struct Source(Pcg64);

/// So many values of one source.
struct Several<'a>(&'a mut Source, usize);

impl<'de> SeqAccess<'de> for Several<'_> {
    type Error = Error;

    fn next_element_seed<T: DeserializeSeed<'de>>(
        &mut self,
        seed: T,
    ) -> Result<Option<T::Value>, Error> {
        let Some(left) = self.1.checked_sub(1) else {
            return Ok(None);
        };
        self.1 = left;
        seed.deserialize(&mut *self.0).map(Some)
    }
}

macro_rules! numbers {
    ($($method:ident $visit:ident $kind:ty),*) => {
        $(fn $method<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Error> {
            visitor.$visit(self.0.random::<$kind>())
        })*
    };
}

impl<'de> Deserializer<'de> for &mut Source {
    type Error = Error;

    numbers! {
        deserialize_bool visit_bool bool,
        deserialize_u8 visit_u8 u8,
        deserialize_i8 visit_i8 i8,
        deserialize_u16 visit_u16 u16,
        deserialize_i16 visit_i16 i16,
        deserialize_u32 visit_u32 u32,
        deserialize_i32 visit_i32 i32,
        deserialize_u64 visit_u64 u64,
        deserialize_i64 visit_i64 i64
    }

    fn deserialize_f32<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Error> {
        visitor.visit_f32(self.0.random_range(-1e6..1e6))
    }

    fn deserialize_f64<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Error> {
        let exponent = self.0.random_range(-300..300);
        visitor.visit_f64(self.0.random_range(-1.0..1.0) * 10_f64.powi(exponent))
    }

    fn deserialize_str<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Error> {
        self.deserialize_string(visitor)
    }

    fn deserialize_string<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Error> {
        let length = self.0.random_range(0..=LONGEST);
        let letter = |_| LETTERS[self.0.random_range(0..LETTERS.len())];
        visitor.visit_string((0..length).map(letter).collect())
    }

    fn deserialize_bytes<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Error> {
        let length = self.0.random_range(0..=LONGEST);
        let block: Vec<u8> = (0..length).map(|_| self.0.random()).collect();
        visitor.visit_bytes(&block)
    }

    fn deserialize_seq<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Error> {
        let length = self.0.random_range(0..=LONGEST);
        visitor.visit_seq(Several(self, length))
    }

    fn deserialize_tuple<V: Visitor<'de>>(
        self,
        length: usize,
        visitor: V,
    ) -> Result<V::Value, Error> {
        visitor.visit_seq(Several(self, length))
    }

    fn deserialize_struct<V: Visitor<'de>>(
        self,
        _: &'static str,
        fields: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value, Error> {
        visitor.visit_seq(Several(self, fields.len()))
    }

    fn deserialize_any<V: Visitor<'de>>(self, _: V) -> Result<V::Value, Error> {
        Err(Error::custom("a kind that no message has"))
    }

    forward_to_deserialize_any! {
        char byte_buf option unit unit_struct newtype_struct tuple_struct map enum identifier ignored_any
    }
}
