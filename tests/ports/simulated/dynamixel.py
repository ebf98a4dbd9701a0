"""dynamixel-sdk, as it is, pings a servo whose adapter holds bytes back: its own time-out is the referee. Argument: the port."""

import sys
import time

from dynamixel_sdk import PacketHandler, PortHandler

port, packets = PortHandler(sys.argv[-1]), PacketHandler(1.0)
assert port.openPort() and port.setBaudRate(57600)
# The board boots: opening the port has reset it.
time.sleep(2)
model, result, error = packets.ping(port, 1)
print(packets.getTxRxResult(result), model, error)
