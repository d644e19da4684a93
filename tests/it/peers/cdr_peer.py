#!/usr/bin/env python3
"""Another vendor's CDR beside ours: Cyclone DDS, with types built from the schema text alone.

Reads JSON lines {"name", "schema", "value", "cdr"}: a message type, its ros2msg schema, a value, and our bytes for it.
Answers each with {"same", "back", "cyclone", "big_endian"}: whether Cyclone's little-endian bytes are ours, whether
it reads our bytes back as the value, its bytes if not the same, and its big-endian bytes, all in hexadecimal.
"""
import json
import sys

from cyclonedds.idl import Endianness, make_idl_struct, types
from cyclonedds.idl.annotations import final

PRIMITIVES = {
    "bool": bool, "byte": types.uint8, "char": types.uint8, "float32": types.float32, "float64": types.float64,
    "string": str, **{name: getattr(types, name) for name in
                      ("int8", "uint8", "int16", "uint16", "int32", "uint32", "int64", "uint64")},
}
SEPARATOR = "=" * 80 + "\n"


def definitions(name, schema):
    """Fields of the root and of all nested types: name -> [(type, field)]."""
    parts, found = schema.split(SEPARATOR), {}
    for index, part in enumerate(parts):
        title, body = (name, part) if index == 0 else part.split("\n", 1)
        key = title.removeprefix("MSG: ").replace("/msg/", "/").replace("/srv/", "/")
        lines = (line.split("#")[0].split() for line in body.splitlines())
        fields = [(w[0], w[1]) for w in lines if len(w) >= 2 and "=" not in w[1] and w[2:3] != ["="]]
        # rosidl: a structure without members gets this one.
        found[key] = fields or [("uint8", "structure_needs_at_least_one_member")]
    return found


class Types:
    def __init__(self, name, schema):
        self.definitions = definitions(name, schema)
        self.classes = {}

    def split(self, kind):
        """Element type, and (count, is_fixed) of an array: (element, None) for a single value."""
        if not kind.endswith("]"):
            return kind, None
        element, count = kind[:-1].split("[")
        if count.isdigit():
            return element, (int(count), True)
        return element, (int(count[2:]) if count else None, False)

    def key(self, kind, package):
        if kind == "Header":
            return "std_msgs/Header"
        return kind if "/" in kind else f"{package}/{kind}"

    def idl(self, kind, package):
        element, many = self.split(kind)
        inner = PRIMITIVES.get(element) or self.struct(self.key(element, package))
        if many is None:
            return inner
        count, is_fixed = many
        if is_fixed:
            return types.array[inner, count]
        return types.sequence[inner, count] if count else types.sequence[inner]

    def struct(self, key):
        if key not in self.classes:
            package, name = key.split("/")
            fields = {field: self.idl(kind, package) for kind, field in self.definitions[key]}
            made = make_idl_struct(name, f"{package}.msg.dds_.{name}_", fields)
            self.classes[key] = final(made)
        return self.classes[key]

    def value(self, kind, package, given):
        element, many = self.split(kind)
        if many is None:
            return self.single(element, package, given)
        while many[1] and given and isinstance(given[0], list):
            given = [item for row in given for item in row]
        return [self.single(element, package, item) for item in given]

    def single(self, kind, package, given):
        if kind in PRIMITIVES:
            return given
        key = self.key(kind, package)
        package = key.split("/")[0]
        fields = {field: self.value(k, package, given[field]) for k, field in self.definitions[key]}
        return self.struct(key)(**fields)


def compare(case):
    kinds = Types(case["name"], case["schema"])
    key = next(iter(kinds.definitions))
    value = kinds.single(key, key.split("/")[0], case["value"])
    ours = bytes.fromhex(case["cdr"])
    little = value.serialize(endianness=Endianness.Little, use_version_2=False)
    big = value.serialize(endianness=Endianness.Big, use_version_2=False)
    back = kinds.struct(key).deserialize(ours)
    return {"same": little == ours, "back": back == value, "cyclone": little.hex(), "big_endian": big.hex()}


for line in sys.stdin:
    print(json.dumps(compare(json.loads(line))), flush=True)
