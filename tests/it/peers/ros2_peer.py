#!/usr/bin/env python3
"""A second foreign DDS peer for toile's node, on Cyclone DDS: what dds_peer.py does not look at.

  ros2_peer.py graph NODE                    what ros_discovery_info and discovery say of a node, as JSON
  ros2_peer.py applied COUNT                 prints "ready", then COUNT messages of /toile/applied, a line of JSON each
  ros2_peer.py topology                      joins late and reads /toile/topology once: numbers of vertices, triangles
  ros2_peer.py state                         calls /toile/get_simulation_state (needs --service-mapping cyclone)
  ros2_peer.py step N                        calls /toile/step_simulation with N steps (the same)
  ros2_peer.py latency COUNT                 prints "ready", then the age of COUNT states [s], a line each
  ros2_peer.py hold                          subscribes /tf reliably, prints "ready", takes nothing, waits to be killed

Loopback only, domain of ROS_DOMAIN_ID. Exit 1 if it takes longer than --seconds.
"""
import argparse
import json
import os
import sys
import time
from dataclasses import dataclass

os.environ.setdefault("CYCLONEDDS_URI", """<CycloneDDS><Domain Id="any">
<General><Interfaces><NetworkInterface name="lo" multicast="false"/></Interfaces><AllowMulticast>false</AllowMulticast></General>
<Discovery><ParticipantIndex>auto</ParticipantIndex><MaxAutoParticipantIndex>11</MaxAutoParticipantIndex>
<Peers><Peer Address="127.0.0.1"/></Peers></Discovery></Domain></CycloneDDS>""")

from cyclonedds.builtin import BuiltinDataReader, BuiltinTopicDcpsPublication, BuiltinTopicDcpsSubscription
from cyclonedds.core import Policy, Qos
from cyclonedds.domain import DomainParticipant
from cyclonedds.idl import IdlStruct
from cyclonedds.idl.annotations import final
from cyclonedds.idl.types import array, float64, int32, int64, sequence, uint8, uint32, uint64
from cyclonedds.pub import DataWriter
from cyclonedds.sub import DataReader
from cyclonedds.topic import Topic
from cyclonedds.util import duration


def ros(package, name, kind="msg"):
    return f"{package}::{kind}::dds_::{name}_"


@dataclass
@final
class Gid(IdlStruct, typename=ros("rmw_dds_common", "Gid")):
    data: array[uint8, 16]


@dataclass
@final
class NodeEntitiesInfo(IdlStruct, typename=ros("rmw_dds_common", "NodeEntitiesInfo")):
    node_namespace: str
    node_name: str
    reader_gid_seq: sequence[Gid]
    writer_gid_seq: sequence[Gid]


@dataclass
@final
class ParticipantEntitiesInfo(IdlStruct, typename=ros("rmw_dds_common", "ParticipantEntitiesInfo")):
    gid: Gid
    node_entities_info_seq: sequence[NodeEntitiesInfo]


@dataclass
@final
class Time(IdlStruct, typename=ros("builtin_interfaces", "Time")):
    sec: int32
    nanosec: uint32


@dataclass
@final
class Header(IdlStruct, typename=ros("std_msgs", "Header")):
    stamp: Time
    frame_id: str


@dataclass
@final
class AppliedCommand(IdlStruct, typename=ros("toile_msgs", "AppliedCommand")):
    header: Header
    step: uint64
    channel: str
    type: str
    payload: sequence[uint8]
    accepted: bool
    reason: str


@dataclass
@final
class MeshTopology(IdlStruct, typename=ros("toile_msgs", "MeshTopology")):
    header: Header
    triangles: sequence[uint32]
    outline: sequence[float64]
    material: sequence[float64]


@dataclass
@final
class Result(IdlStruct, typename=ros("simulation_interfaces", "Result")):
    result: uint8
    error_message: str


@dataclass
@final
class SimulationState(IdlStruct, typename=ros("simulation_interfaces", "SimulationState")):
    state: uint8


# Cyclone's service mapping: client and number of the request stand in front of the message.
@dataclass
@final
class StateRequest(IdlStruct, typename=ros("simulation_interfaces", "GetSimulationState_Request", "srv")):
    client: uint64
    number: int64
    structure_needs_at_least_one_member: uint8


@dataclass
@final
class StateResponse(IdlStruct, typename=ros("simulation_interfaces", "GetSimulationState_Response", "srv")):
    client: uint64
    number: int64
    state: SimulationState
    result: Result


@dataclass
@final
class StepRequest(IdlStruct, typename=ros("simulation_interfaces", "StepSimulation_Request", "srv")):
    client: uint64
    number: int64
    steps: uint64


@dataclass
@final
class StepResponse(IdlStruct, typename=ros("simulation_interfaces", "StepSimulation_Response", "srv")):
    client: uint64
    number: int64
    result: Result


@dataclass
@final
class Unread(IdlStruct, typename=ros("tf2_msgs", "TFMessage")):
    data: sequence[uint8]


@dataclass
@final
class PointField(IdlStruct, typename=ros("sensor_msgs", "PointField")):
    name: str
    offset: uint32
    datatype: uint8
    count: uint32


@dataclass
@final
class PointCloud2(IdlStruct, typename=ros("sensor_msgs", "PointCloud2")):
    header: Header
    height: uint32
    width: uint32
    fields: sequence[PointField]
    is_bigendian: bool
    point_step: uint32
    row_step: uint32
    data: sequence[uint8]
    is_dense: bool


