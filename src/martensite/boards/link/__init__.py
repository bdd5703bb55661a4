"""Link between a host and a board: frames, messages, counters."""
