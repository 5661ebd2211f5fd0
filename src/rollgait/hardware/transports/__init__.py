"""How bytes travel: within a process, by DDS, by Foxglove's WebSocket."""