FIRM = Policy.Reliability.Reliable(duration(milliseconds=500))
RELIABLE = Qos(FIRM, Policy.History.KeepLast(1000))
LATCHED = Qos(FIRM, Policy.Durability.TransientLocal, Policy.History.KeepLast(16))
BEST_EFFORT = Qos(Policy.Reliability.BestEffort, Policy.History.KeepLast(64))


def samples(reader):
    """What has come that is data, and not the news of a writer that went."""
    return [s for s in reader.take(256) if not type(s).__name__.startswith("Invalid")]


def say(*words):
    print(*words, flush=True)


class Peer:
    def __init__(self, args):
        self.until = time.monotonic() + args.seconds
        self.participant = DomainParticipant(int(os.environ.get("ROS_DOMAIN_ID", 0)))

    def reader(self, topic, kind, qos):
        return DataReader(self.participant, Topic(self.participant, topic, kind), qos)

    def writer(self, topic, kind, qos):
        return DataWriter(self.participant, Topic(self.participant, topic, kind), qos)

    def wait(self, what, look):
        while True:
            found = look()
            if found:
                return found
            if time.monotonic() > self.until:
                sys.exit(f"no {what} in time")
            time.sleep(0.005)


def graph(peer, args):
    nodes = peer.reader("ros_discovery_info", ParticipantEntitiesInfo, LATCHED)
    ends = {"publishers": BuiltinDataReader(peer.participant, BuiltinTopicDcpsPublication),
            "subscribers": BuiltinDataReader(peer.participant, BuiltinTopicDcpsSubscription)}
    known, found = {}, {}

    def look():
        for reader in ends.values():
            known.update((s.key.bytes, (s.topic_name, s.type_name)) for s in samples(reader))
        for info in samples(nodes):
            for node in info.node_entities_info_seq:
                found[node.node_name] = node
        node = found.get(args.node)
        if node is None:
            return None
        gids = [bytes(g.data) for g in [*node.writer_gid_seq, *node.reader_gid_seq]]
        return node if gids and all(g in known for g in gids) else None

    node = peer.wait(f"node {args.node} with all its topics", look)
    topics = lambda gids: dict(sorted(known[bytes(g.data)] for g in gids))
    say(json.dumps({"namespace": node.node_namespace, "publishers": topics(node.writer_gid_seq),
                    "subscribers": topics(node.reader_gid_seq)}))


def applied(peer, args):
    reader = peer.reader("rt/toile/applied", AppliedCommand, RELIABLE)
    peer.wait("publisher of /toile/applied", reader.get_matched_publications)
    say("ready")
    left = args.count
    while left > 0:
        for message in peer.wait("command", lambda: samples(reader)):
            left -= 1
            say(json.dumps({"step": message.step, "channel": message.channel, "type": message.type,
                            "payload": bytes(message.payload).hex(), "accepted": message.accepted,
                            "reason": message.reason}))


def topology(peer, _):
    reader = peer.reader("rt/toile/topology", MeshTopology, LATCHED)
    message = peer.wait("topology", lambda: samples(reader))[0]
    say(json.dumps({"vertices": len(message.material) // 2, "triangles": len(message.triangles) // 3}))


def call(peer, service, request, kinds):
    writer = peer.writer(f"rq/toile/{service}Request", kinds[0], RELIABLE)
    reader = peer.reader(f"rr/toile/{service}Reply", kinds[1], RELIABLE)
    peer.wait(f"server of {service}", lambda: writer.get_matched_subscriptions() and reader.get_matched_publications())
    writer.write(request)
    mine = lambda: [r for r in samples(reader) if (r.client, r.number) == (request.client, request.number)]
    return peer.wait(f"answer of {service}", mine)[0]


def state(peer, _):
    answer = call(peer, "get_simulation_state", StateRequest(7, 1, 0), (StateRequest, StateResponse))
    say(json.dumps({"state": answer.state.state, "result": answer.result.result}))


def step(peer, args):
    answer = call(peer, "step_simulation", StepRequest(7, 2, args.count), (StepRequest, StepResponse))
    say(json.dumps({"result": answer.result.result, "message": answer.result.error_message}))


def latency(peer, args):
    reader = peer.reader("rt/toile/state", PointCloud2, BEST_EFFORT)
    peer.wait("publisher of /toile/state", reader.get_matched_publications)
    say("ready")
    left = args.count
    while left > 0:
        found = samples(reader)
        now = time.time_ns()
        for s in found:
            left -= 1
            say(s.header.stamp.sec, s.header.stamp.nanosec, now, s.sample_info.source_timestamp)
        if time.monotonic() > peer.until:
            sys.exit("too few states in time")
        time.sleep(0.0001)


def hold(peer, _):
    reader = peer.reader("rt/tf", Unread, RELIABLE)
    peer.wait("publisher of /tf", reader.get_matched_publications)
    say("ready")
    while time.monotonic() < peer.until:
        time.sleep(0.1)


parser = argparse.ArgumentParser()
parser.add_argument("--seconds", type=float, default=60)
verbs = parser.add_subparsers(dest="verb", required=True)
verbs.add_parser("graph").add_argument("node")
for verb in ("applied", "step", "latency"):
    verbs.add_parser(verb).add_argument("count", type=int)
for verb in ("topology", "state", "hold"):
    verbs.add_parser(verb)
arguments = parser.parse_args()
globals()[arguments.verb](Peer(arguments), arguments)
