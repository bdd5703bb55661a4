"""Dynamic models from records: chains of blocks, estimated, validated and simulated."""
