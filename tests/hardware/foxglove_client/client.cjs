// Reads all topics of a server until each has said something, prints the first message of each as JSON, and
// publishes a velocity. Everything but this script is Foxglove's own: protocol, definitions, CDR.
"use strict";
const { FoxgloveClient } = require("@foxglove/ws-protocol");
const { parse } = require("@foxglove/rosmsg");
const { MessageReader, MessageWriter } = require("@foxglove/rosmsg2-serialization");
const WebSocket = require("ws");

const [url, wanted, definition] = process.argv.slice(2);
const missing = new Set(JSON.parse(wanted));
const found = {};
const readers = new Map();

function plain(_, value) {
  if (typeof value === "bigint") return Number(value);
  return ArrayBuffer.isView(value) ? Array.from(value) : value;
}

// the client's constant names the protocol as it was called before; servers of today have it by this name
const client = new FoxgloveClient({ ws: new WebSocket(url, ["foxglove.sdk.v1"]) });
client.on("error", (error) => { console.error(error); process.exit(1); });
client.on("advertise", (channels) => {
  for (const channel of channels)
    readers.set(client.subscribe(channel.id), [channel.topic, new MessageReader(parse(channel.schema, { ros2: true }))]);
});
client.on("message", ({ subscriptionId, data }) => {
  const [topic, reader] = readers.get(subscriptionId);
  found[topic] ??= reader.readMessage(data);
  missing.delete(topic);
});
client.on("serverInfo", () => {
  const own = client.advertise({ topic: "/cmd_vel", encoding: "cdr", schemaName: "geometry_msgs/msg/Twist" });
  const writer = new MessageWriter(parse(definition, { ros2: true }));
  const zero = { x: 0, y: 0, z: 0 };
  const twist = writer.writeMessage({ linear: { ...zero, x: 0.25 }, angular: zero });
  setInterval(() => {
    client.sendMessage(own, twist);
    if (missing.size === 0) process.stdout.write(JSON.stringify(found, plain), () => process.exit(0));
  }, 50);
});
