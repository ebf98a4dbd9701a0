//! The walk of a value's serialisation.

use core::fmt;
use core::mem::{size_of, size_of_val};

use serde::Serialize;
use serde::ser::{
    SerializeMap, SerializeSeq, SerializeStruct, SerializeStructVariant, SerializeTuple,
    SerializeTupleStruct, SerializeTupleVariant, Serializer,
};

use crate::values::ReadingValues;

/// The bytes that a value has on the heap, to some 16 %. An element of a list is seen through a reference, and counts as much besides
/// its parts, unless it is a number: that stands for padding, and is too little of texts, of which states have few.
pub(crate) fn of<T: Serialize>(value: &T) -> usize {
    let mut heap = 0;
    // No type of a state refuses to be written, as the fingerprint shows.
    let _ = value.serialize(Place { heap: &mut heap, room: size_of::<T>(), number: None });
    heap
}

/// The place of a value in its owner.
struct Place<'a> {
    heap: &'a mut usize,
    /// The number of bytes of the place.
    room: usize,
    /// Where the size of a number is noted that is all of it.
    number: Option<&'a mut usize>,
}

/// A value of several parts.
struct Parts<'a> {
    place: Place<'a>,
    /// Bytes of the parts so far.
    bytes: usize,
    /// Whether it is a list, whose elements are elsewhere.
    is_list: bool,
    /// Whether the last part was as large as a number of a reading.
    is_of_words: bool,
}

impl<'a> Place<'a> {
    /// Adds bytes that are there, or behind a pointer that is.
    fn has(&mut self, bytes: usize) {
        if bytes > self.room {
            *self.heap += bytes;
        }
    }

    fn parts(self, is_list: bool) -> Parts<'a> {
        Parts { place: self, bytes: 0, is_list, is_of_words: false }
    }

    fn value<T: Serialize + ?Sized>(mut self, value: &T) -> Result<(), fmt::Error> {
        let room = size_of_val(value);
        self.has(room);
        value.serialize(Place { heap: self.heap, room, number: None })
    }
}

impl Parts<'_> {
    fn part<T: Serialize + ?Sized>(&mut self, part: &T) -> Result<(), fmt::Error> {
        let room = size_of_val(part);
        self.is_of_words = room == size_of::<f64>();
        let mut size = room;
        part.serialize(Place { heap: self.place.heap, room, number: Some(&mut size) })?;
        self.bytes += if self.is_list { size } else { room };
        Ok(())
    }

    fn finish(mut self) {
        let is_small = self.is_list && self.place.room == size_of::<ReadingValues>() && self.is_of_words;
        let is_inside = is_small && self.bytes <= SMALL;
        if self.is_list && !is_inside && LISTS.contains(&self.place.room) {
            self.place.room = 0;
        }
        self.place.has(self.bytes);
    }
}

/// Sizes of lists whose elements are on the heap however few they are: `Vec`, `VecDeque`. One of another size that has room for its
/// elements has them in itself.
const LISTS: [usize; 2] = [3 * size_of::<usize>(), 4 * size_of::<usize>()];

/// Bytes that the values of a reading have room for in themselves: a list that small may be one.
const SMALL: usize = 2 * size_of::<f64>();

macro_rules! plain {
    ($($method:ident: $type:ty),*) => {
        $(fn $method(mut self, _: $type) -> Result<(), fmt::Error> {
            self.has(size_of::<$type>());
            if let Some(number) = self.number {
                *number = size_of::<$type>();
            }
            Ok(())
        })*
    };
}

/// A type with several parts, and whether it is a list.
macro_rules! parts {
    ($($method:ident($($type:ty),*): $is_list:literal),*) => {
        $(fn $method(self, $(_: $type),*) -> Result<Self::SerializeSeq, fmt::Error> {
            Ok(self.parts($is_list))
        })*
    };
}

impl<'a> Serializer for Place<'a> {
    type Ok = ();
    type Error = fmt::Error;
    type SerializeSeq = Parts<'a>;
    type SerializeTuple = Parts<'a>;
    type SerializeTupleStruct = Parts<'a>;
    type SerializeTupleVariant = Parts<'a>;
    type SerializeMap = Parts<'a>;
    type SerializeStruct = Parts<'a>;
    type SerializeStructVariant = Parts<'a>;

    plain!(
        serialize_bool: bool, serialize_i8: i8, serialize_i16: i16, serialize_i32: i32, serialize_i64: i64, serialize_i128: i128,
        serialize_u8: u8, serialize_u16: u16, serialize_u32: u32, serialize_u64: u64, serialize_u128: u128, serialize_f32: f32,
        serialize_f64: f64, serialize_char: char
    );

    fn serialize_str(self, text: &str) -> Result<(), fmt::Error> {
        *self.heap += text.len();
        Ok(())
    }

