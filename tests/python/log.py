"""Reads logs of Armbridge with the packages `mcap` and
`mcap-protobuf-support`, and no code of Armbridge.

    log.py all LOG          every topic, message by message; a summary as JSON
    log.py killed LOG...    files without an end; the last board time of each
    log.py sdk LOG          drawn topics once more through `foxglove-sdk`
"""

import json
import struct
import sys

from mcap.exceptions import McapError
from mcap.reader import NonSeekingReader, make_reader
from mcap.stream_reader import StreamReader
from mcap.records import Attachment, Metadata
from mcap_protobuf.decoder import DecoderFactory

from topics import TOPICS


def everything(path):
    """Every message of an intact log, by its index."""
    with open(path, "rb") as file:
        reader = make_reader(file, decoder_factories=[DecoderFactory()])
        summary = reader.get_summary()
        assert summary is not None and summary.statistics is not None, "no summary"
        for channel in summary.channels.values():
            schema = summary.schemas[channel.schema_id]
            assert TOPICS[channel.topic] == schema.name, channel.topic
            assert schema.encoding == channel.message_encoding == "protobuf"
        counts = dict.fromkeys(TOPICS, 0)
        latest = dict.fromkeys(TOPICS, 0)
        ticks, kinds, keys, frames = [], set(), {}, set()
        for _, channel, message, decoded in reader.iter_decoded_messages():
            counts[channel.topic] += 1
            assert message.log_time >= latest[channel.topic], "time goes back"
            latest[channel.topic] = message.log_time
            if channel.topic == "/telemetry":
                ticks.append(decoded.tick)
                for field in ("angle_rad_1", "angle_rad_2", "torque_nm_1", "torque_nm_2"):
                    assert decoded.HasField(field), field
            elif channel.topic in ("/events", "/commands"):
                kinds.add(decoded.kind)
                if decoded.HasField("exact"):
                    json.loads(decoded.exact.json)
            elif channel.topic == "/parameters":
                keys = {p.key: (list(p.numbers), p.unit) for p in decoded.parameters}
            elif channel.topic == "/tf":
                frames |= {(t.parent_frame_id, t.child_frame_id) for t in decoded.transforms}
        assert sum(counts.values()) == summary.statistics.message_count
        metadata = {m.name: m.metadata for m in reader.iter_metadata()}
        attachments = [a for a in reader.iter_attachments()]
    raw = sum(len(a.data) for a in attachments)
    with open(path, "rb") as file:
        # Checks every sum: of chunks, of attachments, and of all the data.
        for _ in StreamReader(file, validate_crcs=True).records:
            pass
    print(
        json.dumps(
            {
                "counts": counts,
                "gaps": sum(b - a - 1 for a, b in zip(ticks, ticks[1:])),
                "kinds": sorted(kinds),
                "parameters": len(keys),
                "l1_m": keys.get("arm.l1_m"),
                "frames": sorted(frames),
                "metadata": {name: sorted(values) for name, values in metadata.items()},
                "attachments": len(attachments),
                "raw_bytes": raw,
            }
        )
    )


def killed(paths):
    """What can be read of files that end in the middle of something."""
    for path in paths:
        last_ns, count = 0, 0
        with open(path, "rb") as file:
            reader = NonSeekingReader(file, decoder_factories=[DecoderFactory()])
            messages = reader.iter_decoded_messages(log_time_order=False)
            try:
                for _, channel, message, decoded in messages:
                    if channel.topic == "/telemetry":
                        last_ns, count = decoded.host_ns, count + 1
            except (McapError, EOFError, struct.error):
                # Its end: what stands before has been read.
                pass
        print(json.dumps({"path": path, "ticks": count, "last_ns": last_ns}))


def sdk(path):
    """Frames and joints as the SDK makes them are, byte by byte, what the log has."""
    import foxglove.messages as messages

    checked = 0
    with open(path, "rb") as file:
        reader = make_reader(file, decoder_factories=[DecoderFactory()])
        for schema, _, message, decoded in reader.iter_decoded_messages(topics=["/tf", "/joint_states"]):
            stamp = messages.Timestamp
            if schema.name == "foxglove.JointStates":
                made = messages.JointStates(
                    timestamp=stamp(decoded.timestamp.seconds, decoded.timestamp.nanos),
                    joints=[
                        messages.JointState(
                            name=j.name, position=j.position, velocity=j.velocity, effort=j.effort
                        )
                        for j in decoded.joints
                    ],
                )
            else:
                made = messages.FrameTransforms(
                    transforms=[
                        messages.FrameTransform(
                            timestamp=stamp(t.timestamp.seconds, t.timestamp.nanos),
                            parent_frame_id=t.parent_frame_id,
                            child_frame_id=t.child_frame_id,
                            translation=messages.Vector3(
                                x=t.translation.x, y=t.translation.y, z=t.translation.z
                            ),
                            rotation=messages.Quaternion(
                                x=t.rotation.x, y=t.rotation.y, z=t.rotation.z, w=t.rotation.w
                            ),
                        )
                        for t in decoded.transforms
                    ]
                )
            assert made.encode() == message.data, schema.name
            own = type(made).get_schema()
            assert own.name == schema.name and own.data == schema.data, schema.name
            checked += 1
    print(json.dumps({"checked": checked}))


if __name__ == "__main__":
    what, *paths = sys.argv[1:]
    if what == "all":
        everything(paths[0])
    elif what == "sdk":
        sdk(paths[0])
    else:
        killed(paths)
