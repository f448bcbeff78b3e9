# SPDX-License-Identifier: GPL-2.0-or-later
# Haply's service, as its clients know it: greets with its devices, then answers each message with a state. It prints its
# port, then every force that it was given.
# inverse3_service.py MODE X Y Z: what it does besides, and where the cursor is, m:
#   plain; greeting (no state in it); garbage (between its states); silent, closes (after 50 messages); empty (no device)
import asyncio
import json
import sys

import websockets

mode, x, y, z = sys.argv[1], *map(float, sys.argv[2:5])
GARBAGE = ["", "{", "null", "[1, 2]", '{"inverse3": 5}', '{"inverse3": [{"device_id": 7}]}',
           '{"inverse3": [{"device_id": "04BA", "state": {"cursor_position": {"x": "1", "y": 0, "z": 0}}}]}',
           '{"inverse3": [{"device_id": "other", "state": {"cursor_position": {"x": 9, "y": 9, "z": 9}}}]}',
           '{"inverse3": [{"device_id": "04BA", "state": {"cursor_position": {"x": 9, "y": 9, "z": 9}}}]}',
           '{"inverse3": [{"device_id": "04BA"}]}', b"\x00\xff\xfe", "x" * 1_100_000]


def message(buttons, with_state=True):
    device = {"device_id": "04BA", "config": {"handedness": "right"}}
    if with_state:
        device["state"] = {"cursor_position": {"x": x, "y": y, "z": z}, "cursor_velocity": {"x": 0.0, "y": 0.0, "z": 0.0}}
    grip = {"device_id": "61548", "state": {"buttons": {"a": buttons, "b": False, "c": False}}}
    return json.dumps({"inverse3": [] if mode == "empty" else [device], "wireless_verse_grip": [grip]})


async def session(socket):
    await socket.send(message(False, mode != "greeting"))
    count = 0
    async for text in socket:
        count += 1
        command = json.loads(text)["inverse3"][0]
        assert command["device_id"] == "04BA"
        force = command["commands"]["set_cursor_force"]["values"]
        print("force", force["x"], force["y"], force["z"], flush=True)
        if mode == "silent" and count > 50:
            continue
        if mode == "closes" and count > 50:
            return
        if mode == "garbage":
            await socket.send(GARBAGE[count % len(GARBAGE)])
            await asyncio.sleep(0.005)  # of two texts that wait only the newer one is read
        await socket.send(message(count > 100))


async def main():
    async with websockets.serve(session, "127.0.0.1", 0) as server:
        print("port", server.sockets[0].getsockname()[1], flush=True)
        await asyncio.Future()


asyncio.run(main())
