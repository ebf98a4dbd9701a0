"""Reads a recording with the readers of others: MCAP's own, and Foxglove's schemas.

    python3 xtask/tools/check_recording.py RUN.mcap [PART_OF_A_SENSOR'S_TOPIC]
"""

import importlib
import math
import sys
from collections import Counter

from mcap.reader import make_reader
from mcap_protobuf.decoder import DecoderFactory

NEEDED = {
    "/baudbot/header": "baudbot.v1.RecordingHeader",
    "/baudbot/state": "baudbot.v1.RecordedState",
    "/baudbot/inputs": "baudbot.v1.RecordedInputs",
    "/baudbot/marks": "baudbot.v1.RecordedMark",
    "/baudbot/frames": "baudbot.v1.WatchResponse",
    "/scene/arena": "foxglove.SceneUpdate",
    "/scene/robots": "foxglove.SceneUpdate",
    "/tf": "foxglove.FrameTransforms",
    "/log": "foxglove.Log",
}


def own(schema):
    """Foxglove's own class for one of its messages."""
    name = schema.name.removeprefix("foxglove.")
    return getattr(importlib.import_module(f"foxglove_schemas_protobuf.{name}_pb2"), name)


def check_tf(message, poses):
    for transform in message.transforms:
        rotation = transform.rotation
        length = math.hypot(rotation.x, rotation.y, rotation.z, rotation.w)
        assert abs(length - 1) < 1e-9, rotation
        if transform.child_frame_id.count("/") == 1 and transform.child_frame_id.startswith("robot/"):
            heading = 2 * math.atan2(rotation.z, rotation.w)
            poses[transform.child_frame_id] = (transform.translation.x, transform.translation.y, heading)


def main():
    path, scan = sys.argv[1], (sys.argv[2:] or [None])[0]
    counts, poses, compared, scans = Counter(), {}, 0, 0
    with open(path, "rb") as file:
        reader = make_reader(file, validate_crcs=True, decoder_factories=[DecoderFactory()])
        assert reader.get_header().profile == "baudbot"
        summary = reader.get_summary()
        topics = {channel.topic: summary.schemas[channel.schema_id].name for channel in summary.channels.values()}
        assert all(topics.get(topic) == schema for topic, schema in NEEDED.items()), topics
        assert summary.chunk_indexes and all(chunk.compression == "lz4" for chunk in summary.chunk_indexes)
        for schema, channel, raw, message in reader.iter_decoded_messages():
            counts[channel.topic] += 1
            if schema.name.startswith("foxglove."):
                theirs = own(schema)()
                theirs.ParseFromString(raw.data)
                # Nothing in it that their schema does not know: it comes out as long as it went in.
                assert len(theirs.SerializeToString()) == len(raw.data), channel.topic
            if channel.topic == "/tf":
                check_tf(message, poses)
            elif channel.topic == "/baudbot/frames" and poses:
                compared += 1
            elif scan and channel.topic.startswith("/scan/") and scan in channel.topic:
                scans += 1
                rays = len(message.ranges)
                assert rays > 1 and message.end_angle > message.start_angle, channel.topic
                assert all(distance > 0 for distance in message.ranges), channel.topic
    statistics = summary.statistics
    assert statistics.message_count == sum(counts.values())
    assert counts["/baudbot/header"] == 1 and counts["/baudbot/inputs"] > 10 and counts["/tf"] > 10, counts
    assert poses and compared > 10 and (not scan or scans), (poses, compared, scans)
    print(f"{path}: {statistics.message_count} messages on {len(counts)} topics in {len(summary.chunk_indexes)} chunks")


if __name__ == "__main__":
    main()
