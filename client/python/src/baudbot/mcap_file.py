"""The messages of a recording's file, one after the other; damaged parts are skipped."""

from __future__ import annotations

import os
import struct
from collections.abc import Callable, Container, Iterator
from io import BufferedReader
from pathlib import Path

from mcap.exceptions import McapError
from mcap.records import Channel, Chunk, Footer, McapRecord, Message
from mcap.stream_reader import StreamReader, breakup_chunk

from .errors import Error, NotARecording, NotFound

#: What the package `mcap`, and what it unpacks with, raise about bytes that are not as they were written.
_BROKEN = (McapError, struct.error, ValueError, RuntimeError, OverflowError, MemoryError)

#: Is told at which byte of a file something is damaged, and whether more is read after it.
Damaged = Callable[[int, bool], None]


def messages(path: Path, wanted: Container[str], damaged: Damaged) -> Iterator[tuple[str, bytes]]:
    """The topic and the bytes of each message on the wanted topics, in the order of the file.

    A chunk that does not match its checksum is left out. Where a file ends before its end record, or is damaged between two
    chunks, nothing more is read.
    """
    try:
        with path.open("rb") as file:
            yield from _messages(file, path, wanted, damaged)
    except FileNotFoundError:
        raise NotFound(f"{path}: there is no such file") from None
    except OSError as error:
        raise Error(f"{path}: cannot be read: {error.strerror or error}") from None


def _messages(file: BufferedReader, path: Path, wanted: Container[str], damaged: Damaged) -> Iterator[tuple[str, bytes]]:
    # No record is longer than its file, whatever it says of itself.
    records = StreamReader(file, emit_chunks=True, record_size_limit=os.fstat(file.fileno()).st_size).records
    topics: dict[int, str] = {}
    while True:
        at = file.tell()
        try:
            record = next(records)
        except _BROKEN:
            if at == 0:
                raise NotARecording(f"{path}: is not an MCAP file: its header is missing") from None
            damaged(at, False)
            return
        if isinstance(record, Footer):
            return
        parts: list[McapRecord] = [record]
        if isinstance(record, Chunk):
            try:
                parts = breakup_chunk(record, validate_crc=True)
            except _BROKEN:
                damaged(at, True)
                continue
        for part in parts:
            if isinstance(part, Channel):
                topics[part.id] = part.topic
            elif isinstance(part, Message) and (topic := topics.get(part.channel_id, "")) in wanted:
                yield topic, part.data
