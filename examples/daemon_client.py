#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""A client of im2fitd (docs/daemon.md), with Python's standard library alone.

  daemon_client.py                        prints the events: guidance, measurements, who left
  daemon_client.py consent                the person before the screen consents; prints until the measurement
  daemon_client.py known weight_kg=80     what the person knows of themselves
  daemon_client.py avatar FILE.glb        writes the avatar of the person measured last (.glb, .obj or .bvh)
  daemon_client.py mask FILE.png          writes the person's pixels of the next frame
  daemon_client.py reset | delete | users | select_user ID
"""
import base64
import json
import os
import socket
import sys

SOCKET = os.environ.get("IM2FITD_SOCKET", "/run/im2fitd/events.sock")
PROTOCOL = "im2fitd/1"


class Daemon:
    """The events of the service, in order. ask() sends a command and waits for its answer."""

    def __init__(self, path=SOCKET):
        self.socket = socket.socket(socket.AF_UNIX)
        self.socket.connect(path)
        self.lines = self.socket.makefile("r", encoding="utf-8")
        self.sent = 0
        hello = next(self.events())
        if hello["protocol"] != PROTOCOL:
            raise RuntimeError(f"the service speaks {hello['protocol']}, this client {PROTOCOL}")
        self.commands = hello.get("commands", ["known"])

    def events(self):
        for line in self.lines:
            yield json.loads(line)

    def ask(self, command, value=None):
        """The answer has the id of the command; events of others come between."""
        if command not in self.commands:
            raise RuntimeError(f"this service has no {command}, but {', '.join(self.commands)}")
        self.sent += 1
        mine = f"{os.getpid()}-{self.sent}"
        line = json.dumps({command: {} if value is None else value, "id": mine})
        self.socket.sendall(line.encode() + b"\n")
        for event in self.events():
            if event.get("id") == mine:
                if event["event"] == "refused":
                    raise RuntimeError(event["reason"])
                return event
        raise RuntimeError("the service has ended")


def show(event):
    """One event in words; None for those that a person need not see."""
    if event["event"] == "measured":
        values = event["result"]["measurements"]
        return ", ".join(f"{name} {values[name]['value']:.0f} {values[name]['unit']}"
                         for name in ("stature", "chest_girth", "waist_girth", "hip_girth", "weight") if name in values)
    if event["event"] == "state":
        return " ".join([event["state"], *event["guidance"]])
    if event["event"] in ("visit", "camera"):
        return f"{event['event']} {event['state']}"
    return event["event"]


def main(words):
    daemon = Daemon()
    command = words[0] if words else ""
    if command in ("avatar", "mask"):
        name = words[1]
        if command == "avatar":
            data = daemon.ask("avatar", {"format": name.rsplit(".", 1)[-1]})["base64"]
        else:
            data = daemon.ask("mask")["png"]
        with open(name, "wb") as file:
            file.write(base64.b64decode(data))
    elif command == "known":
        pairs = (word.split("=", 1) for word in words[1:])
        daemon.ask("known", {key: float(value) if key in ("height_mm", "weight_kg", "age") else value
                             for key, value in pairs})
    elif command == "select_user":
        daemon.ask("select_user", int(words[1]))
    elif command in ("reset", "delete"):
        daemon.ask(command)
    elif command == "users":
        for user in daemon.ask("users")["users"]:
            print(json.dumps(user))
    elif command not in ("", "consent"):
        raise RuntimeError(f"there is no command {command}; see --help")
    else:
        if command == "consent":
            daemon.ask("consent")
        for event in daemon.events():
            print(show(event), flush=True)
            if event["event"] == "measured" and command == "consent":
                return
        raise RuntimeError("the service has ended")


if __name__ == "__main__":
    if sys.argv[1:2] in (["-h"], ["--help"]):
        print(__doc__.strip())
    else:
        try:
            main(sys.argv[1:])
        except (OSError, RuntimeError, IndexError, ValueError) as error:
            sys.exit(f"daemon_client: {error}")
