"""Asks as asks.py, with asyncio, a pipe to oneself, and a child. Argument: the port."""

import asyncio
import os
import sys
import time

import serial


async def main() -> None:
    port = serial.Serial(sys.argv[-1], 9600, stopbits=serial.STOPBITS_TWO, timeout=0)
    loop, heard = asyncio.get_running_loop(), asyncio.Queue()
    loop.add_reader(port.fileno(), lambda: heard.put_nowait(os.read(port.fileno(), 64)))
    child = await asyncio.create_subprocess_exec("sleep", "0.1")
    for _ in range(5):
        begun, line = time.monotonic_ns(), b""
        port.write(b"N\r")
        while not line.endswith(b"\n"):
            line += await asyncio.wait_for(heard.get(), 1)
        print(len(line), time.monotonic_ns() - begun)
        await asyncio.sleep(0.02)
    assert await child.wait() == 0


asyncio.run(main())
