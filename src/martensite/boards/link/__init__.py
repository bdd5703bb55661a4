"""The link between a host and a board: frames, messages, what was lost on the way."""
