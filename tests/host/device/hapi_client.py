# SPDX-License-Identifier: GPL-2.0-or-later
# Haply's own Python client at a port, used as its README does: sets the board up, sends a force, prints what it reads.
# hapi_client.py PORT VERSION FORCE_X FORCE_Y
import sys
import time

from HaplyHAPI import Board, Device, Pantograph

CW, CCW = 0, 1
port, version, force = sys.argv[1], int(sys.argv[2]), [float(sys.argv[3]), float(sys.argv[4])]

board = Board("test", port, 0)
device = Device(5, board)
device.set_mechanism(Pantograph(version))
if version == 3:
    device.add_actuator(1, CCW, 2)
    device.add_actuator(2, CCW, 1)
    device.add_encoder(1, CCW, 168, 4880, 2)
    device.add_encoder(2, CCW, 12, 4880, 1)
else:
    device.add_actuator(1, CCW, 2)
    device.add_actuator(2, CW, 1)
    device.add_encoder(1, CCW, 241, 10752, 2)
    device.add_encoder(2, CW, -61, 10752, 1)
device.device_set_parameters()

device.set_device_torques([0, 0])
device.device_write_torques()
for _ in range(20):
    deadline = time.monotonic() + 5
    while not board.data_available():
        if time.monotonic() > deadline:
            sys.exit("no answer")
        time.sleep(0.0005)
    device.device_read_data()
    position = device.get_device_position(device.get_device_angles())
    torques = device.set_device_torques(force)
    device.device_write_torques()
print(*position, *torques)