    /// Buffers of bytes are of a fixed size, in their owner.
    fn serialize_bytes(mut self, bytes: &[u8]) -> Result<(), fmt::Error> {
        self.has(bytes.len());
        Ok(())
    }

    fn serialize_none(self) -> Result<(), fmt::Error> {
        Ok(())
    }

    fn serialize_some<T: Serialize + ?Sized>(self, value: &T) -> Result<(), fmt::Error> {
        self.value(value)
    }

    fn serialize_unit(self) -> Result<(), fmt::Error> {
        Ok(())
    }

    fn serialize_unit_struct(self, _: &'static str) -> Result<(), fmt::Error> {
        Ok(())
    }

    fn serialize_unit_variant(self, _: &'static str, _: u32, _: &'static str) -> Result<(), fmt::Error> {
        Ok(())
    }

    fn serialize_newtype_struct<T: Serialize + ?Sized>(
        self,
        name: &'static str,
        value: &T,
    ) -> Result<(), fmt::Error> {
        if name == super::NO_MEMORY { Ok(()) } else { self.value(value) }
    }

    fn serialize_newtype_variant<T: Serialize + ?Sized>(
        self,
        _: &'static str,
        _: u32,
        _: &'static str,
        value: &T,
    ) -> Result<(), fmt::Error> {
        self.value(value)
    }

    parts!(
        serialize_seq(Option<usize>): true, serialize_tuple(usize): false, serialize_tuple_struct(&'static str, usize): false,
        serialize_tuple_variant(&'static str, u32, &'static str, usize): false, serialize_map(Option<usize>): false,
        serialize_struct(&'static str, usize): false, serialize_struct_variant(&'static str, u32, &'static str, usize): false
    );

    fn collect_str<T: fmt::Display + ?Sized>(self, _: &T) -> Result<(), fmt::Error> {
        Ok(())
    }

    fn is_human_readable(&self) -> bool {
        false
    }
}

/// Each part of it, which may come with a name.
macro_rules! each_part {
    ($($kind:ident: $method:ident($($name:ty)?)),*) => {
        $(impl $kind for Parts<'_> {
            type Ok = ();
            type Error = fmt::Error;

            fn $method<T: Serialize + ?Sized>(&mut self, $(_: $name,)? part: &T) -> Result<(), fmt::Error> {
                self.part(part)
            }

            fn end(self) -> Result<(), fmt::Error> {
                self.finish();
                Ok(())
            }
        })*
    };
}

each_part!(
    SerializeSeq: serialize_element(), SerializeTuple: serialize_element(), SerializeTupleStruct: serialize_field(),
    SerializeTupleVariant: serialize_field(), SerializeStruct: serialize_field(&'static str),
    SerializeStructVariant: serialize_field(&'static str)
);

/// Only [optional parts](crate::optional) are a map, which is a struct in memory.
impl SerializeMap for Parts<'_> {
    type Ok = ();
    type Error = fmt::Error;

    fn serialize_key<T: Serialize + ?Sized>(&mut self, _: &T) -> Result<(), fmt::Error> {
        Ok(())
    }

    fn serialize_value<T: Serialize + ?Sized>(&mut self, part: &T) -> Result<(), fmt::Error> {
        self.part(part)
    }

    fn end(self) -> Result<(), fmt::Error> {
        self.finish();
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use alloc::boxed::Box;
    use alloc::collections::VecDeque;
    use alloc::string::String;
    use alloc::vec;
    use alloc::vec::Vec;

    use super::*;

    #[derive(Serialize)]
    struct Owner {
        small: u8,
        many: Vec<[u16; 4]>,
        boxed: Option<Box<(u64, u64, u64)>>,
        texts: Vec<String>,
        last: VecDeque<u32>,
        array: [u64; 9],
    }

    #[test]
    fn what_is_behind_a_pointer_is_counted_and_what_is_in_its_owner_is_not() {
        let mut owner = Owner {
            small: 1,
            many: Vec::new(),
            boxed: None,
            texts: Vec::new(),
            last: VecDeque::new(),
            array: [0; 9],
        };
        assert_eq!(of(&owner), 0);
        owner.many = vec![[0; 4]; 3];
        assert_eq!(of(&owner), 24);
        owner.boxed = Some(Box::new((1, 2, 3)));
        assert_eq!(of(&owner), 24 + 24);
        // An element is seen through a reference: of one that is a text the pointer is counted, and no length or capacity; of a number, itself.
        owner.texts = vec!["abc".into(), String::new(), String::new()];
        assert_eq!(of(&owner), 48 + 3 + 3 * size_of::<&String>());
        owner.last = [1, 2, 3].into();
        assert_eq!(of(&owner), 48 + 3 + 3 * size_of::<&String>() + 3 * size_of::<u32>());
        let (small, array) = (owner.small, owner.array);
        assert_eq!((small, array), (1, [0; 9]));
    }
}
