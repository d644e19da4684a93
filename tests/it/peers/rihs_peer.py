#!/usr/bin/env python3
"""Type hashes (REP 2011) of another implementation, rosbags, from the schema text alone.

Reads JSON lines {"name", "schema"} for a message, {"name", "request", "response"} with two schemas for a service;
answers each with its RIHS01 hash. What a schema does not define is that of ROS 2 Jazzy.
"""
import json
import sys

from rosbags.interfaces import Nodetype
from rosbags.typesys import Stores, get_types_from_msg, get_typestore


def learn(store, name, schema):
    """Adds a type and what it contains; the parser wants every name to be that of a message."""
    package, kind, short = name.split("/")
    found = get_types_from_msg(schema, f"{package}/msg/{short}")
    store.fielddefs.update({f"{package}/{kind}/{short}" if key.endswith(f"/{short}") else key: value
                            for key, value in found.items()})


def service(store, name, request, response):
    def one(suffix):
        return (Nodetype.NAME, f"{name}{suffix}")

    def at_most_one(suffix):
        return (Nodetype.SEQUENCE, (one(suffix), 1))

    learn(store, f"{name}_Request", request)
    learn(store, f"{name}_Response", response)
    # In a .msg, char is uint8 (rosidl); rosbags gives it an identity of its own.
    name_of_info = "service_msgs/msg/ServiceEventInfo"
    constants, fields = store.fielddefs[name_of_info]
    gid = (Nodetype.ARRAY, ((Nodetype.BASE, ("uint8", 0)), 16))
    store.fielddefs[name_of_info] = (constants, [(f, gid if f == "client_gid" else d) for f, d in fields])
    info = (Nodetype.NAME, name_of_info)
    store.fielddefs[f"{name}_Event"] = (
        [], [("info", info), ("request", at_most_one("_Request")), ("response", at_most_one("_Response"))])
    store.fielddefs[name] = ([], [("request_message", one("_Request")), ("response_message", one("_Response")),
                                  ("event_message", one("_Event"))])


for line in sys.stdin:
    case, store = json.loads(line), get_typestore(Stores.ROS2_JAZZY)
    if "schema" in case:
        learn(store, case["name"], case["schema"])
    else:
        service(store, case["name"], case["request"], case["response"])
    print(store.hash_rihs01(case["name"]), flush=True)
