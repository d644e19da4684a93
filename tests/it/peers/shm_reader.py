import ctypes, sys
import iceoryx2 as iox2, numpy as np
from rosbags.typesys import Stores, get_typestore

class ToileHeader(ctypes.Structure):
    _fields_ = [(name, ctypes.c_uint64) for name in ("abi", "sequence", "stamp", "step", "digest")]
    _fields_ += [("schema", ctypes.c_uint8 * 32)]

run, count = sys.argv[1], int(sys.argv[2])  # such as toile 100
types = get_typestore(Stores.ROS2_JAZZY)
node = iox2.NodeBuilder.new().create(iox2.ServiceType.Ipc)
state = node.service_builder(iox2.ServiceName.new(f"toile/{run}/state"))
state = state.publish_subscribe(iox2.Slice[ctypes.c_uint8]).user_header(ToileHeader).open().subscriber_builder().create()
published = node.service_builder(iox2.ServiceName.new(f"toile/{run}/published")).event().open().listener_builder().create()
for _ in range(count):
    while (sample := state.receive()) is None:
        published.timed_wait(iox2.Duration.from_secs(1))
    header, length = sample.user_header().contents, sample.header.number_of_elements
    cloud = types.deserialize_cdr(ctypes.string_at(sample.payload_ptr, length), "sensor_msgs/msg/PointCloud2")
    points = np.frombuffer(cloud.data, "<f4").reshape(-1, 6)  # x y z vx vy vz of every vertex
    print(header.sequence, header.step, f"{header.digest:016x}", len(points), points[:, 2].min())
