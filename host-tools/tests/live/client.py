"""WebSocket clients that share nothing with gmr (PyPI's websockets) look on while `gmr record` writes a log, and leave as they please.

    python client.py GMR PORT FOLDER

A board is at PORT. What the clients get is held against run.mcap, as the reader of MCAP's makers (PyPI's mcap) reads it: the channel, its schema, and
every message with its time, byte by byte. Ends with 0 and what it found, or with the assertion that did not hold.

https://github.com/foxglove/foxglove-sdk, rust/foxglove/src/protocol: a server's message in JSON has an `op`, one with data is 0x01, the subscription (u32),
the time (u64, ns) and the message, little-endian.
"""

import asyncio
import json
import pathlib
import struct
import subprocess
import sys

import websockets
from mcap.reader import make_reader

SUBPROTOCOL = "foxglove.sdk.v1"
SECONDS = 8
RATE_HZ = 200
SUBSCRIPTION = 7


async def started(gmr, port, folder):
    """A recording, and where it says that it listens."""
    command = ["record", "--port", port, "--out", "run.mcap", "--duration", str(SECONDS), "--foxglove", "127.0.0.1:0", "--json"]
    pipe = asyncio.subprocess.PIPE
    running = await asyncio.create_subprocess_exec(gmr, *command, cwd=folder, stdout=pipe, stderr=pipe)
    line = (await running.stderr.readline()).decode().strip()
    assert line.startswith("live view: ws://127.0.0.1:"), line
    return running, line.removeprefix("live view: ")


async def subscribed(url):
    """A client, and the only channel that it is offered."""
    client = await websockets.connect(url, subprotocols=[SUBPROTOCOL], compression=None)
    assert client.subprotocol == SUBPROTOCOL
    info = json.loads(await client.recv())
    assert info["op"] == "serverInfo" and info["name"] == "gmr record", info
    while (offer := json.loads(await client.recv()))["op"] != "advertise":
        pass
    (channel,) = offer["channels"]
    wanted = {"op": "subscribe", "subscriptions": [{"id": SUBSCRIPTION, "channelId": channel["id"]}]}
    await client.send(json.dumps(wanted))
    return client, channel


async def messages(client, seconds):
    """(time, message) of what comes within so long, or until the server goes."""
    got = []
    try:
        async with asyncio.timeout(seconds):
            async for data in client:
                if isinstance(data, str):
                    continue
                op, subscription, time = struct.unpack_from("<BIQ", data)
                assert (op, subscription) == (1, SUBSCRIPTION), data[:13]
                got.append((time, data[13:]))
    except (TimeoutError, websockets.ConnectionClosed):
        pass
    return got


def logged(file):
    """The same out of the log."""
    with open(file, "rb") as stream:
        found = list(make_reader(stream).iter_messages())
    assert len({channel.id for _, channel, _ in found}) == 1
    return found[0][0], found[0][1], [(message.log_time, message.data) for _, _, message in found]


def unbroken(part, whole):
    """Where `part` stands in `whole`."""
    place = whole.index(part[0])
    assert whole[place : place + len(part)] == part, f"from message {place} on they differ"
    return place


async def look_on(gmr, port, folder):
    running, url = await started(gmr, port, folder)
    taken = subprocess.run(
        [gmr, "record", "--port", port, "--out", "no.mcap", "--foxglove", url.removeprefix("ws://")], cwd=folder, capture_output=True, text=True
    )
    assert taken.returncode == 2 and taken.stderr.count("\n") == 1 and "--foxglove 127.0.0.1:" in taken.stderr, taken.stderr
    # Subscribes and never reads: its queue fills, and nobody waits for it.
    silent, _ = await subscribed(url)
    silent.transport.pause_reading()
    first, channel = await subscribed(url)
    early = await messages(first, 2)
    # As if its machine died: no farewell.
    first.transport.abort()
    again, offered_again = await subscribed(url)
    late = await messages(again, SECONDS)
    report, said = await running.communicate()
    assert running.returncode == 0, said.decode()
    report = json.loads(report)
    assert (report["rows"], report["lost"], report["ended"]) == (SECONDS * RATE_HZ, 0, "complete"), report
    return channel, offered_again, early, late


def main():
    gmr, port, folder = sys.argv[1:]
    channel, offered_again, early, late = asyncio.run(look_on(gmr, port, folder))
    schema, written, log = logged(pathlib.Path(folder) / "run.mcap")
    expected = {
        "topic": written.topic, "encoding": written.message_encoding, "schemaName": schema.name, "schemaEncoding": schema.encoding,
        "schema": schema.data.decode(),
    }
    for offer in (channel, offered_again):
        assert {key: offer[key] for key in expected} == expected, offer
    assert set(json.loads(log[-1][1])) <= set(json.loads(schema.data)["properties"])
    assert len(log) == SECONDS * RATE_HZ
    # A client that reads gets every message from its subscription on, in two seconds and in what is left of the recording.
    assert len(early) > RATE_HZ and len(late) > 2 * RATE_HZ, (len(early), len(late))
    places = unbroken(early, log), unbroken(late, log)
    assert places[1] >= places[0] + len(early), places
    # What is under way when the recording ends may be cut off.
    assert places[1] + len(late) > len(log) - RATE_HZ, (places, len(late))
    print(f"{len(early)} messages from number {places[0]} on, and {len(late)} from {places[1]} on, are those of the log's {len(log)}")


if __name__ == "__main__":
    main()
