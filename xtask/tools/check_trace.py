#!/usr/bin/env python3
"""Reads a trace with Perfetto's own schema and says what is in it: `check_trace.py FILE…`.

Fails if a packet has a field that the schema does not know, if an event is on a track that nobody described, if
slices do not nest, or if nothing happened.
"""

import sys
from collections import Counter

from perfetto.protos.perfetto.trace.perfetto_trace_pb2 import Trace, TrackEvent
from google.protobuf.unknown_fields import UnknownFieldSet


def main(paths):
    if not paths:
        sys.exit("usage: check_trace.py FILE…")
    for path in paths:
        with open(path, "rb") as file:
            trace = Trace.FromString(file.read())
        try:
            print(f"{path}: {check(trace)}")
        except ValueError as problem:
            sys.exit(f"{path}: {problem}")


def check(trace):
    """What is in a trace, in words."""
    tracks, processes = {}, 0
    events = []
    for packet in trace.packet:
        refuse_unknown(packet)
        if packet.HasField("track_descriptor"):
            track = packet.track_descriptor
            if track.uuid in tracks:
                raise ValueError(f"track {track.uuid} is described twice")
            processes += track.HasField("process")
            if track.HasField("parent_uuid") and track.parent_uuid not in tracks:
                raise ValueError(f"track {track.name} is described before its parent")
            tracks[track.uuid] = track.name or track.process.process_name
        if packet.HasField("track_event"):
            event = packet.track_event
            if event.track_uuid not in tracks:
                raise ValueError(f"an event at {packet.timestamp} ns is on a track that is not described")
            events.append((packet.timestamp, event))
    counts = nest(tracks, events)
    kinds = ", ".join(f"{name}: {count}" for name, count in sorted(counts.items()))
    return f"robots: {processes}, tracks: {len(tracks) - processes}, {kinds}"


def refuse_unknown(message):
    """Fails if there is a field in it, or in a message in it, that the schema does not know."""
    if len(UnknownFieldSet(message)):
        raise ValueError(f"{message.DESCRIPTOR.full_name} has a field {UnknownFieldSet(message)[0].field_number}")
    for field, value in message.ListFields():
        if field.message_type:
            for inner in [value] if not field.is_repeated else value:
                refuse_unknown(inner)


def nest(tracks, events):
    """Fails if slices do not nest. As Perfetto does, sorts by time and leaves the rest in the file's order."""
    open_slices = {uuid: [] for uuid in tracks}
    counts = Counter()
    for at, event in sorted(events, key=lambda pair: pair[0]):
        where = f"{tracks[event.track_uuid]} at {at} ns"
        stack = open_slices[event.track_uuid]
        if event.type == TrackEvent.TYPE_SLICE_END:
            if not stack:
                raise ValueError(f"{where}: an end without a begin")
            stack.pop()
            continue
        if event.type == TrackEvent.TYPE_COUNTER:
            counts["numbers"] += 1
            continue
        if not event.name or not event.categories:
            raise ValueError(f"{where}: an event without a name or a category")
        if event.type == TrackEvent.TYPE_SLICE_BEGIN:
            if stack:
                raise ValueError(f"{where}: {event.name} begins within {stack[-1]}")
            stack.append(event.name)
            counts["slices"] += 1
        elif event.type == TrackEvent.TYPE_INSTANT:
            counts["instants"] += 1
        else:
            raise ValueError(f"{where}: an event of type {event.type}")
    left = [f"{tracks[uuid]}: {stack}" for uuid, stack in open_slices.items() if stack]
    if left:
        raise ValueError(f"slices without an end: {left}")
    if not counts["slices"]:
        raise ValueError("nothing happened")
    return counts


if __name__ == "__main__":
    main(sys.argv[1:])
